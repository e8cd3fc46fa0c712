"""The continuous algebraic Riccati equation, by structure-preserving doubling.

A'P + PA + Q - P B R^-1 B' P = 0, stabilising solution. A Cayley transform turns the Hamiltonian
matrix into a discrete symplectic pair, and every doubling squares it: E. K.-W. Chu, H.-Y. Fan,
W.-W. Lin, "A structure-preserving doubling algorithm for continuous-time algebraic Riccati
equations", Linear Algebra and its Applications 396 (2005) 55-80. The count of doublings is fixed;
whether it was enough is data in the result.
"""

from functools import partial
from typing import NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import Square, factor, product, solve, symmetric, whiten

BALANCINGS = 4
"""Sweeps that bring the rows and columns of the Hamiltonian matrix to one size."""
DOUBLINGS = 14
"""Enough where the closed loop's |eigenvalues| differ 1e4-fold, or a mode is damped to a share of
1e-3; each more doubles the share, and makes four times of the ratio."""
LARGEST_RESIDUAL = 1e-9
"""Of a valid solution."""
LARGEST_REMAINDER = 1e-4
"""Of a valid solution: what doubling has left of the closed loop's free motion."""


class RiccatiSolution(NamedTuple):
    """A solution and how good it is.

    Attributes:
        cost: P, (n, n): x' P x is the cost from x on.
        gain: K = R^-1 B' P, (m, n), for u = -K x.
        residual: Frobenius norm of the equation's left side over 2|A||P| + |Q| + |B R^-1 B'||P|²,
            in balanced coordinates: the relative change of A, B, Q and R that would explain it.
        valid: whether P solves the equation and A - B K is stable. False where the pair (A, B)
            cannot be stabilised, where Q does not see an undamped mode, where R is not positive
            definite, or where the doublings were too few. The rest may be NaN then.
    """

    cost: Float[Array, "n n"]
    gain: Float[Array, "m n"]
    residual: Float[Array, ""]
    valid: Bool[Array, ""]


class _Balanced(NamedTuple):
    dynamics: Square
    input: Square
    weight: Square
    scale: Float[Array, " n"]
    size: Float[Array, ""]


def _norm(matrix: Square) -> Float[Array, ""]:
    return jnp.sqrt(jnp.sum(matrix * matrix))


def _balance(dynamics: Square, input: Square, weight: Square) -> _Balanced:
    """States and cost in units in which the Hamiltonian matrix is balanced.

    A state is `scale` times its balanced one; P is divided by `size` and by both scales.
    """
    outside = 1.0 - jnp.eye(len(dynamics))

    def usable(ratio):
        return jnp.where((ratio > 0.0) & jnp.isfinite(ratio), ratio, 1.0)

    def sweep(_, now: _Balanced) -> _Balanced:
        coupling = outside * now.dynamics**2
        size = usable(jnp.sum(now.input**2) / jnp.sum(now.weight**2)) ** 0.25
        rows = jnp.sum(coupling + now.input**2 / size**2, axis=1)
        columns = jnp.sum(coupling + now.weight**2 * size**2, axis=0)
        # half a step of each, since all are changed at once
        scale = usable(rows / columns) ** 0.125
        both = scale[:, None] * scale
        return _Balanced(
            now.dynamics * scale / scale[:, None],
            now.input / (size * both),
            now.weight * (size * both),
            now.scale * scale,
            now.size * size,
        )

    start = _Balanced(dynamics, input, weight, jnp.ones(len(dynamics)), jnp.ones(()))
    last = jax.lax.stop_gradient(jax.lax.fori_loop(0, BALANCINGS, sweep, start))
    both = last.size * last.scale[:, None] * last.scale
    return last._replace(
        dynamics=dynamics * last.scale / last.scale[:, None],
        input=input / both,
        weight=weight * both,
    )


def _left_side(dynamics: Square, input: Square, weight: Square, cost: Square) -> Square:
    """Of the equation."""
    half = product(cost, dynamics - 0.5 * product(input, cost))
    return half + half.T + weight


def _doubled(dynamics: Square, input: Square, weight: Square, doublings: int) -> Square:
    """Stabilising solution, not yet refined."""
    size = len(dynamics)
    unit = jnp.eye(size)
    # The geometric mean of the closed loop's |eigenvalues| is a shift near the best one.
    top, bottom = jnp.concatenate([dynamics, -input], 1), jnp.concatenate([weight, dynamics.T], 1)
    hamiltonian = jnp.concatenate([top, bottom])
    shift = jnp.exp(solve(hamiltonian, jnp.zeros((2 * size, 0)))[1] / (2 * size))
    inverse, _ = solve(hamiltonian - shift * jnp.eye(2 * size), 2.0 * shift * jnp.eye(2 * size))

    def double(_, now):
        power, dual, cost = now
        root = factor(cost)
        # `@` where a product goes into another: fused, it would be done again for every element
        spread = dual @ root
        white = whiten(unit + product(root.T, spread), jnp.concatenate([root.T, spread.T], axis=1))
        costs = white[:, :size] @ power
        duals = white[:, size:] @ power.T
        return (
            product(power, power) - product(duals.T, costs),
            dual + product(power @ dual, power.T) - product(duals.T, duals),
            cost + product(costs.T, costs),
        )

    start = (
        unit + inverse[:size, :size],
        symmetric(inverse[:size, size:]),
        -symmetric(inverse[size:, :size]),
    )
    return jax.lax.fori_loop(0, doublings, double, start)[2]


def lyapunov(
    dynamics: Square, constant: Square, doublings: int = DOUBLINGS
) -> tuple[Square, Float[Array, ""]]:
    """Solution X of A'X + XA + C = 0 for a stable A, by Smith's doubling.

    R. A. Smith, "Matrix equation XA + BX = C", SIAM Journal on Applied Mathematics 16 (1968).

    Args:
        dynamics: A, (n, n).
        constant: C, (n, n), symmetric.
        doublings: fixed count.

    Returns:
        X, (n, n); and what is left of the free motion, far below 1 if and only if A is stable and
        the doublings suffice.
    """
    size = len(dynamics)
    unit = jnp.eye(size)
    logarithm = jax.lax.stop_gradient(solve(dynamics, jnp.zeros((size, 0)))[1])
    shift = jnp.exp(logarithm / size)
    inverse, _ = solve(dynamics - shift * unit, unit)
    start = 2.0 * shift * product(inverse.T, constant @ inverse)

    def double(_, now):
        total, power = now
        return total + product(power.T, total @ power), product(power, power)

    first = (start, unit + 2.0 * shift * inverse)
    total, power = jax.lax.fori_loop(0, doublings, double, first)
    return symmetric(total), _norm(power)


@partial(jax.custom_jvp, nondiff_argnums=(3,))
def _stabilising(dynamics: Square, input: Square, weight: Square, doublings: int):
    """Solution, refined by one step of Newton and Kleinman, and what is left of the free motion."""
    cost = _doubled(dynamics, input, weight, doublings)
    left = _left_side(dynamics, input, weight, cost)
    change, remainder = lyapunov(dynamics - product(input, cost), left, doublings)
    return cost + change, remainder


@_stabilising.defjvp
def _stabilising_jvp(doublings, primals, tangents):
    """The equation differentiated is a Lyapunov equation of the closed loop."""
    dynamics, input, _ = primals
    d_dynamics, d_input, d_weight = tangents
    cost, remainder = _stabilising(*primals, doublings)
    half = product(cost, d_dynamics - 0.5 * product(d_input, cost))
    change, _ = lyapunov(
        dynamics - product(input, cost), half + half.T + symmetric(d_weight), doublings
    )
    return (cost, remainder), (change, jnp.zeros_like(remainder))


def riccati(
    dynamics: Float[Array, "n n"],
    input: Float[Array, "n m"],
    state_weight: Float[Array, "n n"],
    input_weight: Float[Array, "m m"],
    *,
    doublings: int = DOUBLINGS,
) -> RiccatiSolution:
    """Stabilising solution of A'P + PA + Q - P B R^-1 B' P = 0.

    Pure; for `jit`, `vmap`, `jvp` and `grad`. The derivative is that of the solution, not of the
    doublings. Nothing is refused here: see `valid`, and `lqr` for what asks a user.

    Args:
        dynamics: A, (n, n).
        input: B, (n, m).
        state_weight: Q, (n, n), symmetric, positive semidefinite.
        input_weight: R, (m, m), symmetric, positive definite.
        doublings: fixed count; each costs the same time.
    """
    white = whiten(input_weight, input.T)
    reach = product(white.T, white)
    balanced = _balance(dynamics, reach, symmetric(state_weight))
    equation = balanced[:3]
    cost, remainder = _stabilising(*equation, doublings)
    inside = jax.lax.stop_gradient(cost)
    a, g, q = (_norm(matrix) for matrix in jax.lax.stop_gradient(equation))
    p = _norm(inside)
    left = jax.lax.stop_gradient(_left_side(*equation, inside))
    residual = _norm(left) / (2.0 * a * p + q + g * p**2)
    cost = cost / (balanced.size * balanced.scale[:, None] * balanced.scale)
    gain = product(whiten(input_weight, jnp.eye(len(input_weight))).T, product(white, cost))
    # comparisons with NaN are false
    valid = (residual <= LARGEST_RESIDUAL) & (remainder <= LARGEST_REMAINDER)
    return RiccatiSolution(cost, gain, residual, valid & jnp.all(jnp.isfinite(gain)))
