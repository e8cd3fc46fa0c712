"""Text of parts that shows the values of their arrays."""

from collections.abc import Iterable
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.jax64 import jax

MOST = 36
"""Numbers of an array that are shown; of a larger one, type and shape."""


def show_values(things: Iterable[object]) -> None:
    """Let parts show values in their `repr`; Equinox shows type and shape, as f64[4].

    Args:
        things: among them the classes of the parts.
    """
    for thing in things:
        if isinstance(thing, type) and issubclass(thing, eqx.Module):
            thing.__repr__ = _values


def _values(self: eqx.Module) -> str:
    return eqx.tree_pformat(jax.tree.map(_plain, self))


def _plain(leaf: Any) -> Any:
    """Numbers of a small array; everything else as it is, arrays under a transformation too."""
    traced = isinstance(leaf, jax.core.Tracer)  # pyright: ignore[reportAttributeAccessIssue]
    if traced or not isinstance(leaf, jax.Array | np.ndarray | np.generic) or leaf.size > MOST:
        return leaf
    return np.asarray(leaf).tolist()
