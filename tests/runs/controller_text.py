"""Text of a controller of a user, for tests."""

HEAD = """
import functools, itertools
from typing import NamedTuple
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

LOG, MEMO, LAST, COUNT = [], {}, None, 0

class Command(NamedTuple):
    torque: jnp.ndarray

class P(eqx.Module):
    kp: float = 1.0

    def start(self, period):
        return 0.0

    def __call__(self, memory, y):
"""
RETURN = "return memory, Command(1e-6 * w * jnp.ones(4))"


def source(*lines, below=""):
    """Text of a part whose method has these lines, and of functions below the class."""
    return HEAD + "".join(f"        {line}\n" for line in (*lines, RETURN)) + below
