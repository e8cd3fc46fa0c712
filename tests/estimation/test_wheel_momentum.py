"""The momentum filter against a Kalman filter in matrix form, and against its own statistics."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import WheelMomentumFilter
from gyrostat.estimation.wheel_momentum import JUMP, MEMORY, SURPRISE, UNKNOWN_TORQUE

COUNT = 400
WHEEL, TABLE = 1.5e-3, 0.495


@jax.jit
def filtered(own, speed, rate, period):
    """Estimates after every sample."""

    def tick(estimate, now):
        corrected = own.correct(estimate, *now)
        return own.predict(corrected, period), corrected

    return jax.lax.scan(tick, own.start(), (speed, rate))[1]


def make(sigma, drift, wheel=WHEEL, table=TABLE):
    return WheelMomentumFilter(*(jnp.asarray(x, float) for x in (wheel, table, sigma, drift)))


def walk_covariance(drift, period):
    """Of momentum and torque after a period of a random walk in torque."""
    return drift**2 * np.array([[period**3 / 3.0, period**2 / 2.0], [period**2 / 2.0, period]])


def textbook(measured, noise, drift, period, jump=JUMP):
    """Predict and correct with matrices, the correction in Joseph form, restarts included."""
    transition = np.array([[1.0, period], [0.0, 1.0]])
    observe = np.array([[1.0, 0.0]])
    x = np.array([measured[0], 0.0])
    p = np.diag([noise, UNKNOWN_TORQUE**2 * noise])
    states, covariances, mean = [x], [p], 0.0
    for z in measured[1:]:
        x = transition @ x
        p = transition @ p @ transition.T + walk_covariance(drift, period)
        total = (observe @ p @ observe.T).item() + noise
        gain = p @ observe.T / total
        innovation = z - (observe @ x).item()
        x = x + gain[:, 0] * innovation
        keeps = np.eye(2) - gain @ observe
        p = keeps @ p @ keeps.T + noise * gain @ gain.T
        mean = (1.0 - 1.0 / MEMORY) * mean + innovation / np.sqrt(total) / MEMORY
        # variance of an exponential mean with forgetting factor 1 - 1/N: 1 / (2 N - 1)
        if abs(mean) > SURPRISE / np.sqrt(2.0 * MEMORY - 1.0):
            p[1, 1] += (jump * np.sqrt(noise)) ** 2
            mean = 0.0
        states.append(x)
        covariances.append(p)
    return np.array(states), np.array(covariances)


@pytest.mark.parametrize(
    ("sigma", "drift", "period"), [(0.5, 1e-6, 0.1), (0.02, 3e-3, 0.5), (5.0, 1e-9, 0.01)]
)
def test_equals_the_matrix_form_on_random_data(sigma, drift, period):
    random = np.random.default_rng(2)
    speed = 30.0 * random.standard_normal(COUNT).cumsum()
    rate = 0.1 * random.standard_normal(COUNT)
    found = filtered(make(sigma, drift), speed, rate, period)
    measured = WHEEL * speed + (WHEEL + TABLE) * rate
    states, covariances = textbook(measured, (WHEEL * sigma) ** 2, drift, period)
    for ours, theirs in (
        (found.momentum, states[:, 0]),
        (found.torque, states[:, 1]),
        (found.momentum_variance, covariances[:, 0, 0]),
        (found.covariance, covariances[:, 0, 1]),
        (found.torque_variance, covariances[:, 1, 1]),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.max(np.abs(theirs)))


def test_a_torque_that_jumps_is_found_again():
    sigma, drift, period = 0.5, 6e-7, 0.1
    random = np.random.default_rng(3)
    time = period * np.arange(4000)
    momentum = 0.46e-3 * time + 0.1e-3 * np.maximum(time - 200.0, 0.0)
    speed = momentum / WHEEL + sigma * random.standard_normal(len(time))
    found = filtered(make(sigma, drift), speed, np.zeros(len(time)), period)
    plain, _ = textbook(WHEEL * speed, (WHEEL * sigma) ** 2, drift, period, jump=0.0)
    after = time > 230.0
    ours = np.max(np.abs(np.asarray(found.torque)[after] - 0.56e-3))
    assert ours < 0.5 * np.max(np.abs(plain[after, 1] - 0.56e-3))
    assert ours < 0.03e-3
    late = np.abs(np.asarray(found.momentum) - momentum)[after]
    assert np.max(late) < 5.0 * np.sqrt(np.max(np.asarray(found.momentum_variance)[after]))


@given(
    st.floats(1e-6, 1e3),
    st.floats(-9.0, 2.0),
    st.floats(1e-3, 1e3),
    st.floats(1e-6, 10.0),
    st.integers(0, 2**31),
)
def test_the_covariance_stays_positive(sigma, drift, period, wheel, seed):
    random = np.random.default_rng(seed)
    speed, rate = random.standard_normal((2, COUNT)) * 100.0
    found = filtered(make(sigma, 10.0**drift * wheel, wheel), speed, rate, period)
    assert all(np.all(np.isfinite(x)) for x in found)
    own, both, torque = (np.asarray(x) for x in found[2:5])
    assert np.all(own > 0.0)
    assert np.all(torque > 0.0)
    assert np.all(both**2 <= own * torque * (1.0 + 1e-9))
    # a measurement is never worse than none
    assert np.all(own <= (wheel * sigma) ** 2 * (1.0 + 1e-12))


def test_errors_are_as_large_as_the_filter_says():
    """Normalised error squared over many histories drawn from the filter's own model."""
    sigma, drift, period, runs = 0.5, 2e-5, 0.1, 200
    random = np.random.default_rng(5)
    noise = WHEEL * sigma
    root = np.linalg.cholesky(walk_covariance(drift, period))
    momentum = random.uniform(-0.1, 0.1, runs)
    torque = UNKNOWN_TORQUE * noise * random.standard_normal(runs)
    truth, speed = [], []
    rate = 0.05 * np.sin(0.3 * period * np.arange(COUNT))
    for k in range(COUNT):
        truth.append((momentum, torque))
        exact = (momentum - (WHEEL + TABLE) * rate[k]) / WHEEL
        speed.append(exact + sigma * random.standard_normal(runs))
        steps = root @ random.standard_normal((2, runs))
        momentum, torque = momentum + period * torque + steps[0], torque + steps[1]
    truth = np.array(truth)
    own = make(sigma, drift)
    found = jax.vmap(lambda s: filtered(own, s, rate, period), 1, 1)(np.array(speed))
    errors = np.stack([found.momentum, found.torque], -1) - np.moveaxis(truth, 1, -1)
    covariance = np.array(
        [[found.momentum_variance, found.covariance], [found.covariance, found.torque_variance]]
    )
    covariance = np.moveaxis(covariance, (0, 1), (-2, -1))
    for k in (0, 1, 5, 30, 100, COUNT - 1):
        solved = np.linalg.solve(covariance[k], errors[k][..., None])[..., 0]
        total = np.sum(solved * errors[k])
        low, high = chi2.ppf([1e-4, 1.0 - 1e-4], 2 * runs)
        assert low < total < high, (k, total)
    # and the speed with its standard deviation
    exact = (truth[-1, 0] - (WHEEL + TABLE) * rate[-1]) / WHEEL
    last = jax.tree.map(lambda x: x[-1], found)
    speed, spread = own.speed(last, rate[-1])
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], runs)
    assert low < np.sum(((speed - exact) / spread) ** 2) < high
    assert np.all(np.asarray(spread) < 0.3 * sigma)


def test_a_steady_torque_is_found_and_friction_does_not_disturb_the_speed():
    """Momentum that a fan builds up; the table swings as it likes."""
    time = 0.1 * np.arange(COUNT)
    rate = 0.02 * np.sin(0.5 * time)
    speed = (-0.02 + 4e-4 * time - (WHEEL + TABLE) * rate) / WHEEL
    own = make(0.5, 1e-7)
    found = filtered(own, speed, rate, 0.1)
    assert float(found.torque[-1]) == pytest.approx(4e-4, rel=1e-6)
    np.testing.assert_allclose(own.speed(found, rate)[0][200:], speed[200:], atol=1e-3)
