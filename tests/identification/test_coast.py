"""Friction from coast-downs."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.errors import InputError
from gyrostat.identification import identify_coast
from gyrostat.identification.bench.coast import coasting_speed

INERTIA = 1.5e-3
TRUE = np.array([4.83e-6, 0.8795e-3])


@pytest.mark.parametrize("viscous", [0.0, 1e-9, 3.22e-3, 0.5])
def test_closed_solution_obeys_its_equation_and_its_derivatives_are_right(viscous):
    time = np.linspace(0.0, 12.0, 25)
    speed, slopes = coasting_speed(time, 10.0, viscous, 0.6)
    turning = time[speed > 0.0]
    done = solve_ivp(
        lambda _, w: -viscous * w - 0.6,
        (0.0, turning[-1]),
        [10.0],
        t_eval=turning,
        rtol=1e-10,
        atol=1e-10,
    )
    np.testing.assert_allclose(speed[speed > 0.0], done.y[0], atol=1e-8)
    step = 1e-6
    for k, arguments in enumerate(((0, step, 0), (0, 0, step), (step, 0, 0))):
        up, down = (
            coasting_speed(
                time, 10.0 + s * arguments[0], viscous + s * arguments[1], 0.6 + s * arguments[2]
            )[0]
            for s in (1.0, -1.0)
        )
        np.testing.assert_allclose(slopes[:, k], (up - down) / (2.0 * step), atol=1e-4)


def test_a_coast_stops_at_its_analytic_time_and_rests():
    viscous, coulomb, initial = 0.00322, 0.5863, 10.471975511965978
    stop = np.log1p(viscous * initial / coulomb) / viscous
    time = np.array([stop - 1e-6, stop + 1e-6, stop + 100.0])
    speed, slopes = coasting_speed(time, initial, viscous, coulomb)
    assert speed[0] == pytest.approx(coulomb * 1e-6, rel=1e-4)
    assert np.all(speed[1:] == 0.0)
    assert np.all(slopes[1:] == 0.0)


def test_noise_free_ramps_give_the_friction_back(record):
    fit = identify_coast(record("viscous-coulomb", "ramps", sigma_rpm=0.0), inertia=INERTIA)
    assert fit.converged
    np.testing.assert_allclose(fit.values, TRUE, rtol=1e-5)


def test_sigmas_are_honest_over_seeds(record):
    relative = []
    for seed in range(60):
        fit = identify_coast(
            record("viscous-coulomb", "ramps", seed=seed, dropouts=0.1), inertia=INERTIA
        )
        relative.append((fit.values - TRUE) / fit.sigma)
    assert np.all(np.abs(np.mean(relative, axis=0)) < 4.0 / np.sqrt(60.0))
    assert np.all((np.std(relative, axis=0) > 0.65) & (np.std(relative, axis=0) < 1.35))


def test_both_senses_are_used(record, changed):
    ramps = record("viscous-coulomb", "ramps")
    fit = identify_coast(ramps, inertia=INERTIA)
    mirrored = identify_coast(
        changed(ramps, current=-ramps.current, speed=-ramps.speed), inertia=INERTIA
    )
    np.testing.assert_allclose(mirrored.values, fit.values, rtol=1e-9)


def test_what_cannot_be_met_is_said(record):
    ramps = record("viscous-coulomb", "ramps")
    for options, message in (
        ({"inertia": None}, "inertia: found none"),
        ({"inertia": 0.0}, "inertia: found 0"),
        ({"inertia": -1.0}, "inertia: found -1"),
        ({"inertia": INERTIA, "hold": {"coulomb": 1.0}}, "'coulomb'"),
        ({"inertia": INERTIA, "speed_sigma": -1.0}, "speed sigma"),
    ):
        with pytest.raises(InputError) as caught:
            identify_coast(ramps, **options)
        assert message in str(caught.value)
    with pytest.raises(InputError) as caught:
        identify_coast(record("viscous-coulomb", "steps"), inertia=INERTIA)
    assert "found no coast" in str(caught.value)


def coasting_record(record, changed, current_noise, friction="viscous-coulomb", seed=0):
    ramps = record(friction, "ramps", seed=seed)
    noise = current_noise * np.random.default_rng(seed).standard_normal(len(ramps.time))
    return changed(ramps, current=ramps.current + noise)


def test_noise_of_the_current_does_not_hide_the_coasts(record, changed):
    ramps = record("viscous-coulomb", "ramps")
    noisy = coasting_record(record, changed, 1e-3)
    rounded = changed(noisy, current=5e-4 * np.round(noisy.current / 5e-4))
    fits = [identify_coast(r, inertia=INERTIA) for r in (ramps, noisy, rounded)]
    for fit in fits[1:]:
        assert fit.samples > 0.9 * fits[0].samples
        assert np.all(np.abs(fit.values - TRUE) < 4.0 * fit.sigma)


def test_a_stribeck_rise_before_the_stop_does_not_bias_the_friction(record):
    relative = []
    for seed in range(12):
        fit = identify_coast(record("sticky", "ramps", seed=seed), inertia=INERTIA)
        relative.append((fit.values - TRUE) / fit.sigma)
    assert np.all(np.abs(np.mean(relative, axis=0)) < 4.0 / np.sqrt(12.0))


def test_small_currents_are_no_coast(record, changed):
    steps = record("viscous-coulomb", "steps")
    # the motor still pulls, by less than the noise of a single current
    rng = np.random.default_rng(0)
    current = 0.01 + 0.01 * rng.standard_normal(len(steps.time))
    speed = np.linspace(40.0, 20.0, len(steps.time)) + rng.standard_normal(len(steps.time))
    weak = changed(steps, current=current, speed=speed, valid=np.isfinite(speed))
    with pytest.raises(InputError, match="found no coast"):
        identify_coast(weak, inertia=INERTIA)


def test_it_identifies_no_motor_constant_and_says_so(record):
    ramps = record("viscous-coulomb", "ramps")
    fit = identify_coast(ramps, inertia=INERTIA)
    assert fit.rms_speed is None
    with pytest.raises(InputError, match="coast does not identify the motor constant"):
        fit.wheel()
    whole = identify_coast(ramps, inertia=INERTIA, hold={"motor_constant": 0.0228}).wheel()
    assert whole.motor_constant == 0.0228


def test_a_wrong_noise_and_impossible_speeds_are_suspected(record, changed):
    ramps = record("viscous-coulomb", "ramps")
    stated = identify_coast(ramps, inertia=INERTIA, speed_sigma=0.05)
    assert any("stated speed sigma is 0.05" in w for w in stated.warnings)
    fast = changed(ramps, speed=ramps.speed * 1000.0)
    assert any("units" in w for w in identify_coast(fast, inertia=INERTIA).warnings)
    assert identify_coast(ramps, inertia=INERTIA).warnings == ()


def test_sigma_that_allows_for_correlation_is_never_the_smaller_one(record):
    for seed in range(10):
        fit = identify_coast(record("viscous-coulomb", "ramps", seed=seed), inertia=INERTIA)
        assert np.all(fit.sigma >= fit.noise_sigma)


def test_crossings_are_those_of_the_measured_speed(record):
    """Ramps of alternating sign, one a minute: the sense changes between them."""
    ramps = record("viscous-coulomb", "ramps")
    assert identify_coast(ramps, inertia=INERTIA).crossings == 4
