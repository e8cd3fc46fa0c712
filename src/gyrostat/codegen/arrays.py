"""Large arrays: parts of tables, deferred operations, and arrays with known zeros.

A small array is an array of scalars. A large one is `Data`, a part of a table; `Deferred`, an
operation on each element that a loop computes where it is needed; or an array of scalars and
`Element`s, which keeps known zeros of a matrix and moves elements without code.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import ZERO, Kind, Name, Operand, Table
from gyrostat.codegen.source import Source

SMALL = 64
"""Largest number of elements of an input or a constant that is always one of scalars."""


class Element(NamedTuple):
    """Element of a table at a known index."""

    table: Table
    place: int

    @property
    def kind(self) -> Kind:
        """Kind of number."""
        return self.table.kind


@dataclass(frozen=True)
class Data:
    """Array of elements of a table, without a scalar for each.

    Attributes:
        table: Table.
        places: Index in the table of each element of the array.
        base: Index that is added to all places; None for 0.
    """

    table: Table
    places: NDArray[np.int64]
    base: Operand | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.places.shape

    @property
    def size(self) -> int:
        """Number of elements."""
        return self.places.size

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.places.ndim

    def scalars(self) -> Scalars:
        """Operands for all elements, of a table that is an input or a constant."""
        return one_by_one(self.shape, self.table.known, self.places)

    def elements(self) -> Scalars:
        """Elements of the table, or numbers if it is constant; without a base."""
        if self.table.values:
            return self.scalars()
        return one_by_one(self.shape, lambda place: Element(self.table, int(place)), self.places)

    def strides(self) -> list[int] | None:
        """Distance in the table between neighbours along each axis; None if it is not constant."""
        places = self.places
        origin = (0,) * places.ndim
        strides, regular = [], places[origin]
        for axis, length in enumerate(places.shape):
            second = (*origin[:axis], min(1, length - 1), *origin[axis + 1 :])
            strides.append(int(places[second] - places[origin]))
            steps = np.arange(length).reshape([-1, *[1] * (places.ndim - axis - 1)])
            regular = regular + strides[axis] * steps
        return strides if np.array_equal(regular, places) else None


@dataclass(frozen=True, eq=False)
class Deferred:
    """Operation on each element of arrays, which no statement computes yet.

    Attributes:
        operation: Name of the operation.
        operands: Arrays of one shape.
        kind: Kind of number of the result.
        source: Line of Python.
    """

    operation: str
    operands: tuple["Array", ...]
    kind: Kind
    source: Source

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.operands[0].shape

    @property
    def size(self) -> int:
        """Number of elements."""
        return self.operands[0].size

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)


Array = Scalars | Data | Deferred


def leaves(array: Array) -> Iterator[Scalars | Data]:
    """Arrays that an array is computed from, without the deferred operations between."""
    if isinstance(array, Deferred):
        for operand in array.operands:
            yield from leaves(operand)
    else:
        yield array


def is_plain(array: Array) -> bool:
    """Whether all elements are scalars or constants."""
    if isinstance(array, Data):
        return bool(array.table.values) and array.base is None
    return isinstance(array, np.ndarray) and not has_elements(array)


def has_elements(array: Scalars) -> bool:
    """Whether an array of scalars contains elements of tables."""
    return any(isinstance(each, Element) for each in array.flat)


def joined(array: Scalars) -> Scalars | Data:
    """Array as data if all its elements are those of one table."""
    first = next(array.flat, None)
    if not isinstance(first, Element):
        return array
    return _of_table(array, [each if isinstance(each, Element) else None for each in array.flat])


def of_caller(array: Scalars) -> Scalars | Data:
    """Array as data if all its elements are those of one array of the caller."""
    elements = [
        Element(each.table, each.place[0]) if isinstance(each, Name) and each.table else None
        for each in array.flat
    ]
    return _of_table(array, elements)


def _of_table(array: Scalars, elements: list[Element | None]) -> Scalars | Data:
    if not elements or elements[0] is None:
        return array
    table = elements[0].table
    places = [each.place for each in elements if each is not None and each.table is table]
    if len(places) < len(elements):
        return array
    return Data(table, np.array(places, np.int64).reshape(array.shape))


def spread(array: Array, shape: tuple[int, ...]) -> Array:
    """Array broadcast to a shape."""
    if array.shape == shape:
        return array
    return moved(lambda _, each: [np.broadcast_to(each, shape)], {}, array)[0]


def data_or_scalars(data: Data) -> Data | Scalars:
    """Input or constant as data, or its scalars if they are few."""
    return data.scalars() if data.size <= SMALL else data


def moved(
    move: Callable[..., Sequence[Any]],
    params: dict[str, Any],
    array: Array,
    done: dict[int, list[Array]] | None = None,
) -> list[Array]:
    """Results of a primitive that only rearranges the elements of one array.

    A deferred operation is moved to its operands.

    Args:
        move: Function of the parameters and an array.
        params: Parameters of the primitive.
        array: Array.
        done: Results so far, by the identity of the array: an operand of two operations is one.
    """
    done = {} if done is None else done
    if id(array) not in done:
        if isinstance(array, Data):
            parts = move(params, array.places)
            done[id(array)] = [Data(array.table, places, array.base) for places in parts]
        elif isinstance(array, Deferred):
            parts = [moved(move, params, each, done) for each in array.operands]
            done[id(array)] = [
                Deferred(array.operation, each, array.kind, array.source)
                for each in zip(*parts, strict=True)
            ]
        else:
            done[id(array)] = [np.asarray(each, dtype=object) for each in move(params, array)]
    return done[id(array)]


def used(array: Scalars) -> NDArray[np.bool_]:
    """Whether each element is other than the constant 0."""
    return np.array([each != ZERO for each in array.flat], bool).reshape(array.shape)


def runs_of(places: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Places in runs of constant distance."""
    start = 0
    while start < len(places):
        end = min(start + 2, len(places))
        step = places[end - 1] - places[start]
        while end < len(places) and places[end] - places[end - 1] == step:
            end += 1
        yield places[start:end]
        start = end
