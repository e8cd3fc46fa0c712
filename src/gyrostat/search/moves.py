"""Requests of a search for flights, and their answers."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector

FIRST = -1
"""Parent of a flight whose draws are those of the run with its number in a campaign."""


class Moves(NamedTuple):
    """Flights that a search requests.

    Attributes:
        normal: Standard normal numbers of the dispersions, (n, keys); None for those of the run
            with the number of the flight in a campaign.
        parents: Flight whose noise each flight takes over, (n,); `FIRST`: none.
        share: Expected share of the parts of a flight whose noise is drawn again.
        size: Number of flights.
        values: Dispersed values themselves, (n, keys), SI, in place of `normal`; not validated.
        variants: Scenario of each flight, (n,), an index into the variants of the search; None: the
            first.
    """

    normal: Matrix | None
    parents: NDArray[np.int64]
    share: float
    size: int
    values: Matrix | None = None
    variants: NDArray[np.int64] | None = None


class Answers(NamedTuple):
    """Results of requested flights.

    Attributes:
        numbers: Numbers of the flights, (n,); `FIRST` for one that was not flown because its values
            are not allowed.
        normal: Standard normal numbers of the dispersions, (n, keys); NaN for flights with given
            values.
        response: Response, (n,), or several responses, (n, responses); minus infinity for a flight
            that was not flown.
    """

    numbers: NDArray[np.int64]
    normal: Matrix
    response: Vector


def first_moves(count: int) -> Moves:
    """Flights with independent draws."""
    return Moves(None, np.full(count, FIRST), 1.0, count)
