"""Design of the next record: its information, its limits and its files."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given as examples
from hypothesis import strategies as st

import gyrostat as gs
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.identification.experiment import experiment_design
from gyrostat.identification.experiment.current_profiles import FAMILIES, Limits, Shape
from gyrostat.identification.experiment.experiment_design import design_record
from gyrostat.identification.experiment.known_wheel import KnownWheel
from gyrostat.identification.experiment.record_effects import RecordEffects, expected_size
from gyrostat.identification.experiment.record_information import UNKNOWN_START, information_gained
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.sigmas import square_root
from gyrostat.identification.uncertainty.torque_noise import RETURN
from gyrostat.telemetry import Record, read_record
from gyrostat.wheel import speed_response
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

pytestmark = pytest.mark.optimised
INERTIA, NOISE = 1.5e-3, 5.0 * RPM
LIMITS = Limits(duration=60.0, rate=10.0, current=0.15)
ESTIMATED = [0, 2, 3, 4]
"""Places of motor constant, viscous, Coulomb and static torque. With as many samples as a design
has, 601, their information needs one program."""


def shorten(patch):
    """A search of few profiles."""
    patch.setattr(experiment_design, "FIRST", 8)
    patch.setattr(experiment_design, "ROUNDS", 2)
    patch.setattr(experiment_design, "FINAL_WHEELS", 32)


@pytest.fixture
def short_search(monkeypatch):
    shorten(monkeypatch)


@pytest.fixture(scope="module")
def known(given):
    return KnownWheel.from_fit(given)


@pytest.fixture(scope="module")
def designs(known):
    """Designs for the static torque: without a ripple, and with a known one and a target."""
    options = ({"ripple": 0.0}, {"ripple": 0.04, "targets": [8.7e-6]})
    with pytest.MonkeyPatch.context() as patch:
        shorten(patch)
        return [
            design_record(known, ["static-coulomb"], LIMITS, speed_sigma=NOISE, **each)
            for each in options
        ]


def test_the_uncertainty_after_a_record_is_that_of_linear_regression():
    """Without viscous friction and in one direction: dw/dk_m = I t / J, dw/dw(0) = 1."""
    wheel = np.array([[0.0228, INERTIA, 0.0, 0.9e-3, 0.0]])
    time = np.arange(601) / 10.0
    current, before = np.full((1, 601), 0.1), 1e-4
    gained = information_gained(
        ViscousCoulomb,
        wheel,
        current,
        time,
        places=[0],
        root=np.array([[before]]),
        speed_sigma=NOISE,
        initial_speed=1.0,
    )
    rows = np.column_stack([0.1 * time / INERTIA, np.ones(601)]) / NOISE
    a_priori = np.diag([before**-2, (UNKNOWN_START * NOISE) ** -2])
    expected = np.linalg.inv(rows.T @ rows + a_priori)[0, 0]
    assert gained.covariance[0, 0, -1, 0, 0] == pytest.approx(expected, rel=1e-9)
    half = rows[time <= 30.0]
    expected = np.linalg.inv(half.T @ half + a_priori)[0, 0]
    assert gained.covariance[0, 0, 14, 0, 0] == pytest.approx(expected, rel=1e-9)
    assert gained.events[0, 0, -1] == 0.0


def test_the_predicted_sigma_is_that_of_the_identification_of_both_records(record):
    """A ramp through the breakaway torque, fitted together with profile 2."""
    first = record()
    time = LIMITS.time()
    current = np.linspace(0.94, 1.12, len(time)) * 0.9055e-3 / 0.0228
    wheel = gs.Wheel(
        inertia=INERTIA,
        motor_constant=0.0228,
        friction=Stribeck(
            viscous=4.83e-6, coulomb=0.8795e-3, static=0.9055e-3, stribeck_speed=0.418879
        ),
    )
    speed = np.asarray(speed_response(wheel, time, current, 0.0)[0])
    noise = NOISE * np.random.default_rng(1).standard_normal(len(time))
    ramp = Record("ramp", time, current, speed + noise, time >= 0.0)
    both = identify([first, ramp], inertia=INERTIA, speed_sigma=NOISE, white_noise=True)
    place = [both.names.index(n) for n in ("static", "coulomb")]
    found = np.array([1.0, -1.0]) @ both.covariance[np.ix_(place, place)] @ np.array([1.0, -1.0])
    names = ("motor_constant", "viscous", "coulomb", "static")
    alone = SpeedPrediction([first], Stribeck, "zero-order")
    values = {**both.parameters, "initial_speed": both.parameters["initial_speed_1"]}
    shared = [values[n] for n in alone.names]
    ((_, rows),) = alone(np.array(shared))
    columns = [alone.names.index(n) for n in (*names, "initial_speed")]
    assert columns[:4] == ESTIMATED
    before = np.linalg.inv(rows[:, columns].T @ rows[:, columns] / NOISE**2)[:4, :4]
    gained = information_gained(
        Stribeck,
        np.array([shared[:-1]]),
        current[None],
        time,
        places=columns[:4],
        root=square_root(before),
        speed_sigma=NOISE,
        initial_speed=both.parameters["initial_speed_2"],
    )
    contrast = np.array([0.0, 0.0, -1.0, 1.0])
    predicted = np.sqrt(contrast @ gained.covariance[0, 0, -1] @ contrast)
    assert predicted == pytest.approx(np.sqrt(found), rel=1e-3)
    assert both.parameters["static"] - both.parameters["coulomb"] == pytest.approx(
        26e-6, abs=4.0 * np.sqrt(found)
    )


def test_a_reversal_ends_at_its_opposite_current():
    _, profile = FAMILIES["reversals"]
    phase = np.array([0.0, 0.1, 0.2, 0.6, 0.999])
    found = profile(phase, np.ones(5), first=3.0, second=2.0, share=0.2)
    np.testing.assert_allclose(found, [3.0, 0.5, -2.0, -2.0, -2.0])


@examples(
    family=st.sampled_from(sorted(FAMILIES)),
    coordinates=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4),
    duration=st.floats(2.0, 50.0),
    current=st.floats(1e-3, 10.0),
    slew=st.floats(1e-3, 100.0),
)
def test_no_profile_leaves_the_limits_of_the_driver(family, coordinates, duration, current, slew):
    limits = Limits(duration=duration, rate=10.0, current=current, slew=slew)
    time = limits.time()
    found = limits.apply(Shape(family, np.array(coordinates)).current(time, limits, 0.04), 0.1)
    assert np.all(np.isfinite(found))
    assert np.max(np.abs(found)) <= current
    assert np.max(np.abs(np.diff(found, prepend=0.0))) <= slew * 0.1 * (1.0 + 1e-9) + 1e-15


def test_one_minute_shows_the_static_torque(known, designs, short_search):
    """Without a ripple; with what the fit expects of one, less."""
    design, rippled = designs
    expected = design_record(known, ["static-coulomb"], LIMITS, speed_sigma=NOISE)
    wanted = design.wanted[0]
    assert wanted.reliable < wanted.before / 3.0
    assert wanted.reliable < expected.wanted[0].reliable < wanted.before / 2.0
    assert design.events >= 1.0
    assert wanted.after <= wanted.reliable
    assert all(row.after <= row.before for row in design.parameters)
    assert rippled.needed == int(np.ceil((0.04 * known.dry_torque() / 8.7e-6) ** 2))
    assert rippled.events > 1.0
    assert rippled.reached is None
    assert "record longer" in repr(rippled)
    assert f"the target takes at least {rippled.needed};" in repr(rippled)


def test_the_record_ends_when_the_target_is_reached(known, short_search):
    design = design_record(known, ["static-coulomb"], LIMITS, speed_sigma=NOISE, targets=[20e-6])
    assert design.reached is not None
    assert design.time[-1] == pytest.approx(design.reached, abs=0.11)
    assert design.wanted[0].reliable <= 20e-6
    assert len(design.time) == len(design.current) == len(design.speed)


def test_the_verb_writes_the_profile_its_prediction_and_a_page(given, tmp_path, short_search):
    (tmp_path / "fit.json").write_text(json.dumps(given.to_dict()), encoding="utf-8")
    said = []
    design = gs.bench(
        tmp_path / "fit.json",
        tmp_path / "next.csv",
        design="static, coulomb",
        duration="1 min",
        high=0.15,
        max_speed="200 rpm",
        say=said.append,
    )
    assert np.max(np.abs(design.speed)) < 200.0 * RPM
    record = read_record(tmp_path / "next.csv")
    np.testing.assert_array_equal(record.current, design.current)
    content = json.loads((tmp_path / "next.json").read_text(encoding="utf-8"))
    assert [row["name"] for row in content["wanted"]] == design.names == ["static", "coulomb"]
    assert content["parameters"]["coulomb"]["before"] == pytest.approx(given.sigma["coulomb"])
    assert "<svg" in (tmp_path / "next.html").read_text(encoding="utf-8")
    assert any(line.startswith("profile of ") for line in said)


@pytest.mark.parametrize(
    ("options", "found"),
    [
        ({"design": "drag"}, "design: found 'drag', expected a parameter that the fit estimates"),
        ({"design": "inertia"}, "found 'inertia'"),
        ({"design": "static-viscous"}, "expected parameters of one unit"),
        ({"design": "static-static"}, "always zero"),
        ({"design": "static", "duration": 1.0}, "found 10 samples, expected at least 20"),
        ({"design": "static", "low": 0.1}, "found low, expected these with a simulated record"),
        ({"design": "static", "target_sigma": [1.0, 2.0]}, "found 2 values, expected 1"),
        ({"slew": 1.0}, "found slew, expected these with design only"),
    ],
)
def test_a_design_that_cannot_be_made_says_why(given, options, found):
    with pytest.raises(gs.InputError, match=found):
        gs.bench(given, **options)


def test_a_wheel_without_uncertainty_is_refused(given, tmp_path):
    with pytest.raises(gs.InputError, match=r"found no table \[sigma\]"):
        gs.bench(given.wheel(), design="static", speed_sigma=NOISE)
    (tmp_path / "fit.json").write_text('{"parameters": {}}', encoding="utf-8")
    with pytest.raises(gs.InputError, match=r"expected a fit\.json"):
        gs.bench(tmp_path / "fit.json", design="static")


def test_wheels_drawn_can_exist_and_spread_as_the_estimates(known):
    wheels = known.draws(2000, np.random.default_rng(0))
    names = list(known.values)
    drawn = dict(zip(names, wheels.T, strict=True))
    assert np.all(drawn["static"] >= drawn["coulomb"])
    place = known.names.index("motor_constant")
    assert np.std(drawn["motor_constant"]) == pytest.approx(
        np.sqrt(known.covariance[place, place]), rel=0.1
    )


def test_breakaways_at_the_same_angles_do_not_average_a_ripple():
    """Against generalised least squares of the mean of a torque with an exponential correlation."""
    time = 0.3 * np.arange(601)
    level = 0.88e-3 / 0.0228 * np.repeat([1.5, 0.0, -3.0, 0.0, 2.5, 0.0], 100)
    wheel = np.array([[0.0228, INERTIA, 4.83e-6, 0.88e-3, 0.9e-3, 0.42, 0.0]])
    gained = information_gained(
        Stribeck,
        wheel,
        np.append(level, 0.0)[None],
        time,
        places=ESTIMATED,
        root=1e-4 * np.eye(4),
        speed_sigma=NOISE,
    )
    speed = gained.speed[0, 0]
    turned = 0.3 * np.cumsum(0.5 * np.abs(speed[1:] + speed[:-1]))
    starts = np.flatnonzero((speed[:-1] == 0.0) & (speed[1:] != 0.0))
    assert len(starts) == gained.events[0, 0, -1] >= 2
    angle = turned[starts]
    correlation = np.exp(-np.abs(angle[:, None] - angle) / RETURN)
    expected = np.sum(np.linalg.inv(correlation))
    assert 1.0 < expected < len(starts)
    assert gained.angles[0, 0, -1] == pytest.approx(expected, rel=1e-2)


def test_a_stated_ripple_of_slow_breakaways_is_in_the_sigma(record):
    """Ramps to and fro show the static torque at one angle, however many they are."""
    time = np.arange(1201) / 10.0
    period = np.floor(time / 10.0 + 1e-9)
    share = time / 10.0 - period
    current = (-1.0) ** period * (0.8 + 0.4 * share) * 0.9055e-3 / 0.0228
    friction = Stribeck(viscous=4.83e-6, coulomb=0.8795e-3, static=0.9055e-3, stribeck_speed=0.419)
    wheel = gs.Wheel(inertia=INERTIA, motor_constant=0.0228, friction=friction)
    speed = np.asarray(speed_response(wheel, time, current, 0.0)[0])
    noise = NOISE * np.random.default_rng(1).standard_normal(len(time))
    ramps = Record("ramps", time, current, speed + noise, time >= 0.0)
    sigma = {}
    for ripple in (0.0, 0.04):
        fit = identify([record(), ramps], inertia=INERTIA, speed_sigma=NOISE, ripple=ripple)
        sigma[ripple] = fit.sigma[fit.names.index("static")]
        effect = next(e for e in fit.effects if e.name == "crossing_ripple")
        assert effect.probability == pytest.approx(float(ripple > 0.0))
        assert effect.value == pytest.approx(ripple)
    torque = 0.04 * KnownWheel.from_fit(fit).dry_torque()
    assert sigma[0.0] < 0.3 * torque
    assert 0.7 * torque < sigma[0.04] < 1.5 * torque


def test_without_a_ripple_the_text_says_what_one_would_cost(known, designs, short_search):
    design, rippled = designs
    assert "no torque ripple is assumed" in repr(design)
    assert f"N·m/sqrt(n): the target takes at least {rippled.needed}; turn" in repr(rippled)
    assert "N·m/sqrt(n); turn the wheel" in repr(replace(rippled, needed=None))
    assert rippled.wanted[0].after > 0.5 * 0.04 * known.dry_torque()
    viscous = design_record(known, ["viscous"], LIMITS, speed_sigma=NOISE, ripple=0.04)
    assert "ripple" not in repr(viscous)


def test_an_uncertain_ripple_counts_with_its_root_mean_square():
    """A size that is there with a probability only, drawn a million times."""
    random, effect = np.random.default_rng(3), Effect("a", "A", 0.3, 0.02, 0.01, "1")
    sizes = random.normal(0.02, 0.01, 1_000_000) * (random.random(1_000_000) < 0.3)
    assert effect.expected == pytest.approx(np.sqrt(np.mean(sizes**2)), rel=5e-3)
    torque = Effect("crossing_ripple", "ripple", 0.3, 0.02, None, "1")
    assert expected_size({"crossing_ripple": torque}, "crossing_ripple") == pytest.approx(
        0.02 * np.sqrt(0.3)
    )
    assert expected_size({}, "crossing_ripple") == 0.0


def test_the_ripple_that_a_fit_finds_unlikely_is_in_the_design(given, known):
    effect = next(each for each in given.effects if each.name == "crossing_ripple")
    assert 0.0 < effect.probability < 0.5
    assert known.ripple == effect.expected > 0.0


def test_simulated_records_scatter_as_promised(known, given, tmp_path, short_search):
    """Sixteen records know a scatter to 18 %: the promise is within 2.5 of these sigmas."""
    lines = []
    design = gs.bench(
        given,
        tmp_path / "next.csv",
        design="coulomb",
        duration=60,
        drift={"viscous": "2 %", "dry": 0.01},
        ripple=0.0,
        simulate=16,
        say=lines.append,
    )
    content = json.loads((tmp_path / "next.json").read_text(encoding="utf-8"))
    simulation = content["simulation"]
    assert (simulation["runs"], simulation["failures"]) == (16, [])
    for row in simulation["scatters"]:
        assert 0.5 < row["promised"] / row["rms"] < 2.0
    assert any("16 simulated records, 0 without" in line for line in lines)
    (wanted,) = design.wanted
    assert wanted.after == simulation["scatters"][0]["promised"]


def test_drift_of_friction_is_a_further_unknown_of_the_regression():
    """Dry friction that grows linearly by d: dw/dd = -(c / J) (t^2 / T - t)."""
    wheel = np.array([[0.0228, INERTIA, 0.0, 0.9e-3, 0.0]])
    time, before, drift = np.arange(601) / 10.0, 1e-4, 0.02
    gained = information_gained(
        ViscousCoulomb,
        wheel,
        np.full((1, 601), 0.1),
        time,
        places=[0],
        root=np.array([[before]]),
        speed_sigma=NOISE,
        initial_speed=1.0,
        effects=RecordEffects(drifts=((0.0, 0.0), (drift, 0.0))),
    )
    bend = -0.9e-3 / INERTIA * (time**2 / 60.0 - time)
    rows = np.column_stack([0.1 * time / INERTIA, np.ones(601), bend]) / NOISE
    a_priori = np.diag([before**-2, (UNKNOWN_START * NOISE) ** -2, drift**-2])
    expected = np.linalg.inv(rows.T @ rows + a_priori)[0, 0]
    assert gained.covariance[0, 0, -1, 0, 0] == pytest.approx(expected, rel=1e-6)


def test_a_constant_current_has_one_unknown_error():
    """Without friction that drifts: the error of the current adds (I_error / I)^2 to k_m."""
    wheel = np.array([[0.0228, INERTIA, 0.0, 0.9e-3, 0.0]])
    time = np.arange(601) / 10.0
    options = {
        "places": [0],
        "root": np.array([[1e-2]]),
        "speed_sigma": 1e-6,
        "initial_speed": 1.0,
    }
    gained = information_gained(
        ViscousCoulomb,
        wheel,
        np.full((1, 601), 0.1),
        time,
        effects=RecordEffects(current_error=3e-4),
        **options,
    )
    assert np.sqrt(gained.covariance[0, 0, -1, 0, 0]) == pytest.approx(
        0.0228 * 3e-4 / 0.1, rel=1e-3
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"drift": "static=0.1"}, "drift: found 'static'"),
        ({"drift": "viscous=70%"}, "viscous: found 70%"),
        ({"simulate": -1}, "simulate: found -1"),
    ],
)
def test_impossible_effects_are_refused(given, options, message):
    with pytest.raises(gs.InputError) as error:
        gs.bench(given, design="coulomb", **options)
    assert message in str(error.value)
