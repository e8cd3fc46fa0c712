"""The attitude filter against Farrenkopf's solution, a Riccati equation and its own statistics."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are
from scipy.stats import chi2

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import (
    error,
    from_rotation_vector,
    product,
    rotation_vector,
    to_inertial,
)
from gyrostat.estimation import AttitudeFilter
from gyrostat.spacecraft import (
    Gyrostat,
    RateGyro,
    Spacecraft,
    SpacecraftSensor,
    StarTracker,
    TrackerGyroSensors,
)
from gyrostat.wheel import WheelArray

SIGMA = np.array([5e-5, 5e-5, 4e-4])
ANGLE, BIAS, FIRST = 2e-5, 3e-6, 1e-3
FILTER = AttitudeFilter(SIGMA, ANGLE, BIAS, FIRST)
PERIOD = 0.25


@jax.jit
def _steady(attitude_filter, period):
    """Covariances before and after a correction, at rest, after long."""
    still = jnp.array([1.0, 0.0, 0.0, 0.0])

    def step(estimate, _):
        before = attitude_filter.predict(estimate, jnp.zeros(3), period)
        after = attitude_filter.correct(before, still, jnp.array(True))
        return after, None

    begun = attitude_filter.correct(attitude_filter.start(), still, jnp.array(True))
    last, _ = jax.lax.scan(step, begun, length=4000)
    before = attitude_filter.predict(last, jnp.zeros(3), period)
    return before.covariance, attitude_filter.correct(before, still, jnp.array(True)).covariance


@pytest.mark.parametrize(
    ("angle", "bias", "period"), [(ANGLE, BIAS, PERIOD), (1e-6, 1e-5, 1.0), (3e-4, 1e-5, 0.1)]
)
def test_the_steady_covariance_is_that_of_farrenkopf(angle, bias, period):
    """One axis in closed form: sigma_n² (xi² - 1) before a sample, sigma_n² (1 - 1/xi²) after."""
    tried = AttitudeFilter(SIGMA, jnp.asarray(angle), jnp.asarray(bias), jnp.asarray(FIRST))
    before, after = map(np.asarray, _steady(tried, jnp.asarray(period)))
    s_u, s_v = bias * period**1.5 / SIGMA, angle * period**0.5 / SIGMA
    gamma = np.sqrt(4.0 + s_v**2 + s_u**2 / 12.0)
    xi = 0.5 * (gamma + 0.5 * s_u + np.sqrt(gamma * s_u + s_v**2 + s_u**2 / 3.0))
    np.testing.assert_allclose(np.diag(before)[:3], SIGMA**2 * (xi**2 - 1.0), rtol=1e-7)
    np.testing.assert_allclose(np.diag(after)[:3], SIGMA**2 * (1.0 - xi**-2), rtol=1e-7)


def test_the_steady_covariance_solves_the_riccati_equation():
    """All of it, for all axes; the noise of the step derived by hand."""
    before, _ = _steady(jax.tree.map(jnp.asarray, FILTER), jnp.asarray(PERIOD))
    unit, none = np.eye(3), np.zeros((3, 3))
    forward = np.block([[unit, -PERIOD * unit], [none, unit]])
    angle = ANGLE**2 * PERIOD + BIAS**2 * PERIOD**3 / 3.0
    both = -0.5 * BIAS**2 * PERIOD**2
    noise = np.kron([[angle, both], [both, BIAS**2 * PERIOD]], unit)
    seen = np.hstack([unit, none])
    # in units of 1e-5, so that the solver's tolerances mean something
    expected = solve_discrete_are(forward.T, seen.T, noise * 1e10, np.diag(SIGMA**2) * 1e10) / 1e10
    np.testing.assert_allclose(before, expected, rtol=1e-6, atol=1e-9 * np.max(expected))


RUNS, SAMPLES = 128, 400
RATE = np.array([0.02, -0.03, 0.05])
"""rad/s: five radians in all."""


@pytest.fixture(scope="module")
def batch():
    """Runs of sensors and filter on a turning body, each with a bias and noise of its own."""
    body = Spacecraft(np.eye(3), WheelArray(np.eye(3), np.full(3, 1e-3)))
    plant = Gyrostat(body)
    times = PERIOD * jnp.arange(SAMPLES)
    attitudes = jax.vmap(lambda t: from_rotation_vector(jnp.asarray(RATE) * t))(times)
    momentum = body.inertia_locked() @ RATE

    def single(key):
        first, second = jax.random.split(key)
        gyro = RateGyro(ANGLE, BIAS, FIRST * jax.random.normal(first, (3,)))
        sensors = TrackerGyroSensors(SpacecraftSensor(plant), StarTracker(SIGMA, 4), gyro)

        def state_at(attitude):
            inertial = to_inertial(attitude, momentum)
            return SimpleNamespace(attitude=attitude, momentum=inertial, wheel_speed=jnp.zeros(3))

        def step(carry, now):
            memory, estimate = carry
            attitude, key = now
            memory, seen = sensors(memory, state_at(attitude), key)
            estimate = FILTER.predict(estimate, seen.rate, PERIOD)
            estimate = FILTER.correct(estimate, seen.attitude, seen.attitude_measured)
            turn = rotation_vector(error(attitude, estimate.attitude))
            lacks = jnp.concatenate([turn, memory.gyro - estimate.bias])
            row = (lacks, estimate.covariance, estimate.surprise, seen.attitude_measured)
            return (memory, estimate), row

        start = (sensors.start(state_at(attitudes[0]), PERIOD), FILTER.start())
        return jax.lax.scan(step, start, (attitudes, jax.random.split(second, SAMPLES)))[1]

    found = jax.jit(jax.vmap(single))(jax.random.split(jax.random.key(20), RUNS))
    return map(np.asarray, found)


def test_errors_and_innovations_have_the_covariance_that_the_filter_tells(batch):
    """Normalised errors and innovations squared over a seeded batch, two-sided at 1e-4 each."""
    errors, covariances, surprises, measured = batch

    def fits(total, freedom):
        return 5e-5 < chi2.cdf(total, freedom) < 1.0 - 5e-5

    assert np.array_equal(measured[0], np.arange(SAMPLES) % 4 == 0)
    for k in (3, 40, 200, SAMPLES - 1):
        weighed = np.linalg.solve(covariances[:, k], errors[:, k, :, None])[..., 0]
        assert fits(np.sum(weighed * errors[:, k]), 6 * RUNS)
    later = surprises[:, 4::4]
    assert fits(np.sum(later), 3 * later.size)
    assert np.all(surprises[:, 1::4] == 0.0)
    # and it does estimate: far better than the tracker, and than the bias at the start
    assert np.sqrt(np.mean(errors[:, -1, 2] ** 2)) < 0.5 * SIGMA[2]
    assert np.sqrt(np.mean(errors[:, -1, 3:5] ** 2)) < 0.05 * FIRST


def test_the_term_for_coning_keeps_the_attitude_of_a_coning_body():
    """Without noise, once round a cone: each period is off by sin²(angle) (x - sin x) / 2."""
    angle, rate, samples = 0.1, 0.5, 64
    period = 2.0 * np.pi / rate / samples
    phase = 2.0 * np.pi * np.arange(-1, samples) / samples
    # integral of rate (-sin a sin, sin a cos, cos a - 1) over each period
    ends = np.stack([phase, phase + 2.0 * np.pi / samples])
    swept = np.sin(angle) * np.diff([np.cos(ends), np.sin(ends)], axis=1)[:, 0]
    drift = np.full(samples + 1, (np.cos(angle) - 1.0) * rate * period)
    turns = np.stack([*swept, drift], axis=1) / period
    off = {}
    for coning in (0.0, 1.0):
        tried = AttitudeFilter(SIGMA, ANGLE, BIAS, FIRST, jnp.asarray(coning))
        carried = jax.jit(
            lambda start, rates, tried=tried: jax.lax.scan(
                lambda e, r: (tried.predict(e, r, period), None), start, rates
            )[0]
        )
        begun = tried.start()._replace(turn=jnp.asarray(period * turns[0]))
        end = carried(begun, jnp.asarray(turns[1:]))
        off[coning] = np.asarray(rotation_vector(end.attitude))
    step = 2.0 * np.pi / samples
    known = samples * 0.5 * np.sin(angle) ** 2 * (step - np.sin(step))
    assert np.linalg.norm(off[0.0]) == pytest.approx(known, rel=0.01)
    assert np.linalg.norm(off[1.0]) < 3e-3 * known


def test_the_first_attitude_begins_wherever_it_is():
    measured = from_rotation_vector(jnp.array([2.0, -1.0, 0.5]))
    correct = jax.jit(lambda *given: FILTER.correct(*given))
    waiting = correct(FILTER.start(), measured, jnp.array(False))
    assert not waiting.started
    begun = correct(waiting, measured, jnp.array(True))
    np.testing.assert_allclose(begun.attitude, measured)
    np.testing.assert_allclose(np.diag(begun.covariance), [*SIGMA**2, *[FIRST**2] * 3])
    assert begun.started


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, ANGLE, BIAS, FIRST), "attitude sigma"),
        ((SIGMA, 0.0, BIAS, FIRST), "angle walk"),
        ((SIGMA, ANGLE, np.nan, FIRST), "bias walk"),
        ((SIGMA, ANGLE, BIAS, -1.0), "bias sigma"),
    ],
)
def test_noise_that_is_none_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        AttitudeFilter(*values).check()


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (StarTracker(-1.0), "star tracker sigma"),
        (StarTracker(1e-4, 0), "star tracker periods"),
        (StarTracker(1e-4, 1.5), "star tracker periods"),
        (RateGyro(angle_walk=-1.0), "angle walk"),
        (RateGyro(bias=np.array([0.0, np.inf, 0.0])), "gyro bias"),
    ],
)
def test_sensors_that_are_none_are_refused(part, message):
    with pytest.raises(InputError, match=message):
        part.check()


def test_the_bias_acts_as_the_mean_rotation_of_a_period():
    """Mean of exp(-[turn]x s) over 0 <= s <= 1, by quadrature, for a turn of 0.3 rad."""
    turn = np.array([0.2, -0.1, 0.2])
    cross = np.array([[0.0, -turn[2], turn[1]], [turn[2], 0.0, -turn[0]], [-turn[1], turn[0], 0.0]])
    points, weights = np.polynomial.legendre.leggauss(12)
    nodes = zip(points, weights, strict=True)
    mean = sum(0.5 * w * expm(-cross * 0.5 * (p + 1.0)) for p, w in nodes)
    bias_only = jnp.zeros((6, 6)).at[3:, 3:].set(jnp.eye(3))
    begun = FILTER.start()._replace(covariance=bias_only)
    predicted = FILTER.predict(begun, jnp.asarray(turn) / PERIOD, PERIOD)
    shared = np.asarray(predicted.covariance)[:3, 3:] / PERIOD
    np.testing.assert_allclose(shared, -mean, atol=3e-6)


def test_a_rate_that_changes_linearly_is_followed_by_default():
    """Savage's coning term, against small steps of the same motion."""
    period, first, change = 0.5, np.array([0.2, 0.0, 0.1]), np.array([0.0, 0.3, -0.1])

    def turn(begin, end):
        return first * (end - begin) + 0.5 * change * (end**2 - begin**2)

    fine = np.linspace(period, 2.0 * period, 20001)
    exact = jnp.array([1.0, 0.0, 0.0, 0.0])
    steps = jnp.asarray([turn(*pair) for pair in pairwise(fine)])
    exact, _ = jax.lax.scan(
        lambda q, step: (product(q, from_rotation_vector(step)), 0), exact, steps
    )
    begun = FILTER.start()._replace(turn=jnp.asarray(turn(0.0, period)))
    followed = FILTER.predict(begun, jnp.asarray(turn(period, 2.0 * period)) / period, period)
    missed = [
        float(jnp.linalg.norm(error(estimate, exact)[1:]))
        for estimate in (
            followed.attitude,
            from_rotation_vector(jnp.asarray(turn(period, 2.0 * period))),
        )
    ]
    assert missed[0] < 0.05 * missed[1]
