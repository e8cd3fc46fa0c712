"""A stiff integrator for small systems: Rosenbrock steps that choose their own length.

RODAS, six stages, fourth order with an embedded third-order error estimate, stiffly accurate.
E. Hairer, G. Wanner, "Solving Ordinary Differential Equations II", section IV.7 and table of the
code of that name. No iteration inside a step; the number of steps is bounded, and an interval that
needs more says so.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat._jax import jax, jnp
from gyrostat.friction import Scalar

Field = Callable[[Float[Array, " n"], Scalar], Float[Array, " n"]]

MAX_STEPS = 2000
SHRINK, GROW, SAFETY = 0.2, 6.0, 0.9
"""Bounds on the change of the step length from one step to the next, and what is kept back."""
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
"""Share of the earlier stages in the argument of each stage."""
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
"""Share of the earlier stages, over the step length, in the right-hand side of each stage."""
TIMES = (0.0, 0.386, 0.21, 0.63, 1.0, 1.0)
"""Time of each stage, in steps."""
TIME_SLOPES = (0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0)
"""Share of the field's derivative in time in each stage, in steps."""


class _Progress(NamedTuple):
    state: Float[Array, " n"]
    elapsed: Float[Array, ""]
    step: Float[Array, ""]
    number: Int[Array, ""]


def _inverse(matrix):
    """Inverse of a small matrix by elimination, which a batch runs as one: no call for each lane.

    No pivots are sought: I/(gamma h) - J of a stable system is far from singular.
    """
    size = len(matrix)
    rows = jnp.concatenate([matrix, jnp.eye(size)], axis=1)
    for k in range(size):
        pivot = rows[k] / rows[k, k]
        rows = (rows - jnp.outer(rows[:, k], pivot)).at[k].set(pivot)
    return rows[:, size:]


def _step(field: Field, state, time, step):
    """One step: the new state and its estimated error."""
    jacobian = jax.jacfwd(field)(state, time)
    slope = jax.jvp(lambda t: field(state, t), (time,), (jnp.ones_like(time),))[1]
    inverse = _inverse(jnp.eye(len(state)) / (GAMMA * step) - jacobian)
    stages: list[Float[Array, " n"]] = []
    for a, c, when, share in zip(STAGES, COUPLING, TIMES, TIME_SLOPES, strict=True):
        argument, right = state, share * step * slope
        for k, stage in enumerate(stages):
            argument = argument + a[k] * stage
            right = right + c[k] / step * stage
        stages.append(inverse @ (field(argument, time + when * step) + right))
    # the last argument is the embedded solution, and the last stage its error
    embedded = state
    for k in range(5):
        embedded = embedded + STAGES[5, k] * stages[k]
    return embedded + stages[5], stages[5]


def integrate(
    field: Field,
    state: Float[Array, " n"],
    duration: Scalar,
    *,
    scale: Float[Array, " n"],
    tolerance: float,
) -> tuple[Float[Array, " n"], Bool[Array, ""]]:
    """Carry a state over an interval.

    Args:
        field: (state, time from the start in s) -> derivative of the state.
        state: (n,) at the start.
        duration: s.
        scale: (n,) size of each component that counts: errors are relative to this or to the
            component, whichever is larger.
        tolerance: largest error of one step.

    Returns:
        The state at the end, and whether it was reached within `MAX_STEPS`. Differentiable in
        forward mode.
    """
    duration = jnp.asarray(duration, dtype=float)

    def unfinished(progress: _Progress):
        return (progress.elapsed < duration) & (progress.number < MAX_STEPS)

    def go(progress: _Progress) -> _Progress:
        remaining = duration - progress.elapsed
        last = progress.step >= remaining
        step = jax.lax.stop_gradient(jnp.where(last, remaining, progress.step))
        reached, error = _step(field, progress.state, progress.elapsed, step)
        size = jnp.maximum(jnp.maximum(jnp.abs(progress.state), jnp.abs(reached)), scale)
        worst = jax.lax.stop_gradient(jnp.max(jnp.abs(error) / size)) / tolerance
        fine = worst <= 1.0  # NaN is not
        change = SAFETY * jnp.maximum(worst, 1e-12) ** -0.25
        change = jnp.where(jnp.isfinite(worst), jnp.clip(change, SHRINK, GROW), SHRINK)
        elapsed = jnp.where(last, duration, progress.elapsed + step)
        return _Progress(
            state=jnp.where(fine, reached, progress.state),
            elapsed=jnp.where(fine, elapsed, progress.elapsed),
            step=step * jnp.where(fine, change, jnp.minimum(change, 0.5)),
            number=progress.number + 1,
        )

    start = _Progress(state, jnp.zeros_like(duration), duration, jnp.array(0))
    last = jax.lax.while_loop(unfinished, go, start)
    return last.state, last.elapsed >= duration
