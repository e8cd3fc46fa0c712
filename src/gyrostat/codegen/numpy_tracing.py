"""Trace functions of NumPy arrays by JAX, so that they can be compiled too.

NumPy hands its functions to an argument that has `__array_ufunc__` and `__array_function__` (NEP 13
and NEP 18). `Traced` has them call the functions of JAX with the same names.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from gyrostat.core.jax64 import jax, jnp


class Traced(NDArrayOperatorsMixin):
    """Array of JAX in the place of one of NumPy.

    Args:
        array: Array, or a value of a function that is traced.
    """

    def __init__(self, array: Any):
        self.array = array

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape, as that of an array of NumPy."""
        return self.array.shape

    @property
    def dtype(self) -> Any:
        """Type of its numbers."""
        return self.array.dtype

    def astype(self, dtype: Any) -> "Traced":
        """Array of another type."""
        return Traced(self.array.astype(dtype))

    def __getitem__(self, index: Any) -> "Traced":
        """Part of the array."""
        return Traced(self.array[index])

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Call a universal function (NEP 13)."""
        if method != "__call__" or options:
            return NotImplemented
        return Traced(getattr(jnp, ufunc.__name__)(*map(_plain, inputs)))

    def __array_function__(
        self, function: Callable[..., Any], types: Any, arguments: Any, options: Any
    ) -> Any:
        """Call another function (NEP 18)."""
        room = jnp.linalg if function.__module__ == "numpy.linalg" else jnp
        return Traced(getattr(room, function.__name__)(*map(_plain, arguments), **options))


def with_jax(function: Callable[..., Any]) -> Callable[..., Any]:
    """Function of trees of NumPy arrays, as one that JAX can trace.

    Args:
        function: Function that NumPy computes, by functions that JAX has too.
    """

    def call(*trees: Any) -> Any:
        results = function(*jax.tree.map(Traced, trees))
        return jax.tree.map(lambda leaf: jnp.asarray(_plain(leaf)), results)

    return call


def _plain(value: Any) -> Any:
    if isinstance(value, list):  # of arrays, as for stack
        return [_plain(each) for each in value]
    return value.array if isinstance(value, Traced) else np.asarray(value)
