"""Delay line between a controller and the actuators."""

from typing import Any

from gyrostat.core.arrays import Scalar
from gyrostat.core.delay_line import empty_line, pushed
from gyrostat.core.jax64 import dce_jaxpr, jax, jnp

DelayLine = tuple[Any, ...]
"""Last values of each leaf of a command, (delay, ...), the oldest first; None: not delayed. Empty
if no leaf is."""


def delay_line(plant: Any, state: Any, command: Any, period: Scalar, delay: int) -> DelayLine:
    """Create the delay line before the first command.

    Until that command arrives, it gives zeros, or what the plant's method `steady_command` says: a
    wheel that is commanded by its speed would otherwise brake to zero.

    Args:
        plant: Plant, see `gyrostat.simulation.Plant`.
        state: State of the plant at the start.
        command: Command of the controller, or its shapes.
        period: Control period, s.
        delay: Control periods from a sample to the start of the command made from it, 1 or more.
    """
    line = empty_line(command, delay)
    if hasattr(plant, "steady_command"):
        zero_command = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), command)
        steady = plant.steady_command(state, zero_command)
        line = jax.tree.map(lambda zeros, value: zeros + value, line, steady)
    flags = _moves(plant, state, command, period)
    leaves = zip(jax.tree.leaves(line), flags, strict=True)
    return tuple(leaf if moves else None for leaf, moves in leaves)


def _moves(plant: Any, state: Any, command: Any, period: Scalar) -> list[bool]:
    """Whether the plant's motion depends on each leaf of a command.

    It is determined from the traced plant, so that plants and controllers need not declare it. A
    leaf that is passed unused through a `jax.lax.while_loop` counts as used.
    """
    traced = jax.make_jaxpr(lambda value: plant(state, value, jnp.zeros(()), period))(command)
    return dce_jaxpr(traced.jaxpr, [True] * len(traced.jaxpr.outvars))[1]


def delayed(line: DelayLine, command: Any) -> tuple[DelayLine, Any]:
    """Put a command into the delay line.

    Args:
        line: Delay line.
        command: Command computed at this sample.

    Returns:
        The line with the command in it; the command that acts in this period, whose delayed leaves
        were computed `delay` samples before.
    """
    if not line:
        return line, command
    leaves, tree = jax.tree.flatten(command)
    pairs = zip(line, leaves, strict=True)
    steps = ((None, leaf) if queue is None else pushed(queue, leaf) for queue, leaf in pairs)
    next_line, outputs = zip(*steps, strict=True)
    return next_line, jax.tree.unflatten(tree, outputs)
