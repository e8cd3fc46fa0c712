"""Operations of C on arrays of lanes, for translated code."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

Lanes = Any
"""Array with one value for each lane, or a number that all lanes have."""


def _of_library(function: Callable[..., float], count: int) -> Callable[..., Lanes]:
    """Elementary function of the C library, number by number, with C's results for bad ones."""

    def careful(*values: float) -> float:
        try:
            return function(*values)
        except OverflowError:
            return math.inf
        except ValueError:
            return _bad(function, *values)

    elementwise = np.frompyfunc(careful, count, 1)

    def apply(*values: Lanes) -> Lanes:
        result = np.asarray(elementwise(*values), dtype=float)
        singles = all(getattr(value, "dtype", None) == np.float32 for value in values)
        return result.astype(np.float32) if singles else result

    return apply


def _bad(function: Callable[..., float], *values: float) -> float:
    """Result of C where Python raises ValueError."""
    if function in (math.log, math.log1p):
        at_pole = values[0] == (0.0 if function is math.log else -1.0)
        return -math.inf if at_pole else math.nan
    if function is math.atanh and abs(values[0]) == 1.0:
        return math.copysign(math.inf, values[0])
    if function is math.pow and values[0] == 0.0:
        is_odd = values[1] == math.floor(values[1]) and values[1] % 2.0 == 1.0
        return math.copysign(math.inf, values[0]) if is_odd else math.inf
    return math.nan


_ONE = (
    *("exp", "exp2", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan"),
    *("sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "erf", "erfc", "cbrt"),
)
_TWO = ("atan2", "pow", "fmod")
ELEMENTARY = (*_ONE, *_TWO)
"""Functions that Python evaluates number by number."""
_BASIC: dict[str, Callable[..., Lanes]] = {
    "sqrt": np.sqrt,
    "fabs": np.abs,
    "floor": np.floor,
    "ceil": np.ceil,
    "rint": np.rint,
    "trunc": np.trunc,
    "copysign": np.copysign,
}


def _round(value: Lanes) -> Lanes:
    """Nearest integer; halves away from zero."""
    whole = np.trunc(value)
    return np.where(np.abs(value - whole) >= 0.5, whole + np.copysign(1.0, value), whole)


def quotient(a: Lanes, b: Lanes) -> Lanes:
    """Division of C: of integers, towards zero."""
    if np.asarray(a).dtype.kind != "f" and np.asarray(b).dtype.kind != "f":
        divisor = np.where(np.equal(b, 0), 1, b)
        return (np.abs(a) // np.abs(divisor)) * np.sign(a) * np.sign(divisor)
    return np.divide(a, b)


def rest(a: Lanes, b: Lanes) -> Lanes:
    """Remainder of integers with the sign of the dividend."""
    return np.fmod(a, np.where(np.equal(b, 0), 1, b))


def left(a: Lanes, by: Lanes) -> Lanes:
    """Bits of an unsigned integer, moved to the left."""
    return np.asarray(a, np.uint64) << np.asarray(by).astype(np.uint64)


def right(a: Lanes, by: Lanes) -> Lanes:
    """Bits of an unsigned integer, moved to the right."""
    return np.asarray(a, np.uint64) >> np.asarray(by).astype(np.uint64)


def bits_of_real(value: Lanes) -> Lanes:
    """Bits of a number of double precision."""
    return np.asarray(value, float).view(np.int64)


def real_of_bits(bits: Lanes) -> Lanes:
    """Number of double precision with given bits."""
    return np.asarray(bits, np.int64).view(float)


def elements(array: Any, lanes: int) -> np.ndarray:
    """Nested lists of lanes as one array, last axis the lane."""
    if isinstance(array, np.ndarray):
        return np.broadcast_to(array[..., None], (*array.shape, lanes))
    return np.stack(
        [
            elements(each, lanes) if isinstance(each, list) else np.broadcast_to(each, (lanes,))
            for each in array
        ]
    )


def _count(indices: Sequence[Lanes]) -> int:
    return max(np.size(index) for index in indices)


def element(array: Any, indices: Sequence[Lanes]) -> Lanes:
    """Element of an array at an index of each lane.

    An index is limited to the array: a branch that no lane takes may have any.
    """
    if all(np.ndim(index) == 0 for index in indices):
        for index in indices:
            array = array[min(max(int(index), 0), len(array) - 1)]
        return array
    count = _count(indices)
    table = elements(array, max(count, _lanes_of(array)))
    bounded = [np.clip(i, 0, n - 1) for i, n in zip(indices, table.shape, strict=False)]
    return table[(*bounded, np.arange(table.shape[-1]))]


def _lanes_of(array: Any) -> int:
    """Number of lanes of nested lists; an array that is not in a list is a constant of all."""
    if isinstance(array, list):
        return max(_lanes_of(each) if isinstance(each, list) else np.size(each) for each in array)
    return 1


def put(array: list[Any], indices: Sequence[Lanes], lanes: Lanes, value: Lanes) -> None:
    """Set the element of an array at an index of each lane, for some lanes."""
    table = elements(array, np.size(lanes)).copy()
    value = np.broadcast_to(value, np.shape(lanes))
    bounded = [
        np.clip(np.broadcast_to(i, np.shape(lanes)), 0, n - 1)[lanes]
        for i, n in zip(indices, table.shape, strict=False)
    ]
    table[(*bounded, np.flatnonzero(lanes))] = value[lanes]
    _fill(array, table)


def _fill(array: list[Any], table: np.ndarray) -> None:
    for k, row in enumerate(table):
        if isinstance(array[k], list):
            _fill(array[k], row)
        else:
            array[k] = row


def pick(lanes: Lanes, new: Lanes, old: Lanes, path: Any = None) -> Lanes:
    """New value in some lanes, the old one in the others; without an old one, the new one."""
    return new if old is None else np.where(lanes, new, old)


OPERATIONS: dict[str, Any] = {
    **{f"c_{name}": _of_library(getattr(math, name), 1) for name in _ONE},
    **{f"c_{name}": _of_library(getattr(math, name), 2) for name in _TWO},
    **{f"c_{name}": function for name, function in _BASIC.items()},
    "c_round": _round,
    "quotient": quotient,
    "rest": rest,
    "left": left,
    "right": right,
    "inf": math.inf,
    "nan": math.nan,
}
"""Name in translated code -> operation."""
OPERATIONS |= {
    f"{name}f": function for name, function in OPERATIONS.items() if name.startswith("c_")
}

PLAIN: dict[str, Any] = {
    **OPERATIONS,
    "both": np.logical_and,
    "either": np.logical_or,
    "negated": np.logical_not,
    "yes": True,
    "no": False,
    "choose": np.where,
    "pick": pick,
    "element": element,
    "put": put,
    "is_finite": np.isfinite,
    "bits_of_real": bits_of_real,
    "real_of_bits": real_of_bits,
    "real": lambda x: np.asarray(x, float),
    "single": lambda x: np.asarray(x, np.float32),
    "whole": lambda x: np.asarray(x).astype(np.int64),
    "word": lambda x: np.asarray(x).astype(np.uint64),
    "lanes_and": np.logical_and,
    "lanes_and_not": lambda lanes, test: lanes & np.logical_not(test),
    "path_and": lambda path, test: None,
    "path_and_not": lambda path, test: None,
    "path_left": lambda path, inner: None,
    "some": np.any,
}
"""Operations that give the values only."""
