"""Rules for element-wise and data-movement primitives of JAX, and operations on numbers."""

import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Scalars = NDArray[Any]
"""Array whose elements are operands."""


def one_by_one(shape: tuple[int, ...], make: Callable[..., Any], *arrays: Scalars) -> Scalars:
    """Array of the results of `make` for the elements of arrays of a given shape."""
    results = np.empty(shape, dtype=object)
    for index in np.ndindex(shape):
        results[index] = make(*(array[index] for array in arrays))
    return results


COMPILED = (
    "one that compiled code has: arithmetic, selects, elementary functions, moves and indices of "
    "elements, loops of a known length, jax.numpy.linalg for real matrices that are not "
    "empty (but eig; QR without pivoting), convolution along one axis"
)

ELEMENTWISE = {
    **{
        name: name
        for name in (
            *("add", "sub", "mul", "div", "neg", "max", "min", "abs", "sign", "sqrt"),
            *("lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "xor"),
            *("exp", "exp2", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan"),
            *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "erfc"),
            *("cbrt", "atan2", "pow", "floor", "ceil", "shift_left"),
        )
    },
    "add_any": "add",
    "rem": "fmod",
    "is_finite": "finite",
}
"""Primitive -> operation on each element."""

TEST = frozenset({"lt", "le", "gt", "ge", "eq", "ne"})
"""Operations whose result is logical."""
LOGICAL_ONLY = frozenset({"and", "or", "not", "xor"})

COMMUTATIVE = frozenset({"add", "mul"})
"""Operations whose operands may change places."""

FOLDED: dict[str, Callable[..., Any]] = {
    **{name: getattr(operator, name) for name in ("add", "sub", "mul", "neg", "xor", *TEST)},
    "and": operator.and_,
    "or": operator.or_,
    "not": lambda value: not value if isinstance(value, bool) else ~value,
    "to_word": lambda value: value % 2**32,
    "to_half": lambda value: (value + 2**31) % 2**32 - 2**31,
}
"""Operation -> Python function for constants; each is exact, or rounds once as in C."""

WRAPPED: dict[str, Callable[[Any], Any]] = {
    "integer": lambda value: (value + 2**63) % 2**64 - 2**63,
    "bits": lambda value: value % 2**64,
}
"""Kind -> function that wraps an integer to 64 bits."""

OVERFLOWING = frozenset(
    {
        *("add", "sub", "mul", "div", "neg", "abs", "not", "shift_left", "add_any", "square"),
        *("integer_pow", "reduce_sum", "reduce_prod", "cumsum", "cumprod"),
    }
)
"""Primitives whose result may need more bits than their operands."""

ALIKE = frozenset({"copy", "copy_p", "stop_gradient", "optimization_barrier", "name"})
"""Primitives whose results are their operands."""


def _broadcast(params: dict[str, Any], array: Scalars) -> list[Scalars]:
    shape, axes = params["shape"], params["broadcast_dimensions"]
    sizes = [1] * len(shape)
    for axis, target in enumerate(axes):
        sizes[target] = array.shape[axis]
    return [np.broadcast_to(array.reshape(sizes), shape)]


def _cut(params: dict[str, Any], array: Scalars) -> list[Scalars]:
    strides = params["strides"] or (1,) * array.ndim
    ranges = zip(params["start_indices"], params["limit_indices"], strides, strict=True)
    return [array[tuple(slice(*each) for each in ranges)]]


def _pad(params: dict[str, Any], array: Scalars, value: Scalars) -> list[Scalars]:
    for axis, (low, high, interior) in enumerate(params["padding_config"]):
        count = array.shape[axis]
        size = low + high + count + max(count - 1, 0) * interior
        padded = np.full((*array.shape[:axis], size, *array.shape[axis + 1 :]), value[()])
        positions = low + (interior + 1) * np.arange(count)
        inner = (positions >= 0) & (positions < size)
        padded[(slice(None),) * axis + (positions[inner],)] = np.compress(inner, array, axis)
        array = padded
    return [array]


def _unstack(params: dict[str, Any], array: Scalars) -> list[Scalars]:
    rows = np.moveaxis(array, params["axis"], 0)
    return [rows[k] for k in range(len(rows))]


def _reshaped(params: dict[str, Any], array: Scalars) -> list[Scalars]:
    if params["dimensions"] is not None:  # as `order="F"` has
        array = array.transpose(params["dimensions"])
    return [array.reshape(params["new_sizes"])]


def _split(params: dict[str, Any], array: Scalars) -> list[Scalars]:
    return np.split(array, np.cumsum(params["sizes"])[:-1], params["axis"])


MOVES: dict[str, Callable[..., Sequence[Scalars]]] = {
    "broadcast_in_dim": _broadcast,
    "concatenate": lambda params, *arrays: [np.concatenate(arrays, params["dimension"])],
    "expand_dims": lambda params, array: [np.expand_dims(array, params["dimensions"])],
    "pad": _pad,
    "reshape": _reshaped,
    "rev": lambda params, array: [np.flip(array, params["dimensions"])],
    "slice": _cut,
    "split": _split,
    "squeeze": lambda params, array: [array.squeeze(params["dimensions"])],
    "stack": lambda params, *arrays: [np.stack(arrays, params["axis"])],
    "tile": lambda params, array: [np.tile(array, params["reps"])],
    "transpose": lambda params, array: [array.transpose(params["permutation"])],
    "unstack": _unstack,
}
"""Primitive -> (its parameters, arrays) -> arrays with rearranged elements."""
