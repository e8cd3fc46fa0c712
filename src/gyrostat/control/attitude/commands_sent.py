"""Delay line of past commands, for controllers that account for command delay."""

from typing import Any

from jaxtyping import Array, Float

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp

Sent = Float[Array, "samples values"]
"""(delay + 1, values) commanded, the oldest first: that one has acted since the last sample."""


def check_delay(delay: int) -> None:
    """Refuse a delay below 0 control periods, by `InputError`."""
    if delay < 0:
        raise InputError(f"command delay: found {delay}, expected 0 periods or more")


def nothing_sent(delay: int, values: int) -> Sent:
    """Before the first sample, at a delay in control periods."""
    return jnp.zeros((delay + 1, values))


def sent_too(sent: Sent, command: Any) -> Sent:
    """With what is commanded at this sample, (values,)."""
    return jnp.concatenate([sent[1:], command[None]])
