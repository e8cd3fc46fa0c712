"""Program of a scenario for an accelerator, from the texts of the native engine."""

import pickle
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from gyrostat.campaigns.native import program_name, trace
from gyrostat.codegen.accelerators.devices import device
from gyrostat.codegen.accelerators.program import DeviceProgram, Part
from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax
from gyrostat.core.threefry import Words
from gyrostat.core.types import Vector
from gyrostat.runs.designs import Plans
from gyrostat.runs.metrics.observer import Seen
from gyrostat.runs.metrics.percentiles import FoundPercentiles, ranks
from gyrostat.runs.run_loop import Drawn, runner_of
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.structure import Structure


class Stored(NamedTuple):
    """Program as it is stored; see `gyrostat.campaigns.native.Stored`.

    Attributes:
        begin: Initialisation of runs.
        chunk: Control periods of one chunk of time.
        seen: Tree of the accumulated metrics.
        records: Tree of the records.
    """

    begin: Part
    chunk: Part
    seen: Any
    records: Any


class AcceleratedProgram(NamedTuple):
    """Program of a scenario on a device.

    Attributes:
        program: Program.
        seen: See `Stored`.
        records: See `Stored`.
        starts: Index of the first sample of each chunk.
    """

    program: DeviceProgram
    seen: Any
    records: Any
    starts: range

    def chunks(
        self, nominal: Vector, drawn: Drawn, plans: Plans, keys: Words, asked: Sequence[int]
    ) -> Iterator[tuple[Seen | None, Any, Any]]:
        """See `gyrostat.campaigns.native.Program.chunks`; `Seen` comes with the last chunk."""
        arguments = (nominal, *map(np.asarray, jax.tree.leaves((drawn, plans))), keys)
        size = len(self.program.begin.layout.places)
        for results in self.program.chunks(self.starts, arguments, asked):
            carry, records = results[:size], results[size:]
            counted, rows = jax.tree.map(records.__getitem__, self.records)
            is_last = all(leaf is not None for leaf in carry)
            yield jax.tree.map(carry.__getitem__, self.seen) if is_last else None, counted, rows

    def concluded(
        self, nominal: Vector, drawn: Drawn, plans: Plans, keys: Words, percents: Sequence[float]
    ) -> tuple[Seen, list[FoundPercentiles]]:
        """Compute runs of which the samples are not needed: their errors stay on the device.

        Args:
            nominal: Nominal values.
            drawn: What each run has of its own.
            plans: Designs.
            keys: Random keys of the noise, (runs,).
            percents: Percentages of the percentiles of the errors.

        Returns:
            `Seen` after the last sample, and the percentiles of the errors of the run and of each
            window.
        """
        arguments = (nominal, *map(np.asarray, jax.tree.leaves((drawn, plans))), keys)
        state = len(self.program.begin.layout.places)
        counted = [state + index for index in self.records[0][0]]
        samples = sum(self.program.chunk.layout.places[counted[0]].type.shape) * len(self.starts)
        table = np.array([ranks(percent, samples) for percent in percents])
        wanted = jax.tree.leaves(self.seen)
        results, values = self.program.ranked(self.starts, arguments, wanted, counted, table)
        seen = jax.tree.map(results.__getitem__, self.seen)
        pairs = [dict(zip(percents, each, strict=True)) for each in values]
        return seen, [*map(FoundPercentiles, pairs)]


def accelerated_program(
    structure: Structure, plans: Plans, engine: str, *, verify: bool = False
) -> AcceleratedProgram:
    """Program of a scenario for a device; the texts are stored in the cache.

    Args:
        structure: Structure of the scenario.
        plans: Designs; only the shapes and types of their numbers are used.
        engine: Engine that uses an accelerator.
        verify: Trace the program although it is stored.

    Raises:
        InputError: There is no device, or the scenario contains an operation that is not supported.
    """
    target = device(engine)
    cache = private_cache() if is_shipped(structure) else None
    name = program_name(structure, plans, 0, "kernel")
    content = None if cache is None or verify else cache.read(name)
    if content is not None:
        stored: Stored = pickle.loads(content)
    else:
        traces, seen, records = trace(structure, plans, 0)
        begin, chunk = (Part(each.text, each.layout) for each in traces)
        stored = Stored(begin, chunk, seen, records)
        if cache is not None:
            cache.write(name, pickle.dumps(stored))
    program = DeviceProgram(target, stored.begin, stored.chunk)
    program.kernels()
    return AcceleratedProgram(program, *stored[2:], runner_of(structure).starts)
