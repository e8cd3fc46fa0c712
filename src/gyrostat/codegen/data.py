"""Large inputs and constants, which stay in memory and are read at computed indices."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Table

SMALL = 64
"""Largest number of elements of an array that is always one of scalars."""


@dataclass(frozen=True)
class Data:
    """Array of elements of a table that is an input or a constant, without a scalar for each.

    Attributes:
        table: Table in the memory of the inputs, or constant table.
        places: Index in the table of each element of the array.
    """

    table: Table
    places: NDArray[np.int64]

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.places.shape

    @property
    def size(self) -> int:
        """Number of elements."""
        return self.places.size

    def scalars(self) -> Scalars:
        """Operands for all elements."""
        return one_by_one(self.shape, self.table.known, self.places)

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


def data_or_scalars(data: Data) -> Data | Scalars:
    """Data, or their scalars if they are few."""
    return data.scalars() if data.size <= SMALL else data


def moved(
    move: Callable[..., Sequence[NDArray[Any]]], params: dict[str, Any], data: Data
) -> list[Data | Scalars]:
    """Results of a primitive that only rearranges elements."""
    return [data_or_scalars(Data(data.table, places)) for places in move(params, data.places)]
