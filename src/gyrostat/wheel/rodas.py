"""Rosenbrock integrator for small stiff systems.

RODAS: six stages, fourth order with an embedded third-order error estimate, stiffly accurate. E.
Hairer, G. Wanner, "Solving Ordinary Differential Equations II", section IV.7 and table of the code
of that name. A step has no iteration.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.adaptive_steps import Step, in_adaptive_steps

Field = Callable[[Any, Scalar], Any]

GAMMA = 0.25
STAGES = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [1.544, 0.0, 0.0, 0.0, 0.0],
        [0.9466785280815826, 0.2557011698983284, 0.0, 0.0, 0.0],
        [3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 0.0],
        [1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0],
    ]
)
"""Coefficients of the earlier stages in the argument of each stage."""
COUPLING = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0],
        [-5.6688, 0.0, 0.0, 0.0, 0.0],
        [-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0],
        [-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0],
        [7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0],
        [
            8.083246795921522,
            -7.981132988064893,
            -31.52159432874371,
            16.31930543123136,
            -6.058818238834054,
        ],
    ]
)
"""Coefficients of the earlier stages, over the step length, in the right-hand side of each
stage."""
TIMES = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
"""Time of each stage, in steps."""
TIME_SLOPES = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
"""Coefficient of the time derivative of the field in each stage, in steps."""


def _split(state: Any) -> tuple[list[Scalar], Callable[[list[Scalar]], Any]]:
    """Numbers of a state as a list, and the function that puts them together again.

    In a batch, each number is then an array over the batch, which is accessed without a stride.
    """
    leaves, structure = jax.tree.flatten(state)
    leaves = [jnp.asarray(leaf, dtype=float) for leaf in leaves]
    numbers: list[Scalar] = [leaf[k] for leaf in leaves for k in np.ndindex(leaf.shape)]

    def join(numbers):
        values = iter(numbers)
        parts = [[next(values) for _ in range(leaf.size)] for leaf in leaves]
        arrays = [
            jnp.stack(part).reshape(leaf.shape) if leaf.ndim else part[0]
            for part, leaf in zip(parts, leaves, strict=True)
        ]
        return jax.tree.unflatten(structure, arrays)

    return numbers, join


def _eliminator(rows: list[list[Scalar]]):
    """Solver for a small matrix that is factored once.

    It uses division instead of multiplication by a reciprocal. XLA keeps a quotient, but would
    compute products and sums again in every later stage that uses them, at three times the cost.
    There is no pivoting, since I/(gamma h) - J of a stable system is far from singular.
    """
    size = len(rows)
    rows = [list(row) for row in rows]
    for k in range(size):
        for i in range(k + 1, size):
            rows[i][k] = rows[i][k] / rows[k][k]
            for j in range(k + 1, size):
                rows[i][j] = rows[i][j] - rows[i][k] * rows[k][j]

    def solve(right: list[Scalar]) -> list[Scalar]:
        solution = list(right)
        for i in range(size):
            for j in range(i):
                solution[i] = solution[i] - rows[i][j] * solution[j]
        for i in reversed(range(size)):
            for j in range(i + 1, size):
                solution[i] = solution[i] - rows[i][j] * solution[j]
            solution[i] = solution[i] / rows[i][i]
        return solution

    return solve


def _slopes(field: Field, state: list[Scalar], time: Scalar):
    """Columns of the Jacobian, and the derivative with respect to time."""

    def along(k):
        def varied(number):
            return field([*state[:k], number, *state[k + 1 :]], time)

        return jax.jvp(varied, (state[k],), (jnp.ones_like(state[k]),))[1]

    in_time = jax.jvp(lambda t: field(state, t), (time,), (jnp.ones_like(time),))[1]
    return [along(k) for k in range(len(state))], in_time


def _plus(numbers: list[Scalar], shares, stages: list[list[Scalar]]) -> list[Scalar]:
    """Add multiples of some stages."""
    for share, stage in zip(shares, stages, strict=False):
        numbers = [number + share * k for number, k in zip(numbers, stage, strict=True)]
    return numbers


def _step(field: Field, state: list[Scalar], time: Scalar, step: Scalar):
    """New state after one step, and its estimated error."""
    columns, in_time = _slopes(field, state, time)
    size, inverse_step = range(len(state)), 1.0 / step
    diagonal = inverse_step / GAMMA
    solve = _eliminator(
        [[(diagonal if i == j else 0.0) - columns[j][i] for j in size] for i in size]
    )
    stages: list[list[Scalar]] = []
    for a, c, when, share in zip(STAGES, COUPLING, TIMES, TIME_SLOPES, strict=True):
        right = field(_plus(state, a, stages), time + when * step)
        right = _plus(right, [share * step], [in_time])
        right = _plus(right, [inverse_step * x for x in c], stages)
        stages.append(solve(right))
    # the last argument is the embedded solution, and the last stage is its error
    return _plus(state, [*STAGES[5], 1.0], stages), stages[5]


def integrate(
    field: Field,
    state: Any,
    duration: Scalar,
    *,
    scale: Any,
    tolerance: float,
    first: Scalar = math.inf,
) -> tuple[Any, Bool[Array, ""]]:
    """Integrate a state over an interval.

    Args:
        field: Function (state, time since the start in s) -> time derivative of the state.
        state: State at the start, any tree of a few numbers.
        duration: Length of the interval, s.
        scale: Scale of each component, a tree like the state. Errors are relative to this or to the
            component, whichever is larger.
        tolerance: Largest relative error of one step.
        first: Length of the first step, s. The error estimate cannot detect an event that lies
            within one step, so the first step must not be longer than the shortest event to be
            resolved.

    Returns:
        State at the end, and whether it was reached; see `in_adaptive_steps`. Differentiable in
        forward mode.
    """
    duration = jnp.asarray(duration, dtype=float)
    numbers, join = _split(state)
    scales = _split(scale)[0]

    def flat_field(numbers, time):
        return _split(field(join(numbers), time))[0]

    def step(state: list[Scalar], time: Scalar, target_length: Scalar) -> Step:
        remaining = duration - time
        last = target_length >= remaining
        # the last step ends with the interval, so that it has the derivative of the duration
        length = jnp.where(last, remaining, target_length)
        reached, errors = _step(flat_field, state, time, length)
        worst = jnp.zeros_like(length)
        for old, new, error, floor in zip(state, reached, errors, scales, strict=True):
            size = jnp.maximum(jnp.maximum(jnp.abs(old), jnp.abs(new)), floor)
            worst = jnp.maximum(worst, jnp.abs(error) / (tolerance * size))
        return Step(reached, length, last, worst)

    def ratio(error: Scalar) -> Scalar:
        return jax.lax.rsqrt(jnp.sqrt(error))

    end, resolved = in_adaptive_steps(step, numbers, duration, first, ratio)
    return join(end), resolved
