"""Identification of wheels whose parameters are known."""

import numpy as np
import pytest
from scipy.stats import chi2

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.identification import identify
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import Stribeck

# A hundred fits with few programs: they run longer than they compile.
pytestmark = pytest.mark.optimised

INERTIA = 1.5e-3
TRUE = {"viscous": 4.83e-6, "coulomb": 0.8795e-3, "static": 0.9055e-3, "stribeck_speed": 0.4189}
PAPER_START = {
    "inertia": INERTIA,
    "hold": {"initial_speed": 0.0},
    "prior": {
        "motor_constant": (18.0 * INERTIA, 5.0 * INERTIA),
        "viscous": (0.00344 * INERTIA, 0.002 * INERTIA),
        "coulomb": (0.5863 * INERTIA, 0.3 * INERTIA),
        "static": (0.0, 0.6 * INERTIA),
    },
    "speed_sigma": 5.0 * RPM,
}


respond = jax.jit(speed_response)


@pytest.fixture(scope="module")
def of_the_paper(record):
    """Fits of 25 records from the paper's start."""
    return [identify(record(seed=seed), **PAPER_START) for seed in range(25)]


@pytest.fixture(scope="module")
def of_pairs(record):
    """Fits of a noisy and a quiet record together, for 6 seeds: records and fit."""
    pairs = [[record(seed=k), record("stribeck", "ramps", 100 + k, 0.5)] for k in range(6)]
    return [(pair, identify(pair, inertia=INERTIA)) for pair in pairs]


def errors(fit, truth):
    return {n: v - truth[n] for n, v in fit.parameters.items() if n in fit.names and n in truth}


@pytest.mark.parametrize("name", ["viscous-coulomb", "stribeck", "sticky", "directional"])
def test_noise_free_record_gives_the_wheel_back(record, truth, name):
    model = "stribeck" if name == "sticky" else name
    hold = {} if name == "viscous-coulomb" else {"stribeck_speed": truth[name]["stribeck_speed"]}
    fit = identify(record(name, sigma_rpm=0.0), inertia=INERTIA, model=model, hold=hold)
    assert fit.converged
    for parameter, error in errors(fit, truth[name]).items():
        assert abs(error) < 2e-5 * abs(truth[name][parameter]), parameter


@pytest.mark.parametrize("name", ["stribeck", "sticky", "directional"])
@pytest.mark.parametrize("profile", ["steps", "sines"])
def test_noisy_record_gives_the_wheel_within_its_sigmas(record, truth, name, profile):
    model = "stribeck" if name == "sticky" else name
    hold = {"stribeck_speed": truth[name]["stribeck_speed"]}
    fit = identify(record(name, profile), inertia=INERTIA, model=model, hold=hold)
    assert fit.converged
    error = np.array(list(errors(fit, truth[name]).values()))
    wheel = [k for k, n in enumerate(fit.names) if n in truth[name]]
    covariance = fit.covariance[np.ix_(wheel, wheel)]
    assert error @ np.linalg.solve(covariance, error) < chi2.ppf(0.9999, len(error))


def test_paper_start_converges_within_twelve_iterations_and_sigmas_are_honest(of_the_paper, truth):
    distances = []
    for fit in of_the_paper:
        assert fit.converged
        assert fit.iterations <= 12
        error = np.array(list(errors(fit, truth["stribeck"]).values()))
        distances.append(error @ np.linalg.solve(fit.covariance, error))
    low, high = chi2.ppf([0.001, 0.999], 4 * 25)
    assert low < sum(distances) < high


def test_residual_scales_sigma_where_the_noise_is_not_given(record, given, plain):
    doubled = identify(record(), inertia=INERTIA, speed_sigma=10.0 * RPM)
    scaled = plain
    np.testing.assert_allclose(doubled.noise_sigma, 2.0 * given.noise_sigma, rtol=1e-3)
    np.testing.assert_allclose(scaled.noise_sigma, given.noise_sigma, rtol=0.05)
    np.testing.assert_allclose(scaled.sigma, given.sigma, rtol=0.1)
    assert scaled.speed_sigma == pytest.approx(5.0 * RPM, rel=0.05)
    assert any("speed sigma" in w for w in doubled.warnings)


def test_static_torque_of_the_paper_is_not_observable_and_says_what_would_cure_it(given):
    assert not given.observability["static"].observable
    assert "bench fit.json --design" in given.observability["static"].advice
    assert all(given.observability[n].observable for n in ("motor_constant", "viscous", "coulomb"))


def test_ramps_from_rest_show_what_the_steps_do_not(record):
    fit = identify(record("sticky", "ramps"), inertia=INERTIA, hold={"stribeck_speed": 2.0})
    assert fit.observability["static"].observable


def test_record_without_a_crossing_works_and_static_is_not_observable(record, changed):
    whole = record("sticky", rate=20.0)
    first = whole.time < 29.0
    short = changed(
        whole,
        time=whole.time[first],
        current=whole.current[first] * (1.0 + 0.3 * (whole.time[first] > 15.0)),
        speed=whole.speed[first] + 40.0,
        valid=whole.valid[first],
    )
    fit = identify(short, inertia=INERTIA, hold={"motor_constant": 0.0228})
    assert fit.crossings == 0
    assert not fit.observability["static"].observable
    assert any("bench fit.json --design static-coulomb" in w for w in fit.warnings)


def test_stribeck_speed_can_be_freed_where_the_wheel_is_sticky(record, truth):
    fit = identify(record("sticky", sigma_rpm=1.0), inertia=INERTIA, free=["stribeck_speed"])
    k = fit.names.index("stribeck_speed")
    assert abs(fit.values[k] - 2.0) < 4.0 * fit.sigma[k]


def test_inertia_is_estimated_where_the_motor_constant_is_known(record):
    fit = identify(record(), hold={"motor_constant": 0.0228}, free=["inertia"])
    k = fit.names.index("inertia")
    assert abs(fit.values[k] - INERTIA) < 4.0 * fit.sigma[k]


def test_current_bias_is_found_and_said_to_belong_to_the_bench(record, changed):
    biased = changed(record(), current=record().current - 0.004)
    fit = identify(biased, inertia=INERTIA, free=["current_bias"])
    k = fit.names.index("current_bias")
    assert abs(fit.values[k] - 0.004) < 4.0 * fit.sigma[k]
    assert any("validate --hold current_bias=0.00" in w for w in fit.warnings)


def test_initial_speed_is_estimated_for_each_record(record, changed):
    whole = record()
    # both records are then padded to one length
    late = whole.time >= 10.0
    cut = changed(
        whole,
        time=whole.time[late],
        current=whole.current[late],
        speed=whole.speed[late],
        valid=whole.valid[late],
    )
    fit = identify([whole, cut], inertia=INERTIA)
    assert fit.parameters["initial_speed_1"] == pytest.approx(0.0, abs=0.5)
    assert fit.parameters["initial_speed_2"] == pytest.approx(cut.speed[0], abs=3.0)
    assert abs(cut.speed[0]) > 6.0
    assert fit.samples == len(whole.time) + len(cut.time)


def test_information_of_two_records_adds(record):
    alone = {**PAPER_START, "white_noise": True}
    first, second = (identify(record(seed=s), **alone) for s in (1, 2))
    options = {**alone, "hold": {"initial_speed_1": 0.0, "initial_speed_2": 0.0}}
    both = identify([record(seed=1), record(seed=2)], **options)
    assert both.names == first.names == second.names
    prior = np.diag([PAPER_START["prior"][n][1] ** -2.0 for n in both.names])
    total = np.linalg.inv(first.covariance) + np.linalg.inv(second.covariance) - prior
    np.testing.assert_allclose(np.sqrt(np.diag(np.linalg.inv(total))), both.sigma, rtol=0.1)


def test_missing_samples_are_skipped_and_jitter_is_taken_as_it_is(record, truth):
    fit = identify(record(jitter=0.2, dropouts=0.3), inertia=INERTIA)
    assert fit.samples == pytest.approx(0.7 * 3001, rel=0.05)
    for name, error in errors(fit, truth["stribeck"]).items():
        assert abs(error) < 4.0 * fit.sigma[fit.names.index(name)]


def test_outliers_spoil_the_quadratic_loss_but_not_the_robust_ones(record, changed, truth, plain):
    clean = record()
    random = np.random.default_rng(5)
    speed = clean.speed.copy()
    hit = random.random(len(speed)) < 0.03
    speed[hit] += 30.0
    spoiled = changed(clean, speed=speed)
    quadratic = identify(spoiled, inertia=INERTIA)
    k = plain.names.index("coulomb")
    for loss in ("huber", "student"):
        robust = identify(spoiled, inertia=INERTIA, loss=loss)
        assert abs(robust.values[k] - truth["stribeck"]["coulomb"]) < 4.0 * robust.sigma[k]
        assert robust.sigma[k] < 2.0 * plain.sigma[k] < quadratic.sigma[k]


def test_quantised_tachometer_is_no_obstacle(record, truth):
    fit = identify(record(sigma_rpm=1.0, speed_quantum=10.0 * RPM), inertia=INERTIA)
    assert abs(fit.parameters["coulomb"] / truth["stribeck"]["coulomb"] - 1.0) < 0.02


def test_linear_current_is_fitted_with_the_linear_hold(record, truth):
    sine = record(profile="sines", rate=2.0)
    assert (
        identify(sine, inertia=INERTIA).rms_speed
        < identify(sine, inertia=INERTIA, current_hold="linear").rms_speed
    )


def test_start_that_sticks_is_left_behind(record, truth):
    fit = identify(record(), inertia=INERTIA, start={"coulomb": 0.05})
    assert fit.converged
    assert fit.parameters["coulomb"] == pytest.approx(truth["stribeck"]["coulomb"], rel=0.05)


def test_static_below_coulomb_is_allowed_as_noise(of_the_paper):
    """Over seeds the estimate of T_s - c must scatter on both sides of its true value."""
    seen = [fit.parameters["static"] - fit.parameters["coulomb"] for fit in of_the_paper]
    assert min(seen) < 0.0 < max(seen)


def test_wrong_unit_of_the_speed_is_suspected(record, changed, plain):
    mixed = changed(record(), speed=record().speed / RPM)
    fit = identify(mixed, inertia=INERTIA)
    assert any("units" in w for w in fit.warnings)
    assert not any("units" in w for w in plain.warnings)


def test_opposite_senses_of_current_and_speed_are_said(record, changed):
    fit = identify(changed(record(), current=-record().current), inertia=INERTIA)
    assert any("opposite senses" in w for w in fit.warnings)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "inertia: found none"),
        ({"inertia": 0.0}, "inertia: found 0, expected more than 0 kg·m²"),
        ({"inertia": -1.0}, "inertia: found -1"),
        ({"inertia": np.nan}, "inertia: found nan"),
        ({"inertia": INERTIA, "free": ["inertia"]}, "only their ratios"),
        ({"inertia": INERTIA, "model": "dahl"}, "model: found 'dahl'"),
        ({"inertia": INERTIA, "hold": {"drag": 1.0}}, "parameter 'drag'"),
        ({"inertia": INERTIA, "hold": {"coulomb": 1.0}, "free": ["coulomb"]}, "both held and free"),
        ({"inertia": INERTIA, "prior": {"coulomb": (1e-3, 0.0)}}, "a-priori sigma of coulomb"),
        ({"inertia": INERTIA, "speed_sigma": 0.0}, "speed sigma"),
        ({"inertia": INERTIA, "loss": "cauchy"}, "loss: found 'cauchy'"),
        ({"inertia": INERTIA, "hold": {"stribeck_speed": 0.0}}, "held stribeck_speed"),
        ({"inertia": INERTIA, "prior": {"coulomb": (1e-3, np.inf)}}, "a-priori sigma of coulomb"),
        ({"inertia": INERTIA, "hold": {"inertia": 2e-3}}, "found 0.0015 and, held, 0.002"),
        ({"inertia": INERTIA, "hold": {"motor_constant": None}}, "held motor_constant: found no"),
        ({"inertia": INERTIA, "hold": {"static": None}}, "held static: found no value"),
        ({"inertia": INERTIA, "start": {"stribeck_speed": 1.0}}, "start of stribeck_speed"),
        ({"inertia": INERTIA, "start": {"static": 1e-3}, "hold": {"static": 1e-3}}, "that is held"),
        (
            {"inertia": INERTIA, "prior": {"static": (1e-3, 1e-4)}, "hold": {"static": 1e-3}},
            "both held and with an a-priori",
        ),
        (
            {"free": ["inertia"], "hold": {"viscous": 0.0}, "model": "viscous-coulomb"},
            "only their ratios",
        ),
        ({"inertia": INERTIA, "speed_sigma": [0.5, 0.05]}, "found 2 values, expected 1"),
        ({"inertia": INERTIA, "speed_sigma": [-0.5]}, "speed sigma: found -0.5"),
    ],
)
def test_requests_that_cannot_be_met_say_why(record, options, message):
    with pytest.raises(InputError) as caught:
        identify(record(), **options)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_records_that_show_nothing_say_why(record, changed):
    whole = record()
    constant = changed(whole, current=np.full(len(whole.time), 0.1))
    with pytest.raises(InputError, match="constant"):
        identify(constant, inertia=INERTIA)
    random = np.random.default_rng(0)
    still = changed(whole, speed=0.1 * random.standard_normal(len(whole.time)))
    with pytest.raises(InputError, match="never moves"):
        identify(still, inertia=INERTIA)
    few = changed(
        whole,
        time=whole.time[:4],
        current=whole.current[:4],
        speed=whole.speed[:4],
        valid=whole.valid[:4],
    )
    with pytest.raises(InputError, match="more than the 5 parameters"):
        identify(few, inertia=INERTIA)
    with pytest.raises(InputError, match="found none"):
        identify([], inertia=INERTIA)


def test_an_a_priori_frees_its_parameter(record):
    fit = identify(record(), inertia=INERTIA, prior={"stribeck_speed": (0.84, 0.1)})
    k = fit.names.index("stribeck_speed")
    assert fit.sigma[k] < 0.11


def test_the_start_does_not_move_the_result(record, given):
    """Nothing but the a-priori of the records themselves may pull at an estimate."""
    moved = identify(
        record(), inertia=INERTIA, speed_sigma=5.0 * RPM, start={"static": 1.0, "viscous": 1e-4}
    )
    assert np.all(np.abs(moved.values - given.values) < 1e-2 * given.sigma)


def test_a_start_of_the_static_torque_is_heeded(record, truth):
    """From the truth there is nothing left to iterate, which holds for T_s as for the others."""
    known = {n: v for n, v in truth["sticky"].items() if n not in ("inertia", "stribeck_speed")}
    costs = {}
    identify(
        record("sticky", sigma_rpm=0.1),
        inertia=INERTIA,
        hold={"stribeck_speed": 2.0},
        start=known,
        on_progress=lambda stage, count, cost: costs.setdefault(stage, cost),
    )
    assert costs["all parameters"] < 0.5 * 1.2 * 3001


def test_corrections_are_limited_over_all_stages(record):
    fit = identify(record(), inertia=INERTIA, max_iterations=6)
    assert fit.iterations <= 6


def constant_current(current, initial_speed=0.0, seed=0, **fields):
    """A wheel under a constant current, 60 s, noise of 0.1 rad/s."""
    wheel = Wheel(inertia=INERTIA, motor_constant=0.0228, friction=Stribeck(**TRUE))
    time = 0.1 * np.arange(600)
    speed, _ = respond(wheel, jnp.asarray(time), jnp.full(600, current), initial_speed)
    noise = 0.1 * np.random.default_rng(seed).standard_normal(600)
    steady = np.full(600, current)
    name = f"constant {current}"
    return Record(name, time, steady, np.asarray(speed) + noise, np.ones(600, bool), **fields)


def test_constant_currents_that_differ_show_the_motor_constant():
    pair = [constant_current(0.1), constant_current(-0.14, seed=1)]
    fit = identify(pair, inertia=INERTIA)
    assert fit.converged
    assert abs(fit.parameters["motor_constant"] - 0.0228) < 4.0 * fit.sigma[0]


def test_one_constant_current_shows_the_motor_constant_where_coulomb_friction_is_known():
    fit = identify(
        constant_current(0.1), inertia=INERTIA, model="viscous-coulomb", hold={"coulomb": 0.8795e-3}
    )
    assert abs(fit.parameters["motor_constant"] - 0.0228) < 4.0 * fit.sigma[0]


def test_a_current_that_is_equal_in_both_senses_does_not():
    pair = [constant_current(0.1), constant_current(-0.1, seed=1)]
    with pytest.raises(InputError, match="does not distinguish motor constant"):
        identify(pair, inertia=INERTIA)


def test_a_current_bias_has_a_finite_sigma_where_no_current_flows():
    coast = constant_current(0.0, initial_speed=50.0)
    fit = identify(coast, inertia=INERTIA, hold={"motor_constant": 0.0228}, free=["current_bias"])
    assert np.all(np.isfinite(fit.sigma))
    assert not fit.observability["current_bias"].observable


def weak_record(profile, seed, ratio, stribeck_speed, sigma, reach):
    """A wheel that starts from rest under currents up to `reach` times its breakaway."""
    static = ratio * TRUE["coulomb"]
    friction = Stribeck(**{**TRUE, "static": static, "stribeck_speed": stribeck_speed})
    wheel = Wheel(inertia=INERTIA, motor_constant=0.0228, friction=friction)
    breakaway = static / 0.0228
    return wheel, bench_record(
        wheel,
        profile,
        duration=300.0,
        telemetry=Telemetry(speed_sigma=sigma),
        amplitudes=CurrentRange(1.1 * breakaway, reach * breakaway),
        seed=seed,
    )


@pytest.mark.parametrize(
    ("profile", "seed", "ratio", "stribeck_speed", "sigma"),
    [
        ("ramps", 51, 1.0, 0.4189, 0.01),
        ("ramps", 136, 1.03, 0.4189, 0.01),
        ("ramps", 170, 1.3, 2.0, 0.01),
        ("ramps", 252, 1.0, 0.4189, 0.1),
        ("ramps", 258, 2.0, 2.0, 0.1),
        ("ramps", 259, 1.0, 5.0, 0.01),
        # the first start of this one ends at a wall
        ("sines", 64, 1.03, 2.0, 0.1),
    ],
)
def test_starts_from_rest_lead_to_the_right_minimum(profile, seed, ratio, stribeck_speed, sigma):
    wheel, weak = weak_record(profile, seed, ratio, stribeck_speed, sigma, 1.5)
    hold = {"stribeck_speed": stribeck_speed}
    # the average over effects allows for a ripple and is not the minimum itself
    fit = identify(weak, inertia=INERTIA, hold=hold, speed_sigma=sigma, white_noise=True)
    assert fit.converged
    true_speed, _ = respond(wheel, jnp.asarray(weak.time), jnp.asarray(weak.current), 0.0)
    at_truth = 0.5 * np.sum(((weak.speed - np.asarray(true_speed)) / sigma) ** 2)
    assert 0.5 * np.sum((fit.residuals[0] / sigma) ** 2) < at_truth + 3.0


def test_a_good_first_result_costs_no_second_start(followed):
    _, stages = followed
    assert stages.count(("viscous and Coulomb", 1)) == 1


def test_what_no_start_explains_is_said(record, changed, plain):
    whole = record(duration=220.0)
    disturbed = changed(whole, speed=whole.speed + 8.0 * np.sin(0.7 * whole.time))
    fit = identify(disturbed, inertia=INERTIA, white_noise=True)
    assert any("times the noise that the record itself shows" in w for w in fit.warnings)
    assert not any("times the noise" in w for w in plain.warnings)


def test_each_record_has_its_own_noise(of_pairs, truth):
    """Sigmas are honest where a noisy and a quiet record are fitted together."""
    distances = []
    for _, fit in of_pairs:
        np.testing.assert_allclose(fit.speed_sigmas, [5.0 * RPM, 0.5 * RPM], rtol=0.1)
        error = np.array(list(errors(fit, truth["stribeck"]).values()))
        covariance = fit.covariance[: len(error), : len(error)]
        distances.append(error @ np.linalg.solve(covariance, error))
    low, high = chi2.ppf([0.001, 0.999], 4 * len(of_pairs))
    assert low < sum(distances) < high


def test_noise_is_given_for_each_record(of_pairs):
    pair, seen = of_pairs[3]
    given = identify(pair, inertia=INERTIA, speed_sigma=[5.0 * RPM, 0.5 * RPM])
    np.testing.assert_allclose(given.sigma, seen.sigma, rtol=0.1)
    pooled = np.sqrt((25.0 + 0.25) / 2.0) * RPM
    assert given.speed_sigma == pytest.approx(pooled, rel=1e-3)
    assert given.to_dict()["speed_sigmas"] == [5.0 * RPM, 0.5 * RPM]


def test_sigma_is_never_below_that_of_white_noise(record):
    for options in ({}, {"loss": "huber"}):
        fit = identify(record(seed=4), inertia=INERTIA, **options)
        assert np.all(fit.sigma >= fit.noise_sigma * (1.0 - 1e-12))
