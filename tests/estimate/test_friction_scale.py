"""The filter that carries a friction model: consistent, right, and quick to see a change."""

import numpy as np
import pytest
from scipy.stats import chi2

from gyrostat._jax import jax, jnp
from gyrostat.errors import InputError
from gyrostat.estimate import FrictionScaleFilter
from gyrostat.friction import Stribeck
from gyrostat.wheel import Wheel, advance

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
def tracked(current, scales, noise):
    """A wheel whose friction has these scales, and the filter on its noisy speed."""

    def tick(carry, now):
        speed, estimate = carry
        drive, scale, draw = now
        estimate = FILTER.correct(estimate, speed + draw)
        after = advance(scaled(scale), speed, drive, 0.0, PERIOD).speed
        return (after, FILTER.predict(estimate, drive, PERIOD)), (speed, estimate)

    start = (jnp.array(0.0), FILTER.start(0.0, SIGMA))
    return jax.lax.scan(tick, start, (current, scales, noise))[1]


def profile():
    """Steps of alternating sign: nine crossings."""
    return jnp.asarray(0.08 * (-1.0) ** (np.arange(COUNT) // 40))


def test_it_is_consistent_over_many_walks():
    """Normalised innovation and estimation errors are chi-square where the truth walks so."""
    random = np.random.default_rng(0)
    runs = 60
    first = 1.0 + 0.3 * random.standard_normal((runs, 1))
    walk = DRIFT * np.sqrt(PERIOD) * random.standard_normal((runs, COUNT - 1)).cumsum(axis=1)
    scales = np.maximum(np.concatenate([first, first + walk], axis=1), 0.2)
    noise = SIGMA * random.standard_normal((runs, COUNT))
    speed, found = jax.vmap(tracked, (None, 0, 0))(profile(), scales, noise)
    late = slice(100, None)
    nis = np.asarray(found.innovation**2 / found.innovation_variance)[:, late]
    low, high = chi2.ppf([0.0005, 0.9995], nis.size) / nis.size
    assert low < nis.mean() < high
    error = np.asarray(found.state[:, -1, 1] - scales[:, -1])
    total = np.sum(error**2 / np.asarray(found.covariance[:, -1, 1, 1]))
    low, high = chi2.ppf([0.0005, 0.9995], runs)
    assert low < total < high
    assert np.std(np.asarray(found.state[:, late, 0]) - np.asarray(speed)[:, late]) < 0.6 * SIGMA


def test_a_step_of_friction_is_found():
    random = np.random.default_rng(1)
    scales = np.where(np.arange(COUNT) < 200, 1.0, 1.5)
    _, found = tracked(profile(), scales, SIGMA * random.standard_normal(COUNT))
    assert np.asarray(found.state)[199, 1] == pytest.approx(1.0, abs=0.05)
    assert np.asarray(found.state)[-1, 1] == pytest.approx(1.5, abs=0.1)


def test_a_missing_measurement_is_counted_and_left_out():
    noise = np.zeros(COUNT)
    noise[50] = np.nan
    _, found = tracked(profile(), np.ones(COUNT), noise)
    assert float(found.missed[-1]) == 1.0
    assert np.all(np.isfinite(found.state))


def test_the_friction_torque_is_that_of_the_scaled_curve():
    estimate = FILTER.start(20.0)._replace(state=jnp.array([20.0, 1.2]))
    torque, sigma = FILTER.friction(estimate)
    assert float(torque) == pytest.approx(1.2 * float(MODEL.torque(20.0, 1.0)), rel=1e-12)
    expected = np.hypot(1.2 * 4.83e-6 * SIGMA, 0.3 * float(MODEL.torque(20.0, 1.0)))
    assert float(sigma) == pytest.approx(expected, rel=1e-9)


def test_what_is_no_covariance_is_refused():
    with pytest.raises(InputError, match="speed_sigma: found 0"):
        FrictionScaleFilter(WHEEL, 0.0, DRIFT).check()
