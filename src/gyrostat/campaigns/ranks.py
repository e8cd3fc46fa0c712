"""Ranks of many runs, of several quantities, outside the memory."""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector

IN_MEMORY: Final = 16_000_000
"""Size of the ranks that stay in memory, bytes; more of them are in a temporary file."""
ROWS: Final = 32_768
"""Number of runs whose ranks are in memory as numbers at a time."""


def doubled_ranks(values: Vector) -> NDArray[np.unsignedinteger]:
    """Twice the ranks from 1, which are whole numbers: equal values have their mean rank.

    Args:
        values: Finite values, (runs,).
    """
    return _doubled(*_order(values))


def _order(values: Vector) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Order of values, and whether the value of each place differs from that of the one before.

    One more place marks the end.
    """
    count = len(values)
    order = np.argsort(values)
    is_first = np.ones(count + 1, bool)
    for first in range(1, count, ROWS):
        last = min(first + ROWS, count)
        part = values[order[first - 1 : last]]
        is_first[first:last] = part[1:] != part[:-1]
    return order, is_first


def _doubled(order: NDArray[np.int64], is_first: NDArray[np.bool_]) -> NDArray[np.unsignedinteger]:
    count = len(order)
    kind = _kind(count)
    ranks, first = np.empty(count, kind), 0
    while first < count:
        last = min(first + ROWS, count)
        last += int(np.argmax(is_first[last:]))  # equal values stay together
        starts = first + np.flatnonzero(is_first[first:last])
        ends = np.append(starts[1:], last)
        # the mean of the ranks start + 1 to end is (start + end + 1) / 2
        doubled = (starts + ends + 1).astype(kind)
        ranks[order[first:last]] = np.repeat(doubled, ends - starts)
        first = last
    return ranks


def _kind(count: int) -> np.dtype[np.unsignedinteger]:
    """Type of twice the rank of so many runs."""
    return np.dtype(np.uint32 if count < 2**31 else np.uint64)


class Ranks:
    """Ranks of several quantities over the same runs; a context, which removes its file at its end.

    Args:
        runs: Number of runs.
    """

    def __init__(self, runs: int):
        self._runs = runs
        self._count = 0
        self._kind = _kind(runs)
        self._file = tempfile.SpooledTemporaryFile(IN_MEMORY)  # noqa: SIM115

    def __enter__(self) -> Self:
        """Open the file."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Remove the file."""
        self._file.close()

    def add(self, read: Callable[[], Vector]) -> None:
        """Add a quantity.

        Args:
            read: Function that gives its finite values, (runs,); they are not in memory any more
                when their ranks are.
        """
        self._file.seek(0, 2)
        self._file.write(_doubled(*_order(read())).data)
        self._count += 1

    def centred(self, columns: Sequence[int] | range) -> Iterator[Matrix]:
        """Ranks minus their mean, part by part of the runs, (runs of the part, columns).

        Args:
            columns: Indices of the quantities, in the order in which they were added.
        """
        for first in range(0, self._runs, ROWS):
            count = min(ROWS, self._runs - first)
            yield np.stack([self._part(c, first, count) for c in columns], axis=1)

    def _part(self, column: int, first: int, count: int) -> Vector:
        self._file.seek((column * self._runs + first) * self._kind.itemsize)
        doubled = np.frombuffer(self._file.read(count * self._kind.itemsize), self._kind)
        return 0.5 * doubled.astype(np.float64) - 0.5 * (self._runs + 1.0)
