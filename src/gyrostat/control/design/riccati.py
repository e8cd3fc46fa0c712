"""Continuous-time algebraic Riccati equation, solved by structure-preserving doubling.

The stabilising solution of A'P + PA + Q - P B R^-1 B' P = 0. A Cayley transform maps the
Hamiltonian matrix to a discrete symplectic pair, and every doubling squares it: E. K.-W. Chu, H.-Y.
Fan, W.-W. Lin, "A structure-preserving doubling algorithm for continuous-time algebraic Riccati
equations", Linear Algebra and its Applications 396 (2005) 55-80. The number of doublings is fixed;
the result states whether it was sufficient.
"""

from functools import partial
from typing import NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import Square, factor, product, solve, symmetric, whiten

BALANCINGS = 4
"""Number of sweeps that balance the rows and columns of the Hamiltonian matrix."""
DOUBLINGS = 14
"""Default number of doublings. It is sufficient if the |eigenvalues| of the closed loop differ by a
factor of up to 1e4, or if damping ratios are 1e-3 or more. Each further doubling halves that
damping ratio and raises that factor fourfold."""
LARGEST_RESIDUAL = 1e-9
"""Largest residual of a valid solution."""
LARGEST_REMAINDER = 1e-4
"""Largest remainder of a valid solution: norm of the closed loop's free motion after the
doublings."""


class RiccatiSolution(NamedTuple):
    """Solution of a Riccati equation and its accuracy.

    Attributes:
        cost: Cost matrix P, (n, n): x' P x is the cost from the state x on.
        gain: Gain K = R^-1 B' P, (m, n), for u = -K x.
        residual: Frobenius norm of the left side of the equation over 2|A||P| + |Q| + |B R^-1
            B'||P|², in balanced coordinates: the relative change of A, B, Q and R that would
            explain it.
        valid: Whether P solves the equation and A - B K is stable. False if the pair (A, B) cannot
            be stabilised, if Q does not weight an undamped mode, if R is not positive definite, or
            if there were too few doublings. The other fields may then be NaN.
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
    """Scale states and cost so that the Hamiltonian matrix is balanced.

    A state is `scale` times its balanced one; P is divided by `size` and by both scales.
    """
    off_diagonal = 1.0 - jnp.eye(len(dynamics))

    def usable(ratio):
        return jnp.where((ratio > 0.0) & jnp.isfinite(ratio), ratio, 1.0)

    def sweep(_, state: _Balanced) -> _Balanced:
        coupling = off_diagonal * state.dynamics**2
        size = usable(jnp.sum(state.input**2) / jnp.sum(state.weight**2)) ** 0.25
        rows = jnp.sum(coupling + state.input**2 / size**2, axis=1)
        columns = jnp.sum(coupling + state.weight**2 * size**2, axis=0)
        # half a step for each state, since all are changed at once
        scale = usable(rows / columns) ** 0.125
        scales = scale[:, None] * scale
        return _Balanced(
            state.dynamics * scale / scale[:, None],
            state.input / (size * scales),
            state.weight * (size * scales),
            state.scale * scale,
            state.size * size,
        )

    start = _Balanced(dynamics, input, weight, jnp.ones(len(dynamics)), jnp.ones(()))
    balanced = jax.lax.stop_gradient(jax.lax.fori_loop(0, BALANCINGS, sweep, start))
    scales = balanced.size * balanced.scale[:, None] * balanced.scale
    return balanced._replace(
        dynamics=dynamics * balanced.scale / balanced.scale[:, None],
        input=input / scales,
        weight=weight * scales,
    )


def _left_side(dynamics: Square, input: Square, weight: Square, cost: Square) -> Square:
    """Left side of the Riccati equation."""
    half = product(cost, dynamics - 0.5 * product(input, cost))
    return half + half.T + weight


def _doubling_solution(dynamics: Square, input: Square, weight: Square, doublings: int) -> Square:
    """Stabilising solution, before refinement."""
    size = len(dynamics)
    unit = jnp.eye(size)
    # the geometric mean of the closed loop's |eigenvalues| is close to the best shift
    top, bottom = jnp.concatenate([dynamics, -input], 1), jnp.concatenate([weight, dynamics.T], 1)
    hamiltonian = jnp.concatenate([top, bottom])
    shift = jnp.exp(solve(hamiltonian, jnp.zeros((2 * size, 0)))[1] / (2 * size))
    inverse, _ = solve(hamiltonian - shift * jnp.eye(2 * size), 2.0 * shift * jnp.eye(2 * size))

    def double(_, state):
        power, dual, cost = state
        root = factor(cost)
        # `@` for a product inside another: if fused, it would be repeated for every element
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
    """Solution X of A'X + XA + C = 0 for a stable A, by Smith's doubling method.

    R. A. Smith, "Matrix equation XA + BX = C", SIAM Journal on Applied Mathematics 16 (1968).

    Args:
        dynamics: Matrix A, (n, n).
        constant: Matrix C, (n, n), symmetric.
        doublings: Fixed number of doublings.

    Returns:
        Solution X, (n, n), and the norm of the free motion after the doublings, which is far below
        1 if and only if A is stable and the doublings suffice.
    """
    size = len(dynamics)
    unit = jnp.eye(size)
    logarithm = jax.lax.stop_gradient(solve(dynamics, jnp.zeros((size, 0)))[1])
    shift = jnp.exp(logarithm / size)
    inverse, _ = solve(dynamics - shift * unit, unit)
    start = 2.0 * shift * product(inverse.T, constant @ inverse)

    def double(_, state):
        total, power = state
        return total + product(power.T, total @ power), product(power, power)

    initial = (start, unit + 2.0 * shift * inverse)
    total, power = jax.lax.fori_loop(0, doublings, double, initial)
    return symmetric(total), _norm(power)


@partial(jax.custom_jvp, nondiff_argnums=(3,))
def _stabilising(dynamics: Square, input: Square, weight: Square, doublings: int):
    """Solution after one Newton-Kleinman step, and the norm of the remaining free motion."""
    cost = _doubling_solution(dynamics, input, weight, doublings)
    residual = _left_side(dynamics, input, weight, cost)
    change, remainder = lyapunov(dynamics - product(input, cost), residual, doublings)
    return cost + change, remainder


@_stabilising.defjvp
def _stabilising_jvp(doublings, primals, tangents):
    """Derivative of the solution, from a Lyapunov equation of the closed loop."""
    dynamics, input, _ = primals
    d_dynamics, d_input, d_weight = tangents
    cost, remainder = _stabilising(*primals, doublings)
    half = product(cost, d_dynamics - 0.5 * product(d_input, cost))
    change, _ = lyapunov(
        dynamics - product(input, cost), half + half.T + symmetric(d_weight), doublings
    )
    return (cost, remainder), (change, jnp.zeros_like(remainder))


@partial(jax.jit, static_argnames="doublings")
def riccati(
    dynamics: Float[Array, "n n"],
    input: Float[Array, "n m"],
    state_weight: Float[Array, "n n"],
    input_weight: Float[Array, "m m"],
    *,
    doublings: int = DOUBLINGS,
) -> RiccatiSolution:
    """Stabilising solution of A'P + PA + Q - P B R^-1 B' P = 0.

    The function is compiled once for each size, and supports `vmap`, `jvp` and `grad`. The
    derivative is that of the solution, not of the doublings. No input is rejected here: see `valid`
    in the result, or use `lqr`, which validates its inputs.

    Args:
        dynamics: Matrix A, (n, n).
        input: Matrix B, (n, m).
        state_weight: Weight Q, (n, n), symmetric, positive semidefinite.
        input_weight: Weight R, (m, m), symmetric, positive definite.
        doublings: Fixed number of doublings; the computing time is proportional to it.
    """
    white = whiten(input_weight, input.T)
    reach = product(white.T, white)
    balanced = _balance(dynamics, reach, symmetric(state_weight))
    equation = balanced[:3]
    cost, remainder = _stabilising(*equation, doublings)
    balanced_cost = jax.lax.stop_gradient(cost)
    a, g, q = (_norm(matrix) for matrix in jax.lax.stop_gradient(equation))
    p = _norm(balanced_cost)
    residual_matrix = jax.lax.stop_gradient(_left_side(*equation, balanced_cost))
    residual = _norm(residual_matrix) / (2.0 * a * p + q + g * p**2)
    cost = cost / (balanced.size * balanced.scale[:, None] * balanced.scale)
    gain = product(whiten(input_weight, jnp.eye(len(input_weight))).T, product(white, cost))
    # comparisons with NaN are false
    valid = (residual <= LARGEST_RESIDUAL) & (remainder <= LARGEST_REMAINDER)
    return RiccatiSolution(cost, gain, residual, valid & jnp.all(jnp.isfinite(gain)))
