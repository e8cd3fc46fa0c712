"""Call of a compiled function for many runs, with NumPy only."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError

Words = NDArray[np.uint64]
KEY = "key<fry>"
"""Type of a random key of Threefry; its value is a word of 64 bits."""


class Type(NamedTuple):
    """Shape and type of an array.

    Attributes:
        shape: Shape, without the axis of runs.
        dtype: Name of the type of its numbers; `KEY` for random keys.
    """

    shape: tuple[int, ...]
    dtype: str


class Place(NamedTuple):
    """Position of a result in an output buffer of a run.

    Attributes:
        memory: Name of the buffer.
        start: Index of its first word.
        type: Shape and type.
        on_demand: Whether only requested runs are returned.
    """

    memory: str
    start: int
    type: Type
    on_demand: bool = False

    def of(self, words: Words) -> NDArray[Any]:
        """Result of each run, from the words of the buffer, (runs, words)."""
        own = words[:, self.start : self.start + int(np.prod(self.type.shape))]
        own = np.ascontiguousarray(own.reshape(len(words), *self.type.shape))
        dtype = self.type.dtype
        if dtype == KEY:
            return own
        return own != 0 if dtype == "bool" else own.view(_word(dtype)).astype(dtype)


class Layout(NamedTuple):
    """How the arguments and results of a compiled function lie in its buffers.

    Attributes:
        own: For each argument, whether it has a leading axis of runs.
        types: Type of each argument.
        places: Position of each result.
        words: Name of each output buffer -> number of words of a run.
    """

    own: tuple[bool, ...]
    types: tuple[Type, ...]
    places: tuple[Place, ...]
    words: dict[str, int]

    def shared_words(self, arguments: Sequence[Any]) -> Words:
        """Words that all runs share, (words,); the other arguments may be None.

        Raises:
            InputError: An argument has another shape or type than compiled for.
        """
        words = (word.ravel() for word in self._words(arguments, own=False))
        return np.concatenate([np.zeros(0, np.uint64), *words])

    def own_words(self, arguments: Sequence[Any]) -> Words:
        """Words of each run, (runs, words); arguments that the runs share may be None.

        Raises:
            InputError: An argument has another shape or type than compiled for, or the arguments
                have different numbers of runs.
        """
        words = self._words(arguments, own=True)
        counts = [len(array) for array in words]
        if len({*counts}) > 1:
            found = ", ".join(map(str, counts))
            raise InputError(f"runs: found {found}, expected one number of them")
        return np.concatenate([w.reshape(counts[0], int(np.prod(w.shape[1:]))) for w in words], 1)

    def _words(self, arguments: Sequence[Any], *, own: bool) -> list[Words]:
        return [
            _words(leaf, expected, own=own)
            for leaf, is_own, expected in zip(arguments, self.own, self.types, strict=True)
            if is_own == own
        ]


@dataclass(frozen=True)
class Compiled:
    """Compiled function of a list of arrays.

    Attributes:
        layout: Layout of its buffers.
        library: Loaded library.
    """

    layout: Layout
    library: ctypes.CDLL

    def __call__(
        self, arguments: Sequence[Any], asked: Sequence[int] = (), threads: int = 1
    ) -> list[NDArray[Any]]:
        """Compute all runs.

        Args:
            arguments: Arrays; those that differ between runs have a leading axis. Random keys are
                words of 64 bits.
            asked: Runs for which the rows on demand are returned.
            threads: Number of threads.

        Returns:
            The results with a leading axis of runs; rows on demand only for the runs in `asked`.

        Raises:
            InputError: The arguments have other shapes or types than those compiled for, or
                different numbers of runs; or a run in `asked` does not exist.
        """
        layout, width = self.layout, self.library.lanes()
        shared, own = layout.shared_words(arguments), layout.own_words(arguments)
        runs = len(own)
        if any(run not in range(runs) for run in asked):
            raise InputError(f"asked: found {list(asked)}, expected numbers below {runs}")
        groups = -(-runs // width)
        # unused lanes repeat the last run
        own = own[np.minimum(np.arange(groups * width), runs - 1)]
        own = own.reshape(groups, width, own.shape[1]).swapaxes(1, 2).copy()
        asked_groups = sorted({run // width for run in asked})
        slots = np.full(groups, -1, np.int64)
        slots[asked_groups] = np.arange(len(asked_groups))
        memory = {
            name: np.empty((len(asked_groups) if name == "asked" else groups, words, width), "u8")
            for name, words in layout.words.items()
        }
        self.library.fly_all(
            ctypes.c_int64(groups),
            ctypes.c_int64(threads),
            *(ctypes.c_void_p(a.ctypes.data) for a in (shared, own, *memory.values(), slots)),
        )
        lanes = {name: np.arange(runs) for name in memory}
        lanes["asked"] = np.array(
            [slots[run // width] * width + run % width for run in asked], np.int64
        )
        results = {
            name: buffer.swapaxes(1, 2).reshape(len(buffer) * width, buffer.shape[1])[lanes[name]]
            for name, buffer in memory.items()
        }
        # short rows on demand are among the results of all runs
        selection = {**results, "made": results["made"][list(asked)]}
        return [
            place.of((selection if place.on_demand else results)[place.memory])
            for place in layout.places
        ]


def _words(leaf: Any, expected: Type, *, own: bool) -> Words:
    """Numbers as 64-bit words: logical values as masks."""
    array = np.asarray(leaf)
    dtype = np.dtype(np.uint64 if expected.dtype == KEY else expected.dtype)
    fits = array.dtype == dtype
    if not fits and expected.dtype != KEY and np.bool_ not in (array.dtype, dtype):
        fits = np.can_cast(array.dtype, dtype)
    if not fits or array.shape[own:] != expected.shape or (own and not array.shape):
        raise InputError(
            f"argument: found {array.dtype}{list(array.shape[own:])}, expected "
            f"{expected.dtype}{list(expected.shape)}, which this was compiled for"
        )
    if array.dtype == np.bool_:
        return (-array.astype(np.int64)).view(np.uint64)
    if expected.dtype == KEY:
        return array
    return np.ascontiguousarray(array, _word(expected.dtype)).reshape(array.shape).view(np.uint64)


def _word(dtype: str) -> type[np.number]:
    return np.float64 if dtype == "float64" else np.int64
