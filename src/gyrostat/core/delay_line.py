"""Delay line: each value arrives a fixed number of samples after it was put in.

A line is an array with a first axis of samples, the oldest first, or a tree of such arrays. In a
line of `delay` + 1 samples, the first element is the value that has acted since the last sample;
estimators use it to account for a command delay.
"""

from typing import Any

from jaxtyping import Array, Float

from gyrostat.core.checked import within
from gyrostat.core.jax64 import jax, jnp

Sent = Float[Array, "samples values"]
"""Values commanded at the last samples, (delay + 1, values), the oldest first."""

is_delay = within("command delay", "0 periods or more", lambda value: value >= 0.0)
"""Rule for a delay in control periods."""


def empty_line(value: Any, samples: int) -> Any:
    """Create a line of zeros.

    Args:
        value: Array, or its shape, or a tree of these.
        samples: Length of the line.
    """
    return jax.tree.map(lambda x: jnp.zeros((samples, *x.shape), x.dtype), value)


def pushed(line: Any, value: Any) -> tuple[Any, Any]:
    """Put a value into a line.

    Args:
        line: Delay line.
        value: Value of this sample.

    Returns:
        The line with the value in it, and the value that arrives.
    """
    queue = jax.tree.map(lambda x, new: jnp.concatenate([x, jnp.asarray(new)[None]]), line, value)
    return jax.tree.map(lambda x: x[1:], queue), jax.tree.map(lambda x: x[0], queue)
