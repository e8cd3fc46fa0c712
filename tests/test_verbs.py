"""The verbs as functions: what they take, what they return, which files they write."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.verbs import arguments, wheel_arguments
from gyrostat.verbs.measurement_limits import measurement_limits

EXAMPLES = Path(__file__).parents[1] / "examples"
RPM = np.pi / 30.0
GAINS = (0.0571, 0.00234, 0.3126)


@pytest.fixture(scope="module")
def fit():
    return gs.identify(
        gs.read_record(EXAMPLES / "wheel_profile2.csv"), inertia=1.5e-3, speed_sigma="5 rpm"
    )


def test_sigma_is_looked_up_by_name_and_used_as_a_vector(fit):
    k = fit.names.index("coulomb")
    assert fit.sigma["coulomb"] == np.sqrt(fit.covariance[k, k]) == fit.sigma[k]
    assert isinstance(fit.sigma["coulomb"], float)
    np.testing.assert_array_equal(np.outer(fit.sigma, fit.sigma).diagonal(), fit.sigma**2)
    with pytest.raises(KeyError, match="expected one of motor_constant"):
        fit.sigma["columb"]
    with pytest.raises(KeyError):
        fit.sigma[::-1]["coulomb"]  # another order would give another parameter's


def test_a_fit_prints_what_the_command_line_prints_and_writes_its_files(fit, tmp_path):
    from gyrostat.reports.write import write_fit

    said = []
    write_fit(fit, tmp_path, command="test", say=said.append)
    assert said[:-1] == str(fit).splitlines()
    assert said[-1].startswith("written: ")
    assert "coulomb         (881.1 ± 4.2)e-06    N·m" in str(fit)
    assert str(fit) == repr(fit)
    wheel = gs.read_model(tmp_path / "model.toml").wheel()
    assert wheel.friction == fit.wheel().friction


def test_text_and_numbers_are_the_same_input(fit):
    other = gs.bench(fit, duration="20 s", speed_sigma=5.0 * RPM, seed=3)
    same = gs.bench(fit.wheel(), duration=20.0, speed_sigma="5 rpm", seed=3)
    np.testing.assert_array_equal(other.speed, same.speed)
    assert wheel_arguments.priors({"coulomb": (1e-3, "0.1 mN·m")}, "stribeck") == (
        wheel_arguments.priors("coulomb=1 mN·m:1e-4", "stribeck")
    )
    limits = measurement_limits("controller", {"rate": ("-2deg/s", 0.1)}, {"rate": 0.5})
    assert limits == measurement_limits("controller", ["rate=-2deg/s:0.1"], ["rate=0.5"])
    np.testing.assert_allclose(
        arguments.one_attitude("test", {"--euler": np.radians([90.0, 0.0, 0.0])}),
        arguments.one_attitude("test", {"--euler": "90deg,0,0"}),
        atol=1e-15,
    )
    assert arguments.quantities("1rpm, 2rpm", "speed", "x") == pytest.approx([RPM, 2.0 * RPM])
    assert arguments.quantities(np.array([1.0, 2.0]), "speed", "x") == [1.0, 2.0]
    assert arguments.quantities(3.0, "speed", "x") == [3.0]


def test_a_word_that_is_none_of_the_known_ones_is_refused(fit):
    record = fit.records[0]
    for call, found in (
        (
            lambda: gs.identify(record, method="bach"),
            "method: found 'bach', expected one of batch",
        ),
        (lambda: gs.identify(record, current_hold="cubic"), "current_hold: found 'cubic'"),
        (lambda: gs.validate(fit, record, current_hold="cubic"), "current_hold: found 'cubic'"),
        (lambda: gs.identify(record, method="coast", prior={"coulomb": (1, 1)}), "found prior"),
        (lambda: gs.identify(record, method="coast", free=np.array(["static"])), "found free"),
    ):
        with pytest.raises(gs.InputError, match=found):
            call()


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "5 rpn", "x"])
def test_a_quantity_that_is_none_is_refused(value):
    with pytest.raises(gs.InputError, match=r"--speed-sigma"):
        arguments.quantities(value, "speed", "--speed-sigma")


def test_a_prediction_takes_a_fit_and_writes_no_file(fit, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    record = gs.bench(fit, duration=60.0, speed_sigma="5 rpm", seed=1)
    said = []
    result = gs.validate(fit, record, say=said.append)
    assert result.converged
    assert result.rms_speed == pytest.approx(5.0 * RPM, rel=0.1)
    assert said[0].startswith("residual ")
    assert list(tmp_path.iterdir()) == []


def test_feasible_takes_mappings_and_arrays():
    craft = gs.read_spacecraft(EXAMPLES / "three_wheels.toml")
    momentum, target = np.array([0.46, -0.04, 0.82]), (1.0, 0.0, 0.0, 0.0)
    answer = gs.feasible(craft, momentum, failed={"x": "180 rpm"}, target=target)
    other = gs.feasible(
        EXAMPLES / "three_wheels.toml", "0.46,-0.04,0.82", failed="x=180rpm", euler="0,0,0"
    )
    assert answer.angle == other.angle > 0.0
    still = gs.feasible(craft, momentum, failed={"x": None}, target=target)
    assert still.angle != answer.angle
    bare = gs.feasible(craft.spacecraft, momentum, failed={0: "180 rpm"}, target=target)
    assert bare.angle == answer.angle
    with pytest.raises(gs.InputError, match="found no wheel 'q'"):
        gs.feasible(craft, momentum, failed={"q": None}, target=target)


def test_a_part_is_exported_as_its_design_from_options_is(fit, tmp_path):
    law = gs.AttitudePID(*GAINS)
    part = gs.CurrentMode(law, fit.wheel().motor_constant, 0.5)
    written = gs.export(part, tmp_path / "part", to="c", period=0.1)
    gs.export(
        fit,
        tmp_path / "options",
        to="c",
        what="controller",
        period="100 ms",
        gains=GAINS,
        current_limit="500 mA",
    )
    assert tmp_path / "part" / "controller.c" in written
    for path in (each for each in written if each.suffix == ".c"):
        other = tmp_path / "options" / path.relative_to(tmp_path / "part")
        texts = [each.read_text(encoding="utf-8") for each in (path, other)]
        # a part does not know the file of the wheel that it was designed for
        assert texts[0] == re.sub(r"\n.*model: SHA-256 [0-9a-f]{64}", "", texts[1])


def test_an_export_that_cannot_be_is_one_line_and_writes_nothing(fit, tmp_path):
    part = gs.CurrentMode(gs.AttitudePID(*GAINS), 0.02)
    out = tmp_path / "out"
    for model, words, found in (
        (part, {"to": "c"}, "what controller: missing period"),
        (part, {"to": "c", "period": 0.1, "what": "wheel"}, "expected controller"),
        (part, {"to": "c", "period": 0.1, "gains": np.array(GAINS)}, "found gains"),
        (part, {"to": "json"}, "found an object of CurrentMode"),
        (fit, {"to": "java"}, "expected one of basilisk, c"),
        (fit, {"to": "c", "delay": -1}, "delay: found -1"),
        (fit, {"to": "c", "period": 0.1, "what": "brake"}, "found 'brake'"),
        (gs.AttitudePID(*GAINS), {"to": "c"}, "found AttitudePID"),
    ):
        with pytest.raises(gs.InputError, match=found):
            gs.export(model, out, **words)
        assert not out.exists()


def test_a_data_sheet_is_of_the_wheel_or_of_what_is_known_of_it(fit, tmp_path):
    (sheet,) = gs.export(fit, tmp_path / "fit", to="json")
    (bare,) = gs.export(fit.wheel(), tmp_path / "wheel", to="json")
    assert f'"sigma": {fit.sigma["coulomb"]!r}' in sheet.read_text(encoding="utf-8")
    assert '"sigma": null' in bare.read_text(encoding="utf-8")


def test_a_repr_shows_values():
    from gyrostat.core.jax64 import jax, jnp

    wheel = gs.Wheel(jnp.array(1.5e-3), 0.0228, gs.Stribeck(5e-6, np.float64(9e-4), 1e-3, 0.4))
    text = repr(wheel)
    assert "inertia=0.0015" in text
    assert "coulomb=0.0009" in text
    craft = gs.read_spacecraft(EXAMPLES / "three_wheels.toml").spacecraft
    assert "inertia=[0.015, 0.015, 0.015]" in repr(craft)
    parts = [wheel, craft, gs.Gyrostat(craft), gs.AttitudePID(*map(jnp.array, GAINS))]
    for part in parts:
        assert "f64[" not in repr(part)
    seen = []
    jax.jit(lambda given: seen.append(repr(given)))(wheel)
    assert "f64[]" in seen[0]  # no values yet
    assert "f64[100]" in repr(gs.Driver(jnp.zeros(100)))


def test_the_gains_of_carrara_and_kuga_follow_from_one_frequency():
    law = gs.AttitudePID.design(0.495, 0.28705)
    np.testing.assert_allclose([law.proportional, law.integral, law.derivative], GAINS, rtol=2e-3)
    roots = np.roots([0.495, law.derivative, law.proportional, law.integral])
    np.testing.assert_allclose(np.sort(roots.real), [-0.28705, -0.28705, -0.05741], rtol=1e-6)


SCRIPT = """
import gyrostat as gs
fit = gs.identify(gs.read_record("wheel.csv"), inertia=1.5e-3, speed_sigma="5 rpm")
compensator = gs.EstimatingCompensator.design(
    fit.wheel(), table_inertia=0.495, frequency=0.3, speed_sigma=fit.speed_sigma, period=0.1
)
runs = gs.campaign("cubesat.toml", runs=128, seed=1)
print(runs.error_max.quantile(0.997)); gs.export(compensator, "flight", to="c", period=0.1)
assert runs.sizes == {"run": 128} and runs.error_max.units == "rad"
"""


SMALL = """
name = "cube, sat"
spacecraft.file = "craft.toml"
run = {duration = "10 s", control_period = "0.5 s"}
start.attitude_error = ["0.2 deg", 0.0, "-0.1 deg"]
controller.kind = "three_axis"
dispersion = [{key = "wheel.*.coulomb", distribution = "log_normal", sigma = "30 %"}]
"""


def test_the_example_runs(tmp_path, monkeypatch, capfd):
    scenarios = EXAMPLES / "scenarios"
    for name, source in (
        ("wheel.csv", EXAMPLES / "wheel_profile2.csv"),
        ("craft.toml", scenarios / "cubesat.toml"),
        ("cubesat_wheel.toml", scenarios / "cubesat_wheel.toml"),
    ):
        (tmp_path / name).write_bytes(source.read_bytes())
    (tmp_path / "cubesat.toml").write_text(SMALL)
    monkeypatch.chdir(tmp_path)
    exec(SCRIPT, {})
    out, err = capfd.readouterr()
    assert out.count("quantile") == 1
    assert err == "the files of the campaign are written to cube-sat-128-runs-seed-1\n"
    assert (tmp_path / "cube-sat-128-runs-seed-1" / "report.html").exists()
    assert (tmp_path / "flight" / "compensator.c").exists()


WORKERS = """
from gyrostat.campaigns.executors import processes
print("main")
spec, file = __spec__, globals().get("__file__")
with processes(1)() as pool:
    print(*pool.map(len, ["a", "bc"]))
assert (spec, file) == (__spec__, globals().get("__file__"))
"""


@pytest.mark.parametrize("name", ["plain.py", "-"])
def test_workers_do_not_run_a_script_without_a_main_guard(tmp_path, name):
    (tmp_path / "plain.py").write_text(WORKERS)
    command = [sys.executable, name]
    done = subprocess.run(command, cwd=tmp_path, input=WORKERS, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "main\n1 2\n"), done.stderr


def test_processes_that_are_no_workers_still_get_their_main_module(monkeypatch):
    """Others may be started by another thread while a worker starts."""
    import multiprocessing.spawn as spawn
    from multiprocessing.context import SpawnProcess

    from gyrostat.campaigns.executors import _Worker

    seen = {}

    def start(process):
        for name in (process.name, "other"):
            seen[name] = spawn.get_preparation_data(name)

    main = type(sys)("__main__")
    main.__spec__, main.__file__ = None, "/somewhere/script.py"
    monkeypatch.setitem(sys.modules, "__main__", main)
    monkeypatch.setattr(SpawnProcess, "start", start)
    before = spawn.get_preparation_data
    _Worker(name="own").start()
    assert "init_main_from_path" not in seen["own"]
    assert seen["other"]["init_main_from_path"] == "/somewhere/script.py"
    assert spawn.get_preparation_data is before
