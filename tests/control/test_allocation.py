"""Allocation against a linear program, numpy's pseudo-inverse and what the wheels can give."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from gyrostat.control.allocation.allocation import (
    MinimaxAllocation,
    PseudoInverse,
    largest_share,
    within_limits,
)
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import orthogonal_axes, pyramid_axes

COUNT = 6
"""Wheels in every case, some of them without work: one compilation for all."""
SQUARES = jax.jit(PseudoInverse())
LARGEST = jax.jit(MinimaxAllocation())
RANDOM = np.random.default_rng(7).normal(size=(3, COUNT))
SETS = {
    "random": RANDOM,
    "pyramid": pyramid_axes(COUNT),
    "two on each axis": np.hstack([np.eye(3), -np.eye(3)]),
    "five in one plane": np.array(
        [[1, 0, 0], [0, 1, 0], [1, 1, 0], [1, -1, 0], [2, 1, 0], [0, 0, 1]]
    ).T,
    "one plane": np.array([[1, 0, 0], [0, 1, 0], [1, 1, 0], [1, -1, 0], [2, 1, 0], [1, 3, 0]]).T,
    "one line": np.tile([[0.6], [0.0], [0.8]], COUNT) * [1, -1, 1, 1, -1, 1],
}
SETS = {name: axes / np.linalg.norm(axes, axis=0) for name, axes in SETS.items()}


def least_largest(axes, limit, torque):
    """The level of the linear program, by HiGHS; None where the axes do not span the torque."""
    count = axes.shape[1]
    cost = np.append(np.zeros(count), 1.0)
    bounds = np.vstack([np.hstack([s * np.eye(count), -limit[:, None]]) for s in (1.0, -1.0)])
    found = linprog(
        cost,
        A_ub=bounds,
        b_ub=np.zeros(2 * count),
        A_eq=np.hstack([axes, np.zeros((3, 1))]),
        b_eq=torque,
        bounds=[(None, None)] * count + [(0, None)],
    )
    return found.fun if found.success else None


@settings(max_examples=60)
@given(
    name=st.sampled_from(sorted(SETS)),
    works=st.lists(st.booleans(), min_size=COUNT, max_size=COUNT),
    seed=st.integers(0, 2**20),
    even=st.booleans(),
)
def test_the_largest_share_is_that_of_the_linear_program(name, works, seed, even):
    axes, works = SETS[name], np.array(works)
    draw = np.random.default_rng(seed)
    limit = np.ones(COUNT) if even else draw.uniform(0.05, 2.0, COUNT)
    torque = axes @ (works * draw.normal(size=COUNT))  # in reach
    found = np.asarray(LARGEST(axes, limit, works, torque))
    assert np.allclose(axes @ found, torque, atol=1e-10)
    assert np.all(found[~works] == 0.0)
    if works.any():
        level = least_largest(axes[:, works], limit[works], torque)
        assert float(largest_share(found, limit)) == pytest.approx(level, rel=1e-8, abs=1e-9)


@settings(max_examples=60)
@given(
    name=st.sampled_from(sorted(SETS)),
    works=st.lists(st.booleans(), min_size=COUNT, max_size=COUNT),
    seed=st.integers(0, 2**20),
)
def test_least_squares_is_the_pseudo_inverse_and_both_give_the_nearest_torque(name, works, seed):
    """Also where the working axes do not span the torque."""
    axes, works = SETS[name], np.array(works)
    torque = np.random.default_rng(seed).normal(size=3)
    wanted = np.linalg.pinv(axes * works, rcond=1e-9) @ torque
    found = np.asarray(SQUARES(axes, np.ones(COUNT), works, torque))
    assert np.allclose(found, wanted, atol=1e-9 * np.max(np.abs(wanted), initial=1.0))
    other = np.asarray(LARGEST(axes, np.ones(COUNT), works, torque))
    assert np.allclose(axes @ other, (axes * works) @ wanted, atol=1e-9)


def test_a_pyramid_gives_half_as_much_again_along_an_axis_of_its_wheels():
    """Along the axis of one wheel the pseudo-inverse loads that wheel most, the other all alike."""
    axes, works, limit = pyramid_axes(4), np.ones(4, bool), np.ones(4)
    torque = axes[:, 0]
    squares = jax.jit(PseudoInverse())(axes, limit, works, torque)
    largest = jax.jit(MinimaxAllocation())(axes, limit, works, torque)
    assert float(largest_share(squares, limit)) == pytest.approx(0.75, rel=1e-9)
    assert np.allclose(np.abs(largest), 0.5, atol=1e-12)


def test_the_torques_follow_the_wanted_one_without_jumps():
    """On a circle of torques, steps of 1e-3 rad move no motor torque by more than a few 1e-3."""
    axes, works, limit = pyramid_axes(COUNT), np.ones(COUNT, bool), np.ones(COUNT)
    angle = np.linspace(0.0, 2.0 * np.pi, 6284)
    torques = np.stack([np.cos(angle), np.sin(angle), 0.3 * np.sin(2.0 * angle)], axis=1)
    found = jax.jit(jax.vmap(MinimaxAllocation(), (None, None, None, 0)))(
        axes, limit, works, torques
    )
    assert np.max(np.abs(np.diff(found, axis=0))) < 5e-3


def test_no_torque_and_no_wheel_give_zero_and_one_wheel_gives_its_part():
    limit = np.ones(COUNT)
    for allocation in (SQUARES, LARGEST):
        assert np.all(allocation(RANDOM, limit, np.ones(COUNT, bool), np.zeros(3)) == 0.0)
        assert np.all(allocation(RANDOM, limit, np.zeros(COUNT, bool), np.ones(3)) == 0.0)
        single = allocation(np.eye(3)[:, :1], np.ones(1), np.ones(1, bool), np.array([2.0, 3.0, 0]))
        assert np.allclose(single, 2.0, rtol=1e-9)


def test_torques_beyond_the_limits_keep_the_direction_of_their_sum():
    limit = np.array([1.0, 2.0, 0.5])
    found = within_limits(jnp.array([2.0, 1.0, -0.25]), limit)
    assert np.allclose(found, [1.0, 0.5, -0.125])
    assert np.allclose(within_limits(jnp.array([0.5, -2.0, 0.1]), limit), [0.5, -2.0, 0.1])


@pytest.mark.parametrize("count", [3, 4, 6])
def test_a_pyramid_reaches_alike_along_every_axis(count):
    """At the default elevation A A' is n/3 times the identity."""
    axes = pyramid_axes(count)
    assert np.allclose(axes @ axes.T, count / 3.0 * np.eye(3), atol=1e-15 * count)
    assert np.array_equal(orthogonal_axes(), np.eye(3))


@pytest.mark.parametrize("change", [{"count": 2}, {"elevation": 0.0}, {"elevation": np.pi / 2}])
def test_a_pyramid_that_is_flat_or_too_small_is_refused(change):
    with pytest.raises(InputError, match="pyramid"):
        pyramid_axes(**change)
