"""Integration over an interval in steps whose length follows from their errors.

The number of steps is bounded, and the result states whether an interval needed more.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from jaxtyping import Array, Bool, Float, Int

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp

MAX_STEPS = 2000
"""Largest number of steps in an interval."""
SHORTEST = 1e-15
"""Step, as a share of the interval, at which the integration stops without success."""
SHRINK, GROW, SAFETY = 0.1, 6.0, 0.9
"""Limits of the ratio of successive step lengths, and the safety factor."""


class Step(NamedTuple):
    """A step that has been tried.

    Attributes:
        state: State at its end.
        length: Length, s.
        last: Whether it ends with the interval.
        error: Error over the largest accepted one.
    """

    state: Any
    length: Scalar
    last: Bool[Array, ""]
    error: Scalar


class _Progress(NamedTuple):
    state: Any
    elapsed: Float[Array, ""]
    step: Float[Array, ""]
    number: Int[Array, ""]


def in_adaptive_steps(
    step: Callable[[Any, Scalar, Scalar], Step],
    state: Any,
    duration: Scalar,
    first: Scalar,
    ratio: Callable[[Scalar], Scalar],
) -> tuple[Any, Bool[Array, ""]]:
    """Integrate a state over an interval.

    Args:
        step: Function (state, time since the start in s, wanted length in s) -> step.
        state: State at the start, any tree of arrays.
        duration: Length of the interval, s.
        first: Length of the first step, s.
        ratio: Function of the error of a step -> length of a step with the error 1, over its own.

    Returns:
        State at the end, and whether it was reached within `MAX_STEPS`, which is False if the state
        is not finite. Differentiable in forward mode.
    """

    def unfinished(progress: _Progress):
        # the steps of a state that is not finite shrink without end
        shrinks = progress.step > SHORTEST * duration
        return (progress.elapsed < duration) & (progress.number < MAX_STEPS) & shrinks

    def go(progress: _Progress) -> _Progress:
        time = progress.elapsed
        attempt = step(progress.state, time, jax.lax.stop_gradient(progress.step))
        error = jax.lax.stop_gradient(attempt.error)
        fine = error <= 1.0  # False for NaN
        change = SAFETY * ratio(jnp.maximum(error, 1e-12))
        change = jnp.where(jnp.isfinite(error), jnp.clip(change, SHRINK, GROW), SHRINK)
        elapsed = jnp.where(attempt.last, duration, time + attempt.length)
        return _Progress(
            state=jax.tree.map(lambda a, b: jnp.where(fine, a, b), attempt.state, progress.state),
            elapsed=jnp.where(fine, elapsed, time),
            step=jax.lax.stop_gradient(attempt.length)
            * jnp.where(fine, change, jnp.minimum(change, 0.5)),
            number=progress.number + 1,
        )

    start = _Progress(state, jnp.zeros_like(duration), jnp.minimum(duration, first), jnp.array(0))
    end = jax.lax.while_loop(unfinished, go, start)
    return end.state, end.elapsed >= duration
