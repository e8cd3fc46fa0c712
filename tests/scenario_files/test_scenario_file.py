"""The scenario file: read, compared, refused by the path of its key and never by a traceback."""

import json
import math
import tomllib
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.units import RPM
from gyrostat.runs.build_parts import named_parts
from gyrostat.scenario import Scenario
from gyrostat.scenario.build_spacecraft import spacecraft_of
from gyrostat.scenario.component import Context
from gyrostat.scenario.error_sources import error_sources
from gyrostat.scenario.kinds.wheel_disturbances import imbalance_of
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.wheel import read_wheel_sheet

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"


@pytest.fixture
def variant(folder, tmp_path):
    """Write the small scenario with lines replaced, and read it."""

    def make(*changes, more=""):
        for name in ("cubesat.toml", "cubesat_wheel.toml"):
            (tmp_path / name).write_text((folder / name).read_text())
        text = (folder / "scenario.toml").read_text()
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "scenario.toml"
        path.write_text(text + more)
        return path

    return make


def test_values_are_in_si(scenario):
    values = scenario.values
    assert scenario.count == 120
    assert scenario.substeps == 1
    assert values["start.attitude_error.x"] == pytest.approx(math.radians(0.2))
    assert values["wheel.b.speed"] == pytest.approx(-200.0 * RPM)
    assert values["wheel.d.torque_limit"] == 1e-3
    assert values["wheel.a.coulomb"] == 2e-5
    assert values["body.inertia.yy"] == 0.12
    assert values["sensors.wheel_sigma"] == pytest.approx(2e-6)
    assert values["compensator.share"] == 1.0
    assert values["wheel.c.static_imbalance"] == pytest.approx(5e-7)  # one for all
    assert values["wheel.b.dynamic_imbalance"] == pytest.approx(2e-9)
    assert values["wheel.b.position.x"] == -0.05
    assert values["wheel.d.angle"] == 0.0
    assert values["wheel.a.current_limit"] == pytest.approx(0.01)
    assert values["wheel.a.motor_constant"] == 5e-3  # of its model file
    assert [event.name for event in scenario.events] == ["loss", "worn", "turn"]  # by time
    assert np.linalg.norm(scenario.axes, axis=1) == pytest.approx(1.0)
    assert scenario.dispersed[:2] == ("wheel.a.coulomb", "wheel.b.coulomb")


def test_the_text_gives_the_same_scenario(scenario):
    again = Scenario.from_text(scenario.text())
    assert asdict(again) == asdict(scenario)
    assert again.digest() == scenario.digest()


def test_the_digest_looks_at_the_content_alone(scenario, variant):
    path = variant(('"30 s"', "30.0 # seconds"), ('"0.25 s"', '"250 ms"'))
    assert read_scenario(path).digest() == scenario.digest()
    assert read_scenario(variant(("turn_gain = 0.4", ""))).digest() != scenario.digest()


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (
            ("duration =", "durration ="),
            "key run.durration: found an unknown key (did you mean run.d",
        ),
        (
            ("[sensors]", "[sensor]"),
            "key sensor: found a table [sensor], expected [sensors], or tables [[sensor]]",
        ),
        (
            ("turn_gain", "turn_gian"),
            "key controller.turn_gian: found an unknown key (did you mean",
        ),
        (('"30 s"', '"30 kg"'), "key run.duration '30 kg': found unit 'kg'"),
        (('"30 s"', '"-30 s"'), "key run.duration: found '-30 s', expected above 0, in s"),
        (('"30 s"', "30.1"), "key run.duration: found 30.1, expected a whole multiple"),
        (('"0.25 s"', "1e-20"), "key run.duration: found 30.0, expected a whole multiple"),
        (('"three_axis"', '"two_axis"'), "key controller.kind: found 'two_axis', expected one of"),
        (('"cubesat.toml"', '"cube.toml"'), "cube.toml: found no such file"),
        (('"cubesat.toml"', "3"), "key spacecraft.file: found 3, expected a text"),
        (('["1 µN·m", 0.0, 0.0]', "[1.0, 2.0]"), "key environment.external_torque: found"),
        (('["1 µN·m", 0.0, 0.0]', "[nan, 0, 0]"), "key environment.external_torque[0]: found nan"),
        (('"30 rpm", ', ""), "key start.wheel_speed: found 3 values, expected one or 4"),
        (('kind = "slew"', 'kind = "slow"'), "key event[turn].kind: found 'slow', expected one of"),
        (('wheel = "c"', 'wheel = "e"'), "key event[loss].wheel: found no wheel 'e'"),
        (
            ('detected_after = "1 s"', 'torque = "1 N·m"'),
            "key event[loss].torque: found an unknown",
        ),
        (('time = "8 s"', ""), "key event[loss].time: found none, expected 0 or more, in s"),
        (
            ("0.0, 0.002]", "0.0, 0.2]"),
            "key event[turn].target: found [1.0, 0.0, 0.0, 0.2], expected",
        ),
        (
            ("[1.0, 0.0, 0.0]", "[0, 0, 0]"),
            "key metrics.boresight: found [0, 0, 0], expected a dir",
        ),
        (
            ("wheel.*.coulomb", "wheel.*.colomb"),
            "dispersion[0].key: found 'wheel.*.colomb', expected",
        ),
        (("wheel.*.coulomb", "wheel.a.speed"), "key dispersion[3].key: found 'wheel.a.speed'"),
        (('"log_normal"', '"cauchy"'), "key dispersion[0].distribution: found 'cauchy', expected"),
        (('"30 %"', '"a %"'), "key dispersion[0].sigma: found 'a %', expected a percentage"),
        (('"30 %"', "-1"), "key dispersion[0].sigma: found -1, expected a sigma"),
        (
            ('low = "6 s"', 'low = "60 s"'),
            "key dispersion[2].high: found '10 s', expected more than",
        ),
        (
            ('low = "6 s"', 'low = "-6 s"'),
            "key dispersion[2].low: found '-6 s', expected event.loss",
        ),
        (('time = "8 s"', "time = 30"), "key event.loss.time: found 30 s, expected a time before"),
        (('after = "2 s"', "after = 31"), "key metrics.after: found 31 s, expected a time before"),
        (('"0.5 g·mm"', '"-1 g·mm"'), "key imbalance.static_imbalance: found '-1 g·mm', expected"),
        (('"0.5 g·mm"', '"1 g·mm²"'), "key imbalance.static_imbalance '1 g·mm²': found unit"),
        (('"2 g·mm²", ', ""), "key imbalance.dynamic_imbalance: found 3 values, expected one or 4"),
        (("1e-9, 1e-9", "1e-9, true"), "key imbalance.dynamic_imbalance[3]: found True, expected"),
        (("[[0.05, 0.05, 0.05]", "[[0.05]"), "key imbalance.position[0]: found [0.05], expected 3"),
        (("[driver]", "[driver]\nresistance = 1\nbus = 5"), "key driver.bus: found an unknown key"),
        (("[driver]", "[driver]\nbus_voltage = 5"), "driver resistance: found 0 Ω, expected more"),
        (('"10 mA"', '"0 mA"'), "key driver.current_limit[0]: found '0 mA', expected above 0"),
        (('factor = 3.0\ncoulomb = "50 µN·m"', ""), "key event[worn].factor: found none, expected"),
        (("factor = 3.0", "factor = -3.0"), "key event[worn].factor: found -3.0, expected 0 or"),
        (("factor = 3.0", "stribek = 1"), "key event[worn].stribek: found an unknown key (did you"),
        (("factor = 3.0", "stribeck_speed = 0"), "key event[worn].stribeck_speed: found 0"),
        (('wheel = "b"', 'wheel = "f"'), "key event[worn].wheel: found no wheel 'f'"),
        (("[imbalance]", "[inbalance]"), "did you mean imbalance?"),
        (('"20 rpm"', '"0 %"'), "key dispersion[3].sigma: found '0 %', expected a sigma"),
        (
            ("turn_gain = 0.4", "turn_gain = 1e308"),
            "turn_gain: found 1e+308, expected a finite num",
        ),
        (('["30 rpm",', '["90000 rpm",'), "speed of wheel 0: found 9424.78 rad/s"),
        (('"2 µN·m·s"', '"2 µN·m·s"\ntachometer_lag = -1'), "tachometer_lag: found -1, expected 0"),
    ],
)
def test_bad_input_names_the_key(variant, change, found):
    path = variant(change)
    with pytest.raises(InputError) as refused:
        read_scenario(path)
    message = str(refused.value)
    assert found in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ('until = "31 s"', "until: found 31 s, expected at most the end of the run, 30 s"),
        ('from = "30 s"', "from: found 30 s, expected a time before the end of the run, 30 s"),
        ('from = "5 s"\nuntil = "4 s"', "until: found 4 s, expected a time after its start, 5 s"),
        ('mode = "track"', "mode: found 'track', expected none: this scenario has no mode"),
        ('event = "trun"', "event: found 'trun', expected one of"),
        (
            'event = "turn"\nfrom = "12 s"',
            "from: found 12 s after 18 s, expected a time before the end",
        ),
        (
            'event = "turn"\nuntil = "13 s"',
            "until: found 13 s after 18 s, expected at most the end",
        ),
        ('exposure = "31 s"', "exposure: found 31.0, expected at most the length of the window"),
        ('from = "28 s"\nexposure = "3 s"', "expected at most the length of the window, 2 s"),
        ('exposure = "0.3 s"', "exposure: found 0.3, expected a whole multiple of the control"),
        ('jitter_above = "2 Hz"', "jitter_above: found 2.0, expected below 2 Hz, half of"),
        ('jitter_above = "1 Hz"\njitter_below = "1 Hz"', "jitter_below: found 1.0, expected more"),
        ('jitter_below = "1 Hz"', "jitter_above: found None, expected the lower end of the band"),
        ('jitter_above = "1 rpm"', "jitter_above '1 rpm': found unit 'rpm', expected a unit of fr"),
        ('dwell_above = "9 rpm"', "dwell_below: found None, expected the upper end of the band"),
        ("dwell_above = 2\ndwell_below = 1", "dwell_below: found 1.0, expected more than dwell"),
        ("propellant = 3", "propellant: found 3, expected a text"),
        ("boresight = [0, 0, 0]", "boresight: found [0, 0, 0], expected a direction"),
        ('untill = "3 s"', "untill: found an unknown key (did you mean"),
    ],
)
def test_a_bad_window_is_refused_in_one_line(variant, rows, found):
    with pytest.raises(InputError) as refused:
        read_scenario(variant(more=f'[[metrics.window]]\nname = "w"\n{rows}\n'))
    message = str(refused.value)
    assert "key metrics.window[w]." in message
    assert found in message
    assert "\n" not in message


@pytest.mark.parametrize("name", ["wheel", "imaging", "a.b", "window", "run"])
def test_the_name_of_a_window_is_no_other_name(variant, name):
    with pytest.raises(
        InputError, match=r"window\[2\].name: found .*, expected a unique name with"
    ):
        read_scenario(variant(more=f'[[metrics.window]]\nname = "{name}"\n'))


def test_smear_needs_a_boresight(variant):
    change = ("boresight = [1.0, 0.0, 0.0]", "")
    more = '[[metrics.window]]\nname = "w"\nexposure = "1 s"\n'
    with pytest.raises(InputError, match=r"\[w\].boresight: found None, expected the direction"):
        read_scenario(variant(change, more=more))


def test_windows_can_be_given_in_python(scenario):
    made = scenario.replace(
        windows={"late": {"from": "10 s", "event": "turn"}, "all": {}},
        dispersions=(),
        requirements=[],
    )
    assert [window.name for window in made.windows] == ["late", "all"]
    assert made.windows[0].event == "turn"
    assert made.values["window.late.from"] == 10.0
    assert not any(key.startswith("window.imaging") for key in made.values)
    with pytest.raises(
        InputError,
        match=r"window\[w\].until: found 31 s, expected at most the end of the run, 30 s",
    ):
        scenario.replace(windows={"w": {"until": 31.0}}, dispersions=())
    with pytest.raises(InputError, match=r"window\[imaging\].event: found 'worn', expected one of"):
        scenario.replace(events=scenario.events[2:], dispersions=())
    with pytest.raises(InputError, match="key windows: found 3, expected"):
        scenario.replace(windows=3)
    with pytest.raises(InputError, match=r"dispersion of window.imaging.from"):
        scenario.replace(windows={})


def test_metrics_have_names_units_and_windows(scenario):
    metrics = metrics_of(scenario)
    assert [*metrics][:4] == ["error_p50", "error_p95", "error_p99.7", "error_max"]
    assert metrics["imaging.dwell.c"].unit == "1"
    assert metrics["imaging.smear"].unit == "rad"
    assert metrics["turning.error_p95"].window == "turning"
    assert "turning.smear" not in metrics
    assert "turning.rotation_max" in metrics  # by the boresight of the whole run


def test_a_second_loss_leaves_too_few_wheels(variant):
    more = "".join(
        f'[[event]]\nname = "{w}"\nkind = "seized"\nwheel = "{w}"\ntime = 20\n' for w in "ab"
    )
    with pytest.raises(InputError, match=r"key event\[a\]: found working wheels that do not span"):
        read_scenario(variant(more=more))


def test_harmonics_and_structure_of_the_wheels_reach_the_plant(variant):
    more = (
        '[[imbalance.harmonic]]\nname = "cage"\nnumber = 0.42\nforce = "0.1 g·mm"\n'
        '[[imbalance.harmonic]]\nnumber = 2\ntorque = "1 g·mm²"\nphase = "90 deg"\n'
        '[wheel_structure]\nrocking_frequency = ["70 Hz", "80 Hz", "80 Hz", "80 Hz"]\n'
    )
    scenario = read_scenario(variant(more=more))
    numbers = {key: jnp.asarray(value) for key, value in scenario.values.items()}
    structure = structure_of(scenario)
    context = Context(spacecraft=spacecraft_of(structure, numbers))
    harmonics = named_parts(structure, numbers, "imbalance.harmonic", context)
    found = imbalance_of(structure, numbers, list(harmonics.values()))
    np.testing.assert_allclose(found.harmonics.number, [0.42, 2.0])
    np.testing.assert_allclose(found.harmonics.force, [[1e-7] * 4, [0.0] * 4], atol=1e-20)
    np.testing.assert_allclose(found.harmonics.phase[1], np.pi / 2)
    np.testing.assert_allclose(found.structure.rocking_frequency[:2], [140 * np.pi, 160 * np.pi])
    assert np.all(np.isinf(found.structure.radial_frequency))
    found.check()
    path = variant(more="[wheel_structure]\n")
    text = path.read_text()
    start = text.index("[imbalance]")
    path.write_text(text[:start] + text[text.index("\n[", start) :])
    with pytest.raises(InputError, match=r"wheel_structure: found it without \[imbalance\]"):
        read_scenario(path)


def test_what_a_data_sheet_says_of_its_wheel_need_not_be_given_again(tmp_path):
    wheels = "".join(
        f'[[wheel]]\nname = "{name}"\naxis = {axis}\nsheet = "bct-rwp015"\n'
        for name, axis in zip("xyz", np.eye(3).tolist(), strict=True)
    )
    (tmp_path / "craft.toml").write_text(f"[body]\ninertia = [0.06, 0.12, 0.14]\n{wheels}")
    path = tmp_path / "scenario.toml"
    text = (
        "[run]\nduration = 10\ncontrol_period = 0.25\n[spacecraft]\nfile = 'craft.toml'\n"
        "[controller]\nkind = 'wheel_array'\n[imbalance]\ndynamic_imbalance = 3e-9\n"
    )
    path.write_text(text)
    values = read_scenario(path).values
    sheet = read_wheel_sheet("bct-rwp015").values
    assert values["wheel.y.static_imbalance"] == sheet["static_imbalance"] > 0.0
    assert values["wheel.y.dynamic_imbalance"] == 3e-9
    path.write_text(f"{text}[driver]\n")
    with pytest.raises(InputError, match=r"key driver\.motor_constant: found none, expected above"):
        read_scenario(path)


def test_a_wheel_may_fail_and_wear_once_each(variant):
    worn = '[[event]]\nname = "more"\nkind = "friction_step"\nwheel = "{}"\nfactor = 2\ntime = 20\n'
    assert len(read_scenario(variant(more=worn.format("c"))).events) == 4
    with pytest.raises(InputError, match="expected one failure and one friction step per wheel"):
        read_scenario(variant(more=worn.format("b")))


def test_the_covariance_of_a_fit_is_taken_over(variant, tmp_path):
    names = ["motor_constant", "viscous", "coulomb"]
    sigma, rho = [1e-4, 1e-8, 2e-6], [[1.0, 0.1, 0.2], [0.1, 1.0, -0.8], [0.2, -0.8, 1.0]]
    fit = {
        "parameters": {n: {"value": 1.0, "sigma": s} for n, s in zip(names, sigma, strict=True)},
        "correlation": {"names": names, "matrix": rho},
    }
    path = variant(("wheel.*.coulomb", "wheel.b.coulomb"))
    (tmp_path / "fit.json").write_text(json.dumps(fit))
    path.write_text(path.read_text() + '[[dispersion]]\nfit = "fit.json"\nwheel = "a"\n')
    found = read_scenario(path).dispersions[-1]
    assert found.keys == tuple(f"wheel.a.{name}" for name in names)
    root = np.array(found.parameters)
    expected = np.outer(sigma, sigma) * np.array(rho)
    np.testing.assert_allclose(root @ root.T, expected, rtol=1e-12)
    for mark, why in (
        ({"converged": False}, "did not converge"),
        ({"impossible": ["b < 0"]}, "b < 0"),
    ):
        (tmp_path / "fit.json").write_text(json.dumps({**fit, **mark}))
        with pytest.raises(InputError, match=why):
            read_scenario(path)
    assert read_scenario(path, force=True).dispersions[-1] == found
    fit["correlation"]["matrix"] = "none"
    (tmp_path / "fit.json").write_text(json.dumps(fit))
    with pytest.raises(InputError, match=r"fit\.json: found no parameters with sigma"):
        read_scenario(path)


def leaves(table, path=()):
    """Paths of every value of a scenario."""
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from leaves(value, (*path, key))


ODD = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**400), 10**400),
    st.floats(),
    st.sampled_from(
        [1e300, -1e300, 5e-324, "", "20 %", "1e999 s", "-1 rpm", "1 parsec", "\0", "../.."]
    ),
    st.text(max_size=8),
    st.lists(st.floats(), max_size=4),
    st.dictionaries(st.text(max_size=4), st.integers(), max_size=2),
)


def written(value):
    """A TOML value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=True)
    if isinstance(value, list):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{written(k)} = {written(v)}" for k, v in value.items()) + "}"
    return repr(value)


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_odd_scenarios_are_read_or_refused_in_one_line(folder, data):
    table = tomllib.loads((folder / "scenario.toml").read_text())
    where = data.draw(st.sampled_from(sorted(leaves(table), key=str)))
    value = data.draw(ODD)
    inner = table
    for key in where[:-1]:
        inner = inner[key]
    if value is None and isinstance(inner, dict):
        inner[data.draw(st.text(max_size=6))] = inner.pop(where[-1])  # under another name
    elif value is not None:
        inner[where[-1]] = value
    path = folder / "odd.toml"
    try:
        path.write_text("\n".join(f"{written(k)} = {written(v)}" for k, v in table.items()))
    except UnicodeEncodeError:
        return
    try:
        read_scenario(path)
    except InputError as error:
        message = str(error)
        assert len(message.splitlines()) == 1
        assert "found" in message
        assert "expected" in message
        assert message.startswith(str(folder))


def test_the_page_lists_every_key_as_the_schema_has_it(module_at):
    docs = EXAMPLES.parents[1] / "docs"
    assert module_at(docs / "make_scenario.py").page() == (docs / "scenario.md").read_text()


GYRO = (
    ("angle_walk = 2e-5 ", 'angle_walk = "0.15 deg/√h" ', "sensors.angle_walk", 0.15 / 60.0),
    ("bias_walk = 1e-7 ", 'bias_walk = "3 deg/h/sqrt(h)" ', "sensors.bias_walk", 3.0 / 60.0**3),
    ('["0.002 deg/s",', '["10 °/hr",', "sensors.bias.x", 10.0 / 3600.0),
)
"""Text of wheel_array.toml, its replacement, key, value in deg and s."""


@pytest.fixture
def gyro_units(tmp_path):
    """Read the ready scenario wheel_array.toml with other texts; its sigmas are in deg/√h."""

    def make(*changes):
        text = (EXAMPLES / "wheel_array.toml").read_text()
        craft = EXAMPLES / "cubesat.toml"
        for old, new in (('"cubesat.toml"', f'"{craft}"'), *changes):
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "gyro.toml"
        path.write_text(text)
        return read_scenario(path)

    return make


def test_gyro_units_are_read_as_data_sheets_print_them(gyro_units):
    values = gyro_units(*((old, new) for old, new, *_ in GYRO)).values
    for *_, key, in_degrees in GYRO:
        assert values[key] == pytest.approx(math.radians(in_degrees), rel=1e-14)


@pytest.mark.parametrize(
    ("key", "sigma", "in_degrees"),
    [
        ("sensors.bias.z", "12 deg/h", 12.0 / 3600.0),
        ("sensors.angle_walk", "0.01 deg/sqrt(hr)", 0.01 / 60.0),
        ("sensors.bias_walk", "1 deg/h/√h", 1.0 / 60.0**3),
    ],
)
def test_the_sigma_of_a_dispersion_has_units_of_gyros(gyro_units, key, sigma, in_degrees):
    changes = (('"sensors.bias.z"', f'"{key}"'), ('"0.003 deg/s"\n\n', f'"{sigma}"\n\n'))
    (found,) = [d for d in gyro_units(*changes).dispersions if d.keys == (key,)]
    assert found.parameters[0][0] == pytest.approx(math.radians(in_degrees), rel=1e-14)


def test_errors_of_a_data_sheet_are_sources_of_the_error_budget(gyro_units):
    sheet = (
        'kind = "star_tracker_data_sheet_gyro"\nbias_instability = "0.5 deg/h"\n'
        'angle_resolution = "0.1 arcsec"\nnonorthogonality = ["0.1 mrad", 0.0, 0.0]\n'
        'scale_factor = ["300 ppm", 0.0, 0.0]'
    )
    found = gyro_units(('kind = "star_tracker_gyro"', sheet))
    assert found.values["sensors.scale_factor.x"] == pytest.approx(3e-4, rel=1e-14)
    keys = {each.name: [*each.keys] for each in error_sources(found)}
    assert keys["gyro bias instability"] == ["sensors.bias_instability"]
    assert keys["gyro resolution"] == ["sensors.angle_resolution"]
    assert keys["gyro misalignment"] == ["sensors.nonorthogonality.x"]


def test_faults_of_a_gyro_are_read_with_random_times_and_refused_for_an_attitude(gyro_units):
    fault = '[[event]]\nkind = "sensor_{}"\nsensor = "{}"\ntime = "9 s"\n{}\n[metrics]\n'
    late = (
        '[[dispersion]]\nkey = "event.3.time"\ndistribution = "uniform"\nlow = 0.0\nhigh = 20.0\n'
    )
    drift = fault.format("drift", "rate", 'axis = "y"\nslope = 2e-6')
    found = gyro_units(("[metrics]\n", f"{late}{drift}"))
    assert found.values["event.3.slope"] == 2e-6
    assert {each.name: each.element for each in found.events}["3"] == 1
    assert ("event.3.time",) in [each.keys for each in found.dispersions]
    scale = fault.format("scale", "wheel_speed", 'wheel = "b"\nfactor = -1.0')
    assert gyro_units(("[metrics]\n", scale)).values["event.3.factor"] == -1.0
    for kind, number in (("drift", "slope = 1.0"), ("scale", "factor = 2.0")):
        with pytest.raises(InputError, match="'attitude', expected one of rate, wheel_speed"):
            gyro_units(("[metrics]\n", fault.format(kind, "attitude", number)))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("angle_walk = 2e-5", 'angle_walk = "1 deg/h"', "'deg/h' is a unit of speed"),
        ('["0.002 deg/s",', '["1 deg/√h",', "'deg/√h' is a unit of angle random walk"),
        ("bias_walk = 1e-7", 'bias_walk = "1 deg/√h"', "expected a unit of rate random walk"),
    ],
)
def test_a_gyro_unit_of_another_quantity_is_refused(gyro_units, old, new, message):
    with pytest.raises(InputError, match=message):
        gyro_units((old, new))
