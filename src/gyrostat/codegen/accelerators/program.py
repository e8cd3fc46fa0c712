"""Program of many runs on a device: the runs begin, and go on chunk by chunk."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.accelerators.device import Device, Kernel, Words
from gyrostat.codegen.accelerators.source import ranks_source, source
from gyrostat.codegen.simd.call import Layout, Place
from gyrostat.core.errors import InputError


class Part(NamedTuple):
    """Function as C for SIMD lanes.

    Attributes:
        text: Text of its module.
        layout: Layout of its arguments and results.
    """

    text: str
    layout: Layout


@dataclass(frozen=True)
class DeviceProgram:
    """Two functions: the first gives the state of runs, the second takes and gives it.

    The arguments of `begin` are also the last ones of `chunk`, whose first ones are the state and
    the number of the first sample. The state stays on the device.

    Attributes:
        device: Device.
        begin: Initialisation of runs.
        chunk: Control periods of one chunk of time.
    """

    device: Device
    begin: Part
    chunk: Part

    def kernels(self, *, records: bool = False) -> tuple[Kernel, Kernel]:
        """Compile both functions.

        Args:
            records: Whether the second writes rows on demand.

        Raises:
            InputError: The compiler refuses them.
        """
        return self._kernel(self.begin, records=False), self._kernel(self.chunk, records=records)

    def _kernel(self, part: Part, *, records: bool) -> Kernel:
        definitions = {"RECORDS": int(records), "WORK_GROUP": self.device.group}
        words = _shared(part.layout)
        if 0 < words <= self.device.by_value:
            definitions["SHARED_WORDS"] = words
        return self.device.kernel(source(part.text, definitions), "fly_all")

    def chunks(
        self, starts: Sequence[int], arguments: Sequence[Any], asked: Sequence[int] = ()
    ) -> Iterator[list[NDArray[Any] | None]]:
        """Compute all runs, chunk by chunk.

        Args:
            starts: Number of the first sample of each chunk.
            arguments: Arguments of `begin`.
            asked: Runs for which the rows on demand are returned.

        Yields:
            The results of the chunk; the state only after the last one, None before.

        Raises:
            InputError: The arguments have other shapes or types than those compiled for.
        """
        runs = len(self.begin.layout.own_words(arguments))
        if any(run not in range(runs) for run in asked):
            raise InputError(f"asked: found {list(asked)}, expected numbers below {runs}")
        flight = _Flight(self, arguments, asked)
        places = self.chunk.layout.places
        state = len(self.begin.layout.places)
        for first in starts:
            flight.go_on(first)
            skip = 0 if first == starts[-1] else state
            yield [*[None] * skip, *map(flight.result, places[skip:])]

    def ranked(
        self,
        starts: Sequence[int],
        arguments: Sequence[Any],
        wanted: Sequence[int],
        series: Sequence[int],
        ranks: NDArray[np.int64],
    ) -> tuple[dict[int, NDArray[Any]], list[NDArray[np.float64]]]:
        """Compute all runs; return values of given ranks instead of all samples.

        Args:
            starts: Number of the first sample of each chunk.
            arguments: Arguments of `begin`.
            wanted: Indices of the results that are returned after the last chunk.
            series: Indices of results with a real number of 0 or above for each sample of a chunk.
            ranks: Rank, from 1, for each share and each number of finite values, (shares,
                1 + samples).

        Returns:
            The wanted results by their indices, and the values of each series, (shares, runs), NaN
            without finite values.

        Raises:
            InputError: The arguments have other shapes or types than those compiled for.
        """
        flight = _Flight(self, arguments, ())
        queue = flight.queue
        runs, places = flight.runs, self.chunk.layout.places
        samples, shares = ranks.shape[1] - 1, len(ranks)
        memories = [queue.memory(samples * runs) for _ in series]
        done = 0
        for first in starts:
            flight.go_on(first)
            for memory, index in zip(memories, series, strict=True):
                place = places[index]
                words = _size(place) * runs
                source = flight.outputs[place.memory]
                queue.copy(source, place.start * runs, memory, done * runs, words)
            done += _size(places[series[0]])
        kernel = self.device.kernel(ranks_source(self.device.group), "ranked")
        values = []
        table = np.ascontiguousarray(ranks).view(np.uint64)
        ranks_memory, found = queue.memory(table.size), queue.memory(shares * runs)
        queue.write(ranks_memory, 0, table)
        for memory in memories:
            queue.launch(kernel, runs, [memory, ranks_memory, found, runs, samples, shares])
            words = np.empty((shares, runs), np.uint64)
            queue.read(found, 0, words)
            values.append(words.view(np.float64))
        return {index: flight.result(places[index]) for index in wanted}, values


class _Flight:
    """Runs on their way, with their memory on the device.

    Attributes:
        runs: Number of runs.
        queue: Queue of the device.
        outputs: Memory of each output of the chunk before.
    """

    def __init__(self, program: DeviceProgram, arguments: Sequence[Any], asked: Sequence[int]):
        own = program.begin.layout.own_words(arguments)
        self._program, self._arguments, self._asked = program, arguments, list(asked)
        self.runs, self.queue = len(own), program.device.queue()
        begin, self._chunk = program.kernels(records=bool(asked))
        state = program.begin.layout.places
        size = sum(map(_size, state))
        self._own = self.queue.memory((size + own.shape[1]) * self.runs)
        self.queue.write(self._own, size * self.runs, np.ascontiguousarray(own.T))
        place = np.full(self.runs, -1, np.int64)
        place[self._asked] = np.arange(len(asked))
        self._place = self.queue.memory(self.runs)
        self.queue.write(self._place, 0, place.view(np.uint64))
        self.outputs = self._memories(program.begin.layout)
        self._launch(begin, program.begin.layout.shared_words(arguments), size)
        self._keep(state)
        self.outputs = self._memories(program.chunk.layout)

    def go_on(self, first: int) -> None:
        """Compute the next chunk, from sample `first` on."""
        layout, state = self._program.chunk.layout, len(self._program.begin.layout.places)
        nothing = [None] * state
        shared = layout.shared_words((*nothing, np.int64(first), *self._arguments))
        self._launch(self._chunk, shared, 0)
        self._keep(layout.places[:state])

    def result(self, place: Place) -> NDArray[Any]:
        """Result of the chunk before, (runs, ...), or of the requested runs."""
        # short rows on demand are among the results of all runs
        is_short = place.on_demand and place.memory != "asked"
        count = len(self._asked) if place.memory == "asked" else self.runs
        words = np.empty((_size(place), count), np.uint64)
        self.queue.read(self.outputs[place.memory], place.start * count, words)
        return place._replace(start=0).of(words.T[self._asked] if is_short else words.T)

    def _memories(self, layout: Layout) -> dict[str, Any]:
        return {
            name: self.queue.memory(words * (len(self._asked) if name == "asked" else self.runs))
            for name, words in layout.words.items()
        }

    def _launch(self, kernel: Kernel, shared: Words, first: int) -> None:
        memories = [self._own, *self.outputs.values(), self._place]
        numbers = [self.runs, len(self._asked), first]
        self.queue.launch(kernel, self.runs, [shared, *memories, *numbers])

    def _keep(self, places: Sequence[Place]) -> None:
        """Copy results one after the other to the inputs; those beside each other in one go."""
        pieces: list[list[Any]] = []
        for place in places:
            last = pieces[-1] if pieces else None
            if last and last[0] == place.memory and last[1] + last[2] == place.start:
                last[2] += _size(place)
            else:
                pieces.append([place.memory, place.start, _size(place)])
        start = 0
        for name, first, words in pieces:
            numbers = (first * self.runs, self._own, start * self.runs, words * self.runs)
            self.queue.copy(self.outputs[name], *numbers)
            start += words


def _shared(layout: Layout) -> int:
    """Number of words that all runs share."""
    kinds = zip(layout.own, layout.types, strict=True)
    return sum(int(np.prod(each.shape)) for own, each in kinds if not own)


def _size(place: Place) -> int:
    return int(np.prod(place.type.shape))
