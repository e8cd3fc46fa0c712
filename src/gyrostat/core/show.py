"""Text of a part with the values of its arrays."""

from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.jax64 import Tracer, jax

LARGEST_SHOWN = 36
"""Largest number of elements of an array whose values are shown."""


def with_values(part: Any) -> str:
    """Format a part with the values of small arrays; Equinox shows type and shape, as f64[4].

    Args:
        part: Tree of arrays and other values.
    """
    return eqx.tree_pformat(jax.tree.map(_plain, part))


def _plain(leaf: Any) -> Any:
    if isinstance(leaf, Tracer) or not isinstance(leaf, jax.Array | np.ndarray | np.generic):
        return leaf
    return np.asarray(leaf).tolist() if leaf.size <= LARGEST_SHOWN else leaf
