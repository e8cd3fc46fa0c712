"""Text representation of parts with the values of their arrays."""

from collections.abc import Iterable
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.jax64 import jax

MOST = 36
"""Largest number of elements that are shown; for larger arrays, type and shape are shown."""


def show_values(things: Iterable[object]) -> None:
    """Show values in the `repr` of parts; Equinox shows type and shape, such as f64[4].

    Args:
        things: Objects that include the classes of the parts; others are ignored.
    """
    for thing in things:
        if isinstance(thing, type) and issubclass(thing, eqx.Module):
            thing.__repr__ = _values


def _values(self: eqx.Module) -> str:
    return eqx.tree_pformat(jax.tree.map(_plain, self))


def _plain(leaf: Any) -> Any:
    """Elements of a small array; other leaves and traced arrays are returned unchanged."""
    traced = isinstance(leaf, jax.core.Tracer)  # pyright: ignore[reportAttributeAccessIssue]
    if traced or not isinstance(leaf, jax.Array | np.ndarray | np.generic) or leaf.size > MOST:
        return leaf
    return np.asarray(leaf).tolist()
