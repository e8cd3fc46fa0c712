"""Program of many runs on a device: the runs begin, and go on chunk by chunk."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.accelerators.device import Device, Kernel, Queue, Words
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
        begin, chunk = (
            self.device.kernel(part.text, _shared(part.layout), records=flag)
            for part, flag in ((self.begin, False), (self.chunk, records))
        )
        return begin, chunk

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
        begin, chunk = self.kernels(records=bool(asked))
        state = self.begin.layout.places
        own = self.begin.layout.own_words(arguments)
        runs, queue = len(own), self.device.queue()
        if any(run not in range(runs) for run in asked):
            raise InputError(f"asked: found {list(asked)}, expected numbers below {runs}")
        size = sum(_size(place) for place in state)
        memory = queue.memory((size + own.shape[1]) * runs)
        queue.write(memory, size * runs, np.ascontiguousarray(own.T))
        place = np.full(runs, -1, np.int64)
        place[list(asked)] = np.arange(len(asked))
        places = queue.memory(runs)
        queue.write(places, 0, place.view(np.uint64))
        outputs = self._outputs(queue, self.begin.layout, runs, 0)
        shared = self.begin.layout.shared_words(arguments)
        queue.launch(begin, shared, [memory, *outputs.values(), places], [runs, 0, size])
        _keep(queue, state, outputs, memory, runs)
        outputs = self._outputs(queue, self.chunk.layout, runs, len(asked))
        nothing = [None] * len(state)
        for first in starts:
            shared = self.chunk.layout.shared_words((*nothing, np.int64(first), *arguments))
            memories = [memory, *outputs.values(), places]
            queue.launch(chunk, shared, memories, [runs, len(asked), 0])
            _keep(queue, self.chunk.layout.places[: len(state)], outputs, memory, runs)
            is_last = first == starts[-1]
            yield self._results(queue, outputs, runs, asked, skip=0 if is_last else len(state))

    def _outputs(self, queue: Queue, layout: Layout, runs: int, asked: int) -> dict[str, Any]:
        return {
            name: queue.memory(words * (asked if name == "asked" else runs))
            for name, words in layout.words.items()
        }

    def _results(
        self,
        queue: Queue,
        outputs: dict[str, Any],
        runs: int,
        asked: Sequence[int],
        skip: int,
    ) -> list[NDArray[Any] | None]:
        """Results of a chunk, None for the first ones."""
        layout = self.chunk.layout
        places = layout.places[skip:]
        words: dict[str, Words] = {}
        for name in {place.memory for place in places}:
            count = len(asked) if name == "asked" else runs
            buffer = np.empty((layout.words[name], count), np.uint64)
            queue.read(outputs[name], 0, buffer)
            words[name] = buffer.T
        # short rows on demand are among the results of all runs
        short = {**words, "made": words["made"][list(asked)]} if "made" in words else words
        memories = [short if place.on_demand else words for place in places]
        results = [place.of(m[place.memory]) for m, place in zip(memories, places, strict=True)]
        return [*[None] * skip, *results]


def _shared(layout: Layout) -> int:
    """Number of words that all runs share."""
    kinds = zip(layout.own, layout.types, strict=True)
    return sum(int(np.prod(each.shape)) for own, each in kinds if not own)


def _size(place: Place) -> int:
    return int(np.prod(place.type.shape))


def _keep(
    queue: Queue, places: Sequence[Place], outputs: dict[str, Any], memory: Any, runs: int
) -> None:
    """Copy results one after the other to memory; those beside each other in one go."""
    pieces: list[list[Any]] = []
    for place in places:
        last = pieces[-1] if pieces else None
        if last and last[0] == place.memory and last[1] + last[2] == place.start:
            last[2] += _size(place)
        else:
            pieces.append([place.memory, place.start, _size(place)])
    start = 0
    for name, first, words in pieces:
        queue.copy(outputs[name], first * runs, memory, start * runs, words * runs)
        start += words
