"""The Rosenbrock-W step: its order conditions, and its order with a wrong matrix."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.rosenbrock_w import (
    ARGUMENTS,
    EMBEDDED,
    GAMMA,
    MATRIX,
    WEIGHTS,
    rosenbrock_w_step,
)


def conditions(weights):
    """Residuals of the conditions of second and of third order for any matrix."""
    a, g = ARGUMENTS.sum(axis=1), MATRIX.sum(axis=1)
    second = [weights.sum() - 1.0, weights @ a - 0.5, weights @ g]
    chains = [weights @ first @ last for first in (ARGUMENTS, MATRIX) for last in (a, g)]
    wanted = np.array([1 / 6, 0.0, 0.0, 0.0])
    return second, [weights @ a**2 - 1 / 3, *(chains - wanted)]


def test_the_coefficients_meet_the_order_conditions():
    second, third = conditions(WEIGHTS)
    np.testing.assert_allclose([*second, *third], 0.0, atol=1e-15)
    second, third = conditions(EMBEDDED)
    np.testing.assert_allclose(second, 0.0, atol=1e-15)
    assert np.max(np.abs(third)) > 0.01
    # no remainder of an infinitely stiff part, and third order of an algebraic one
    inverse = np.linalg.inv(ARGUMENTS + MATRIX)
    assert abs(1.0 - WEIGHTS @ inverse @ np.ones(4)) < 1e-14
    assert abs(WEIGHTS @ inverse @ ARGUMENTS.sum(axis=1) ** 2 - 1.0) < 1e-14


@pytest.mark.parametrize("share", [1.0, 0.6, 0.0])
def test_the_order_is_three_with_any_matrix(share):
    """A rotation coupled to a driven decay; the matrix is a share of that of the decay alone."""

    def field(y, t):
        turn, fade = y
        return jnp.array([-turn[1] * fade, turn[0]]), -5.0 * (fade - jnp.cos(t)) + turn[0] ** 2

    @jax.jit
    def flown(y, steps):
        step = 2.0 / steps

        def solve(right):
            turn, fade = right
            often = 1.0 / (GAMMA * step)
            return turn / often, fade / (often + 5.0 * share)

        def go(k, carry):
            y, most = carry
            time = k * step
            y, error = rosenbrock_w_step(field, solve, y, field(y, time), time, step)
            return y, jnp.maximum(most, jnp.abs(error[1]))

        return jax.lax.fori_loop(0, steps, go, (y, 0.0))

    def plain(t, y):
        turn, fade = field((y[:2], y[2]), t)
        return [*turn, fade]

    exact = solve_ivp(plain, (0.0, 2.0), [1.0, 0.0, 0.5], "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    found = [flown((jnp.array([1.0, 0.0]), jnp.array(0.5)), n) for n in (80, 160, 320)]
    off = [np.linalg.norm(np.array([*turn, fade]) - exact) for (turn, fade), _ in found]
    assert np.all(np.diff(-np.log2(off)) > 2.8)
    estimates = np.array([float(estimate) for _, estimate in found])
    assert np.all(np.diff(-np.log2(estimates)) > 2.7)
