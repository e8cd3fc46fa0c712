"""Regular parts of an array of scalars and elements: each can be copied by one loop."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import Element
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Number

Part = tuple[slice, ...]


def identities(array: Scalars) -> NDArray[np.int64]:
    """Number of each element, the same for equal ones only."""
    numbers: dict[Any, int] = {}
    keys = (_key(each) for each in array.flat)
    values = [numbers.setdefault(key, len(numbers)) for key in keys]
    return np.array(values, np.int64).reshape(array.shape)


def _key(operand: Any) -> Any:
    if isinstance(operand, Number):
        return operand.kind, repr(operand.value)
    return operand if isinstance(operand, Element) else id(operand)


def regions(array: Scalars) -> list[Part]:
    """Rectangular parts that cover an array.

    In each, all elements are equal, or are elements of one table at constant distances.
    """
    kinds = _kinds(array)
    places = np.array(
        [each.place if isinstance(each, Element) else 0 for each in array.flat], np.int64
    ).reshape(array.shape)
    is_open = np.ones(array.shape, bool)
    parts = []
    for start in np.ndindex(array.shape):
        if is_open[start]:
            parts.append(_grown(start, kinds, places, is_open))
            is_open[parts[-1]] = False
    return parts


def _kinds(array: Scalars) -> NDArray[np.int64]:
    """Number of each element: the same for elements of one table."""
    numbers: dict[Any, int] = {}
    keys = (each.table if isinstance(each, Element) else _key(each) for each in array.flat)
    values = [numbers.setdefault(key, len(numbers)) for key in keys]
    return np.array(values, np.int64).reshape(array.shape)


def _grown(
    start: tuple[int, ...],
    kinds: NDArray[np.int64],
    places: NDArray[np.int64],
    is_open: NDArray[np.bool_],
) -> Part:
    """Largest regular part from a position, grown along the last axis first."""
    ends = [k + 1 for k in start]

    def part() -> Part:
        return tuple(slice(a, b) for a, b in zip(start, ends, strict=True))

    for axis in reversed(range(kinds.ndim)):
        step = None
        block = part()
        for layer in _layers(block, axis, kinds.shape[axis]):
            if not np.all(is_open[layer]) or not np.array_equal(kinds[layer], kinds[block]):
                break
            change = places[layer] - places[block]
            distance = change.flat[0]
            if np.any(change != distance):
                break
            if step is not None and distance != step * (ends[axis] - start[axis]):
                break
            step = distance if step is None else step
            ends[axis] += 1
    return part()


def _layers(block: Part, axis: int, length: int) -> Iterator[Part]:
    """The block moved on along an axis, by one, two ... places."""
    for k in range(block[axis].start + 1, length):
        yield (*block[:axis], slice(k, k + 1), *block[axis + 1 :])
