"""Sweeps against numerical integration, optimality and their own limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.control.underactuated.recovery.rest_to_rest import (
    Sweep,
    progress,
    rate_axis,
    shortest,
    timed,
    turned,
)
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp

SPEED, ACCELERATION = 0.19, 0.09 / 16.0
MEMBER = st.floats(-1.0, 1.0)


@jax.jit
def sweep_of(turn):
    return timed(*shortest(turn), SPEED, ACCELERATION)


@jax.jit
def missed(turn):
    sweep = sweep_of(turn)
    return rotations.error_angle(turned(sweep, sweep.length), turn)


def unit(quaternion):
    return np.asarray(quaternion, dtype=float) / np.linalg.norm(quaternion)


@given(st.tuples(MEMBER, MEMBER, MEMBER, MEMBER), st.integers(0, 12), st.sampled_from([0, 1, 2]))
@settings(max_examples=300)
def test_a_sweep_makes_any_turn(members, power, which):
    """Large turns, small turns, turns nearly about z and nearly across it."""
    scale = 10.0**-power
    members = (
        np.array(members)
        * ([1, scale, scale, scale], [1, scale, scale, 1], [1, 1, 1, scale])[which]
    )
    if np.linalg.norm(members) < 1e-3:
        members = np.array([1.0, 0.0, 0.0, 0.0])
    assert missed(unit(members)) < 1e-7


@pytest.mark.parametrize(
    "turn",
    [(1, 0, 0, 0), (0, 0, 0, 1), (0, 0, 0, -1), (0, 1, 0, 0), (0, 0, -1, 0), (-1, 0, 0, 0)],
)
def test_turns_at_the_edges(turn):
    assert missed(unit(turn)) < 1e-7
    assert np.all(np.isfinite(jax.tree.leaves(sweep_of(unit(turn)))))


def test_a_twist_is_a_closed_loop_of_known_length():
    """Length sqrt(psi (4 pi - psi)) of the loop that twists a rolling ball by psi."""
    for twist in (1e-3, 0.1, 1.0, np.pi):
        turn = np.array([np.cos(0.5 * twist), 0.0, 0.0, np.sin(0.5 * twist)])
        assert sweep_of(turn).length == pytest.approx(
            np.sqrt(twist * (4 * np.pi - twist)), rel=1e-6
        )


def test_a_turn_across_z_is_a_plain_turn():
    vector = np.array([0.3, -1.2, 0.0])
    sweep = sweep_of(Rotation.from_rotvec(vector).as_quat(scalar_first=True))
    assert sweep.length == pytest.approx(np.linalg.norm(vector), rel=1e-9)
    assert abs(sweep.curvature) < 1e-6
    assert sweep.direction == pytest.approx(np.arctan2(-1.2, 0.3), abs=1e-6)


def test_the_attitude_on_the_way_is_the_integral_of_the_rate():
    """Every rate is across z, and the closed form is what scipy integrates from it."""
    sweep = timed(jnp.array(0.7), jnp.array(-0.9), jnp.array(3.0), SPEED, ACCELERATION)
    turn, move = jax.jit(rotations.rate_of_quaternion), jax.jit(progress)
    axis = jax.jit(rate_axis)

    def slope(time, attitude):
        angle, rate = move(sweep, time)
        vector = rate * axis(sweep, angle)
        assert vector[2] == 0.0
        return np.asarray(turn(jnp.asarray(attitude), vector))

    duration = float(sweep.duration)
    grid = np.linspace(0.0, duration, 7)
    found = solve_ivp(slope, (0.0, duration), [1.0, 0, 0, 0], t_eval=grid, rtol=1e-9, atol=1e-11)
    there = jax.jit(turned)
    expected = [there(sweep, move(sweep, time)[0]) for time in grid]
    np.testing.assert_allclose(found.y.T, expected, atol=1e-7)


def total(steps):
    """Sum of the angles of turns about axes of the plane."""
    return jnp.sum(jnp.linalg.norm(steps.reshape(-1, 2), axis=1))


def off(steps, wanted):
    """Vector part of the rotation from the end of a chain of turns to a wanted attitude."""

    def add(attitude, step):
        vector = jnp.concatenate([step, jnp.zeros(1)])
        return rotations.product(attitude, rotations.from_rotation_vector(vector)), None

    end = jax.lax.scan(add, jnp.array([1.0, 0, 0, 0]), steps.reshape(-1, 2))[0]
    return rotations.product(rotations.conjugate(wanted), end)[1:]


total_and_slope = jax.jit(jax.value_and_grad(total))
misses, slopes_of_misses = jax.jit(off), jax.jit(jax.jacobian(off))


@pytest.mark.parametrize("seed", range(2))
def test_no_shorter_way_is_found_by_search(seed):
    """Chains of 8 turns about axes of the plane, their sum minimised, are never shorter."""
    from scipy.optimize import minimize

    random = np.random.default_rng(seed)
    wanted = unit(random.normal(size=4))
    length = float(sweep_of(wanted).length)

    constraint = {"type": "eq", "fun": misses, "jac": slopes_of_misses, "args": (wanted,)}
    best = min(
        (
            minimize(
                total_and_slope,
                0.5 * random.normal(size=16),
                jac=True,
                method="SLSQP",
                constraints=constraint,
            )
            for _ in range(6)
        ),
        key=lambda found: found.fun + 1e3 * np.abs(misses(found.x, wanted)).max(),
    )
    assert np.abs(misses(best.x, wanted)).max() < 1e-5
    assert length <= best.fun * (1.0 + 1e-6)
    assert best.fun < 1.03 * length  # and the search comes close: eight chords of the same way


@given(st.floats(1e-4, 5.4), st.floats(-50.0, 50.0))
@settings(max_examples=60)
def test_a_sweep_keeps_to_its_limits(length, curvature):
    assert _peaks(length, curvature)[0] <= SPEED * (1.0 + 1e-12)
    assert _peaks(length, curvature)[1] <= ACCELERATION * 1.002


@jax.jit
def _peaks(length, curvature):
    sweep = timed(jnp.zeros(()), curvature, length, SPEED, ACCELERATION)

    def rate(time):
        return progress(sweep, time)[1]

    times = jnp.linspace(0.0, 1.0, 401) * sweep.duration
    rates, along = jax.jit(jax.vmap(rate))(times), jax.jit(jax.vmap(jax.grad(rate)))(times)
    return jnp.max(rates), jnp.max(jnp.hypot(along, curvature * rates**2))


def test_progress_ends_where_the_sweep_ends():
    sweep = Sweep(*map(jnp.array, (0.0, 0.2, 2.0, 0.1, 9.0)))
    assert sweep.duration == pytest.approx(29.0)
    for time, angle, rate in (
        (-1.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (29.0, 2.0, 0.0),
        (90.0, 2.0, 0.0),
    ):
        np.testing.assert_allclose(progress(sweep, time), (angle, rate), atol=1e-14)
    times = jnp.linspace(0.1, 28.9, 50)
    slopes = jax.jit(jax.vmap(jax.grad(lambda time: progress(sweep, time)[0])))(times)
    np.testing.assert_allclose(
        slopes, jax.jit(jax.vmap(lambda t: progress(sweep, t)[1]))(times), atol=1e-14
    )
