"""Attitude and rate without a gyro, against a trajectory by SciPy and a Riccati equation."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_discrete_are
from scipy.spatial.transform import Rotation
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
from gyrostat.estimation import MomentumAttitudeFilter
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel import WheelArray

AXES = np.array([[1.0, 0.0], [0.0, 0.8], [0.0, 0.6]])
ROTOR, SCALE, PERIOD, SIGMA = 0.45, np.array([1.04, 0.97]), 0.2, 5e-5
CRAFT = Spacecraft(np.diag([40.0, 50.0, 60.0]), WheelArray(AXES, np.full(2, ROTOR)))
INERTIA = np.asarray(CRAFT.inertia_locked())
MOMENTUM = np.array([0.3, -0.2, 0.4])
COUNT = 600


def speed(time):
    return np.stack([3.0 * np.sin(0.05 * time), 2.0 * np.cos(0.04 * time)], axis=-1)


@pytest.fixture(scope="module")
def truth():
    """Attitudes, rates and wheel speeds of a body whose rotors are not those of the model."""

    def rate(time, rotation):
        held = AXES @ (ROTOR * SCALE * speed(time))
        return np.linalg.solve(INERTIA, rotation.inv().apply(MOMENTUM) - held)

    def slope(time, q):
        x, y, z, w = q
        turn = rate(time, Rotation.from_quat(q))
        return 0.5 * np.array([[w, -z, y], [z, w, -x], [-y, x, w], [-x, -y, -z]]) @ turn

    time = PERIOD * np.arange(COUNT)
    flown = solve_ivp(slope, time[[0, -1]], [0.0, 0.0, 0.0, 1.0], t_eval=time, rtol=1e-11)
    rotations = [Rotation.from_quat(q) for q in flown.y.T]
    rates = np.array([rate(t, r) for t, r in zip(time, rotations, strict=True)])
    return np.array([r.as_quat(scalar_first=True) for r in rotations]), rates, speed(time)


@jax.jit
def filtered(own, attitude, wheel_speed, measured):
    def step(estimate, row):
        q, s, sees = row
        estimate = own.correct(own.predict(estimate, s, PERIOD), q, sees)
        return estimate, (estimate, own.rate(estimate, s))

    return jax.lax.scan(step, own.start(), (attitude, wheel_speed, measured))[1]


def test_exact_measurements_give_rate_momentum_and_the_true_rotors(truth):
    attitude, rate, wheel_speed = truth
    sees = np.arange(COUNT) % 4 == 0
    # a tracker that sees nothing gives nonsense
    given = np.where(sees[:, None], attitude, [0.0, 1.0, 0.0, 0.0])
    own = MomentumAttitudeFilter(CRAFT, jnp.asarray(1e-6), 4.0, bandwidth=jnp.asarray(0.2))
    found, seen_rate = filtered(own, given, wheel_speed, sees)
    late = slice(COUNT // 2, None)
    # the trapezoid of the wheel speeds is right to second order in the period
    assert np.max(np.abs(seen_rate - rate)[late]) < 2e-6
    assert np.allclose(found.momentum[late], MOMENTUM, atol=1e-4)
    assert np.allclose(found.scale[-1], SCALE, atol=1e-3)
    assert np.all(np.asarray(found.innovation)[~sees] == 0.0)


def test_nothing_moves_before_the_first_sample_of_the_star_tracker():
    """Turning wheels alone do not tell the body rate."""
    own, turning = MomentumAttitudeFilter(CRAFT, SIGMA), np.array([100.0, -50.0])
    predict, correct, rate = map(eqx.filter_jit, (own.predict, own.correct, own.rate))
    # no weak types, so that each is compiled once
    first = estimate = jax.tree.map(np.asarray, own.start())
    for _ in range(2):
        estimate = predict(estimate, turning, PERIOD)
        estimate = correct(estimate, np.array([0.6, 0.8, 0.0, 0.0]), np.array(False))
        np.testing.assert_array_equal(rate(estimate, turning), 0.0)
        np.testing.assert_array_equal(estimate.attitude, first.attitude)
    estimate = correct(estimate, np.array([0.6, 0.8, 0.0, 0.0]), np.array(True))
    np.testing.assert_allclose(rate(estimate, turning), 0.0, atol=1e-12)
    np.testing.assert_allclose(rate(estimate, 2.0 * turning), -rate(estimate, 0.0 * turning), 1e-9)


def test_the_covariance_is_carried_by_the_derivative_of_the_motion():
    """The linear error equations against central differences of the filter's own prediction."""
    own = MomentumAttitudeFilter(CRAFT, jnp.asarray(SIGMA), bandwidth=jnp.asarray(1e-9))
    q = jnp.array([0.4, -0.2, 0.8, 0.4])
    begun = own.start()._replace(
        attitude=q / jnp.linalg.norm(q),
        momentum=jnp.asarray(20.0 * MOMENTUM),
        scale=jnp.asarray(SCALE),
        wheel_speed=jnp.array([3.0, -5.0]),
        started=jnp.array(True),
    )

    def moved(offset):
        turned = product(begun.attitude, from_rotation_vector(offset[:3]))
        start = begun._replace(
            attitude=turned,
            momentum=begun.momentum + offset[3:6],
            scale=begun.scale + offset[6:],
        )
        return own.predict(start, jnp.array([4.0, -6.0]), PERIOD)

    still = moved(jnp.zeros(8))
    small = 1e-5 * np.eye(8)

    @jax.jit
    @jax.vmap
    def apart(offset):
        later = moved(offset)
        turn = rotation_vector(error(later.attitude, still.attitude))
        return jnp.concatenate([turn, later.momentum, later.scale]) / 1e-5

    forward = 0.5 * (apart(small) - apart(-small)).T
    random = np.random.default_rng(4).standard_normal((8, 8))
    carried = own.predict(
        begun._replace(covariance=jnp.asarray(random @ random.T)), jnp.array([4.0, -6.0]), PERIOD
    ).covariance
    expected = forward @ (random @ random.T) @ forward.T
    # the midpoint makes the state right to second order, the derivative drops third order
    assert np.allclose(carried, expected, atol=2e-4 * np.max(np.abs(expected)))
    assert not np.allclose(carried, random @ random.T, atol=0.1)


def test_the_steady_covariance_solves_the_riccati_equation_of_its_bandwidth():
    """At rest with trusted rotors: two states an axis, and poles of the magnitude B."""
    own = MomentumAttitudeFilter(
        CRAFT, jnp.asarray(SIGMA), 3.0, bandwidth=jnp.asarray(0.1), rotor_sigma=jnp.asarray(0.0)
    )
    still = np.tile([1.0, 0.0, 0.0, 0.0], (3000, 1))
    found, _ = filtered(own, still, np.zeros((3000, 2)), np.arange(3000) % 3 == 0)
    last = np.asarray(found.covariance[-3])  # a sample with correction
    span = 3.0 * PERIOD
    forward, sees = np.array([[1.0, span], [0.0, 1.0]]), np.array([[1.0], [0.0]])
    # the walk of the rate in each of the three periods, carried to the sample
    each = [np.array([(3 - k) * PERIOD, 1.0]) for k in range(3)]
    noise = 0.1**4 * SIGMA**2 * 3.0 * PERIOD**2 * sum(np.outer(e, e) for e in each)
    # in units of 1e-5 rad, so that the solver's tolerances mean something
    before = solve_discrete_are(forward.T, sees, noise * 1e10, [[SIGMA**2 * 1e10]]) / 1e10
    gain = before[:, 0] / (before[0, 0] + SIGMA**2)
    to_rate = np.diag([1.0, 1.0 / INERTIA[0, 0]])
    found = to_rate @ last[np.ix_([0, 3], [0, 3])] @ to_rate
    assert np.allclose(found, before - np.outer(gain, before[0]), rtol=1e-6)
    poles = np.linalg.eigvals((np.eye(2) - np.outer(gain, [1.0, 0.0])) @ forward)
    assert np.allclose(np.abs(np.log(poles.astype(complex))) / span, 0.1, rtol=0.05)


def test_errors_are_as_large_as_the_filter_says():
    """Normalised estimation error squared of all states, in 64 runs of the filter's own model."""
    own = MomentumAttitudeFilter(
        CRAFT, jnp.asarray(SIGMA), bandwidth=jnp.asarray(0.05), rate_sigma=jnp.asarray(0.01)
    )
    first, runs = jnp.asarray(speed(0.0)), 64

    def step(carry, row):
        true, estimate = carry
        s, key = row
        drift, noise = jax.random.normal(key, (2, 3))
        walk = 0.05**2 * SIGMA * PERIOD * jnp.asarray(INERTIA) @ drift
        true = true._replace(momentum=true.momentum + to_inertial(true.attitude, walk))
        true = own.predict(true, s, PERIOD)
        seen = product(true.attitude, from_rotation_vector(SIGMA * noise))
        return (true, own.correct(own.predict(estimate, s, PERIOD), seen, True)), None

    @jax.jit
    @jax.vmap
    def errors(key):
        keys = jax.random.split(key, COUNT)
        small = jax.random.normal(keys[0], (8,))
        scale = 1.0 + 0.1 * small[6:]
        held = jnp.asarray(AXES) @ (ROTOR * scale * first)
        begun = own.correct(own.start()._replace(wheel_speed=first), own.start().attitude, True)
        true = begun._replace(
            attitude=from_rotation_vector(SIGMA * small[:3]),
            momentum=held + 0.01 * jnp.asarray(INERTIA) @ small[3:6],
            scale=scale,
        )
        rows = (jnp.asarray(speed(PERIOD * np.arange(1, COUNT))), keys[1:])
        (true, last), _ = jax.lax.scan(step, (true, begun), rows)
        turn = rotation_vector(error(true.attitude, last.attitude))
        off = (turn, true.momentum - last.momentum, true.scale - last.scale)
        return jnp.concatenate(off), last.covariance

    off, covariance = map(np.asarray, errors(jax.random.split(jax.random.key(8), runs)))
    squared = np.einsum("ri,rij,rj->r", off, np.linalg.inv(covariance), off)
    low, high = chi2(8 * runs).ppf([1e-3, 1.0 - 1e-3]) / runs
    assert low < np.mean(squared) < high


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"attitude_sigma": 0.0}, "attitude sigma: found 0"),
        ({"periods": 1.5}, "star tracker periods"),
        ({"bandwidth": -0.1}, "attitude filter bandwidth"),
        ({"rotor_sigma": np.nan}, "rotor sigma"),
        ({"rate_sigma": 0.0}, "initial rate sigma"),
    ],
)
def test_bad_parameters_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        dataclasses.replace(MomentumAttitudeFilter(CRAFT, SIGMA), **change).check()
