"""Primitives of JAX as functions of NumPy arrays, for `evaluation`.

A rule takes an equation and returns a function of its operands, or None if it does not hold for the
types or parameters of the equation. Operands without axes are NumPy scalars.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.random_keys import words_of
from gyrostat.core.threefry import threefry

Rule = Callable[[Any], Callable[..., Any] | None]

_SMALL = 10_000
"""Largest number of products that a matrix product adds up without BLAS."""
_EXACT = 2.0**62


def _always(function: Callable[..., Any]) -> Rule:
    return lambda equation: function


def _of_reals(function: Callable[..., Any]) -> Rule:
    """Rule for real operands: integers overflow or are divided in another way."""
    return lambda equation: function if _is_real(equation.invars[0]) else None


def _is_real(atom: Any) -> bool:
    return atom.aval.dtype in (np.float64, np.float32)


def same(array: Any) -> Any:
    """Array as it is."""
    return array


def _select(equation: Any) -> Callable[..., Any] | None:
    which = equation.invars[0].aval
    if which.dtype != np.bool_:
        return None
    if which.shape == ():
        return lambda which, no, yes: yes if which else no
    return lambda which, no, yes: np.where(which, yes, no)


def _convert(equation: Any) -> Callable[..., Any] | None:
    before, after = equation.invars[0].aval.dtype, equation.outvars[0].aval.dtype
    if before == after:
        return same
    if after == np.bool_:
        return lambda array: array != 0
    if not _is_real(equation.invars[0]) or _is_real(equation.outvars[0]):
        return lambda array: array.astype(after)
    return _truncated if after == np.int64 else None


def _truncated(array: Any) -> Any:
    """Real numbers as integers of 64 bits: NaN becomes 0, and large numbers the largest one."""
    if np.all(np.abs(array) < _EXACT):
        return array.astype(np.int64)
    whole = np.nan_to_num(array, nan=0.0, posinf=2.0**63, neginf=-(2.0**63))
    inside = np.where(np.abs(whole) < 2.0**63, whole, 0.0).astype(np.int64)
    limits = np.iinfo(np.int64)
    return np.where(whole >= 2.0**63, limits.max, np.where(whole <= -(2.0**63), limits.min, inside))


def _shaped(equation: Any) -> Callable[..., Any] | None:
    """Rule for an operation that gives the same elements, in their order, another shape."""
    shape = equation.outvars[0].aval.shape
    if equation.primitive.name == "reshape" and equation.params["dimensions"] is not None:
        return None
    if shape:
        return lambda array: array.reshape(shape)
    first = (0,) * equation.invars[0].aval.ndim
    return lambda array: array[first]


def _broadcast(equation: Any) -> Callable[..., Any] | None:
    if len(equation.invars) != 1:
        return None
    shape, axes = equation.params["shape"], equation.params["broadcast_dimensions"]
    thin = [1] * len(shape)
    for axis, size in zip(axes, equation.invars[0].aval.shape, strict=True):
        thin[axis] = size
    dtype = equation.outvars[0].aval.dtype

    def repeat(array: Any) -> Any:
        repeated = np.empty(shape, dtype)
        repeated[...] = array.reshape(thin)
        return repeated

    return repeat


def _slice(equation: Any) -> Callable[..., Any]:
    params = equation.params
    strides = params["strides"] or (1,) * len(params["start_indices"])
    bounds = zip(params["start_indices"], params["limit_indices"], strides, strict=True)
    index = tuple(slice(*each) for each in bounds)
    return lambda array: array[index]


def _inside(starts: Sequence[Any], shape: Sequence[int], sizes: Sequence[int]) -> tuple[slice, ...]:
    """Slice of some sizes, moved inside the array."""
    index = []
    for start, length, size in zip(starts, shape, sizes, strict=True):
        first = min(max(int(start), 0), length - size)
        index.append(slice(first, first + size))
    return tuple(index)


def _dynamic_slice(equation: Any) -> Callable[..., Any]:
    sizes = equation.params["slice_sizes"]
    return lambda array, *starts: array[_inside(starts, array.shape, sizes)]


def _dynamic_update_slice(equation: Any) -> Callable[..., Any]:
    def update(array: Any, part: Any, *starts: Any) -> Any:
        array = np.array(array)
        array[_inside(starts, array.shape, part.shape)] = part
        return array

    return update


def _product(equation: Any) -> Callable[..., Any] | None:
    (left_axes, right_axes), batch = equation.params["dimension_numbers"]
    left, right = (atom.aval for atom in equation.invars)
    types = {each.dtype for each in (left, right, equation.outvars[0].aval)}
    if any(batch) or types != {np.dtype(np.float64)} or not left.size * right.size:
        return None
    depth = math.prod(left.shape[axis] for axis in left_axes)
    if left.size * right.size > _SMALL * max(depth, 1):
        return lambda a, b: np.tensordot(a, b, (left_axes, right_axes))
    if right.ndim == 1 and tuple(left_axes) == (left.ndim - 1,):
        return lambda a, b: np.add.reduce(a * b, axis=-1)
    rows, columns = _last(left.ndim, left_axes), _last(right.ndim, right_axes)
    shape = equation.outvars[0].aval.shape

    # not by BLAS, whose sums depend on the processor
    def multiply(a: Any, b: Any) -> Any:
        a = np.transpose(a, rows).reshape(-1, 1, depth)
        b = np.transpose(b, columns).reshape(1, -1, depth)
        return np.add.reduce(a * b, axis=2).reshape(shape)[()]

    return multiply


def _last(count: int, axes: Sequence[int]) -> list[int]:
    """Order of axes with some at the end."""
    return [axis for axis in range(count) if axis not in axes] + list(axes)


def _reduction(function: Any) -> Rule:
    def rule(equation: Any) -> Callable[..., Any] | None:
        axes, dtype = tuple(equation.params["axes"]), equation.outvars[0].aval.dtype
        has_identity = function in (np.add, np.multiply)
        # bits of integers are another operation
        is_other = function in (np.logical_and, np.logical_or) and dtype != np.bool_
        if is_other or not (has_identity or equation.invars[0].aval.size):
            return None
        options = {"dtype": dtype} if has_identity else {}
        return lambda array: function.reduce(array, axis=axes, **options)

    return rule


def _place(function: Any) -> Rule:
    def rule(equation: Any) -> Callable[..., Any]:
        (axis,), dtype = equation.params["axes"], equation.params["index_dtype"]
        return lambda array: function(array, axis=axis).astype(dtype)

    return rule


def _iota(equation: Any) -> Callable[..., Any]:
    axis, shape = equation.params["dimension"], equation.outvars[0].aval.shape
    thin = [-1 if k == axis else 1 for k in range(len(shape))]
    row = np.arange(shape[axis], dtype=equation.params["dtype"]).reshape(thin)
    array = np.broadcast_to(row, shape)
    return lambda: array


def _power(equation: Any) -> Callable[..., Any] | None:
    exponent = equation.params["y"]
    if not _is_real(equation.invars[0]):
        return None
    return np.square if exponent == 2 else lambda base: base**exponent


def _bitcast(equation: Any) -> Callable[..., Any] | None:
    before, after = equation.invars[0].aval.dtype, equation.outvars[0].aval.dtype
    if np.bool_ in (before, after) or before.itemsize != after.itemsize:
        return None
    return lambda array: array.view(after)


def _random_words(equation: Any) -> Callable[..., Any] | None:
    """Rule for words of 64 bits of one key."""
    key, shape = equation.invars[0].aval, equation.params["shape"]
    is_known = str(key.dtype) == "key<fry>" and jax.config.values["jax_threefry_partitionable"]
    if not is_known or key.shape != () or equation.params["bit_width"] != 64:
        return None
    counters = np.arange(math.prod(shape)).reshape(shape)

    def draw(key: Any) -> Any:
        return threefry(words_of(key), counters)[()]

    return draw


def _of(function: Callable[..., Any], name: str) -> Rule:
    """Rule for a function of one array and a parameter."""

    def rule(equation: Any) -> Callable[..., Any]:
        value = equation.params[name]
        return lambda array: function(array, value)

    return rule


def _of_several(function: Callable[..., Any], name: str) -> Rule:
    """Rule for a function of several arrays and an axis."""

    def rule(equation: Any) -> Callable[..., Any]:
        axis = equation.params[name]
        return lambda *arrays: function(arrays, axis=axis)

    return rule


_OF_ALL = {
    **{"add": np.add, "add_any": np.add, "sub": np.subtract, "neg": np.negative},
    **{"mul": np.multiply, "square": np.square, "abs": np.abs},
    **{"max": np.maximum, "min": np.minimum},
    **{"lt": np.less, "le": np.less_equal, "gt": np.greater, "ge": np.greater_equal},
    **{"eq": np.equal, "ne": np.not_equal, "not": np.bitwise_not, "xor": np.bitwise_xor},
    **{"and": np.bitwise_and, "or": np.bitwise_or, "is_finite": np.isfinite},
}
_OF_REALS = {
    **{"div": np.true_divide, "rem": np.fmod, "pow": np.power, "sqrt": np.sqrt, "cbrt": np.cbrt},
    **{"floor": np.floor, "ceil": np.ceil, "exp": np.exp, "expm1": np.expm1},
    **{"log": np.log, "log1p": np.log1p, "sin": np.sin, "cos": np.cos, "tan": np.tan},
    **{"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "atan2": np.arctan2},
    **{"sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh},
    # of -0.0, NumPy's sign is 0.0
    "sign": lambda array: np.copysign(np.sign(array), array),
    "rsqrt": lambda array: 1.0 / np.sqrt(array),
    "clamp": lambda low, array, high: np.minimum(np.maximum(array, low), high),
}
RULES: dict[str, Rule] = {
    **{name: _always(function) for name, function in _OF_ALL.items()},
    **{name: _of_reals(function) for name, function in _OF_REALS.items()},
    **dict.fromkeys(("copy", "copy_p", "stop_gradient"), _always(same)),
    **dict.fromkeys(("reshape", "squeeze", "expand_dims"), _shaped),
    "argmax": _place(np.argmax),
    "argmin": _place(np.argmin),
    "bitcast_convert_type": _bitcast,
    "broadcast_in_dim": _broadcast,
    "concatenate": _of_several(np.concatenate, "dimension"),
    "convert_element_type": _convert,
    "dot_general": _product,
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update_slice,
    "integer_pow": _power,
    "iota": _iota,
    "random_bits": _random_words,
    "reduce_and": _reduction(np.logical_and),
    "reduce_max": _reduction(np.maximum),
    "reduce_min": _reduction(np.minimum),
    "reduce_or": _reduction(np.logical_or),
    "reduce_prod": _reduction(np.multiply),
    "reduce_sum": _reduction(np.add),
    "rev": _of(np.flip, "dimensions"),
    "select_n": _select,
    "slice": _slice,
    "stack": _of_several(np.stack, "axis"),
    "transpose": _of(np.transpose, "permutation"),
}
"""Primitive -> its rule."""
