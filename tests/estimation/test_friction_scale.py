"""The filter that carries a friction model: consistent, right, and quick to see a change."""

import numpy as np
import pytest
from scipy.stats import chi2

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.wheel import Wheel, advance
from gyrostat.wheel.friction import Stribeck

MODEL = Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
WHEEL = Wheel(1.5e-3, 0.0228, MODEL)
SIGMA, DRIFT, PERIOD, COUNT = 0.5, 2e-3, 0.5, 400
FILTER = FrictionScaleFilter(WHEEL, SIGMA, DRIFT)


def scaled(factor):
    return Wheel(
        WHEEL.inertia,
        WHEEL.motor_constant,
        Stribeck(factor * 4.83e-6, factor * 0.8795e-3, factor * 0.9055e-3, 0.418879),
    )


@jax.jit
def _tracked(own, current, scales, noise):
    def tick(carry, now):
        speed, estimate = carry
        drive, scale, draw = now
        estimate = own.correct(estimate, speed + draw)
        after = advance(scaled(scale), speed, drive, 0.0, PERIOD).speed
        return (after, own.predict(estimate, drive, PERIOD)), (speed, estimate)

    return jax.lax.scan(tick, (jnp.array(0.0), own.start()), (current, scales, noise))[1]


def tracked(current, scales, noise, own=FILTER):
    """A wheel whose friction has these scales, and the filter on its noisy speed.

    Filters differ by numbers only, so that all share one program.
    """
    found = _tracked(jax.tree.map(np.float64, own), current, scales, noise)
    return jax.tree.map(np.asarray, found)


predicted = jax.jit(FILTER.predict)
corrected = jax.jit(FILTER.correct)


def started(speed):
    """Estimate without weak types, so that what takes it is compiled once."""
    return jax.tree.map(np.asarray, FILTER.start(speed))


def profile():
    """Steps of alternating sign: nine crossings."""
    return 0.08 * (-1.0) ** (np.arange(COUNT) // 40)


def test_it_is_consistent_over_many_walks():
    """Normalised innovation and estimation errors are chi-square where the truth walks so."""
    random = np.random.default_rng(0)
    runs = 60
    first = 1.0 + 0.3 * random.standard_normal((runs, 1))
    walk = DRIFT * np.sqrt(PERIOD) * random.standard_normal((runs, COUNT - 1)).cumsum(axis=1)
    scales = np.maximum(np.concatenate([first, first + walk], axis=1), 0.2)
    noise = SIGMA * random.standard_normal((runs, COUNT))
    flown = [tracked(profile(), *one) for one in zip(scales, noise, strict=True)]
    speed, found = jax.tree.map(lambda *runs: np.stack(runs), *flown)
    late = slice(100, None)
    nis = (found.innovation**2 / found.innovation_variance)[:, late]
    low, high = chi2.ppf([0.0005, 0.9995], nis.size) / nis.size
    assert low < nis.mean() < high
    error = found.state[:, -1, 1] - scales[:, -1]
    total = np.sum(error**2 / found.covariance[:, -1, 1, 1])
    low, high = chi2.ppf([0.0005, 0.9995], runs)
    assert low < total < high
    assert np.std(found.state[:, late, 0] - speed[:, late]) < 0.6 * SIGMA


def test_a_step_of_friction_is_found():
    random = np.random.default_rng(1)
    scales = np.where(np.arange(COUNT) < 200, 1.0, 1.5)
    _, found = tracked(profile(), scales, SIGMA * random.standard_normal(COUNT))
    assert found.state[199, 1] == pytest.approx(1.0, abs=0.05)
    assert found.state[-1, 1] == pytest.approx(1.5, abs=0.1)


def test_a_missing_measurement_is_counted_and_left_out():
    noise = np.zeros(COUNT)
    noise[50] = np.nan
    _, found = tracked(profile(), np.ones(COUNT), noise)
    assert float(found.missed[-1]) == 1.0
    assert np.all(np.isfinite(found.state))


def test_the_friction_torque_is_that_of_the_scaled_curve():
    estimate = FILTER.start(20.0)._replace(state=np.array([20.0, 1.2]))
    torque, sigma = jax.jit(FILTER.friction)(estimate)
    assert float(torque) == pytest.approx(1.2 * float(MODEL.torque(20.0, 1.0)), rel=1e-12)
    expected = np.hypot(1.2 * 4.83e-6 * SIGMA, 0.3 * float(MODEL.torque(20.0, 1.0)))
    assert float(sigma) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("shake", [0.0, 1e-5])
def test_a_wheel_that_turns_although_the_model_holds_it_is_believed(shake):
    """Half the friction of the model, and a current that the model would not move with."""
    current = 0.75 * float(MODEL.coulomb) / 0.0228
    own = FrictionScaleFilter(WHEEL, SIGMA, 2e-4, shake)
    noise = SIGMA * np.random.default_rng(3).standard_normal(COUNT)
    speed, found = tracked(np.full(COUNT, current), np.full(COUNT, 0.5), noise, own)
    assert float(found.state[3, 0]) == pytest.approx(0.0, abs=0.01)  # held, as the model says
    assert float(found.state[-1, 1]) == pytest.approx(0.5, abs=0.02)
    assert float(found.state[-1, 0]) == pytest.approx(float(speed[-1]), abs=SIGMA)


def test_a_wheel_at_rest_teaches_nothing_and_is_not_taken_to_turn():
    """Below breakaway only noise is measured: the scale stays, and its variance grows."""
    noise = SIGMA * np.random.default_rng(4).standard_normal(COUNT)
    speed, found = tracked(np.full(COUNT, 0.5 * 0.8795e-3 / 0.0228), np.ones(COUNT), noise)
    np.testing.assert_array_equal(speed, 0.0)
    np.testing.assert_allclose(found.state[5:, 1], found.state[5, 1], rtol=1e-12)
    np.testing.assert_allclose(
        np.diff(found.covariance[5:, 1, 1]), DRIFT**2 * PERIOD, rtol=1e-6, atol=1e-12
    )


def test_a_bearing_never_drives_its_wheel():
    """Speeds that only a driving friction could explain bring the scale to its end, not below."""
    estimate = started(10.0)
    for k in range(20):
        estimate = corrected(predicted(estimate, 0.0, PERIOD), 10.0 + 5.0 * k)
    assert float(estimate.scale) == pytest.approx(0.01)
    assert np.all(np.isfinite(estimate.covariance))


def test_a_period_that_is_not_resolved_is_counted():
    day = predicted(started(100.0), 0.1, 86400.0)
    assert float(day.unresolved) == 1.0
    assert float(predicted(started(100.0), 0.1, PERIOD).unresolved) == 0.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"speed_sigma": 0.0}, "speed_sigma: found 0"),
        ({"scale_drift": -1.0}, "scale_drift: found -1"),
        ({"torque_sigma": np.nan}, "torque_sigma: found nan"),
        ({"torque_sigma": -1e-5}, "torque_sigma: found -1e-05"),
        ({"wheel": Wheel(0.0, 0.0228, MODEL)}, "wheel inertia: found 0"),
        ({"wheel": Wheel(1.5e-3, 0.0, MODEL)}, "motor_constant: found 0"),
        (
            {
                "wheel": Wheel(
                    1.5e-3,
                    0.02,
                    Stribeck.of(viscous=1e-6, coulomb=1e-3, static=1e-3, stribeck_speed=0.0),
                )
            },
            "stribeck_speed: found",
        ),
    ],
)
def test_what_is_no_covariance_and_no_wheel_is_refused(change, message):
    options = {"wheel": WHEEL, "speed_sigma": SIGMA, "scale_drift": DRIFT, **change}
    with pytest.raises(InputError, match=message):
        FrictionScaleFilter(**options).check()
