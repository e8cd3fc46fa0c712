"""Results of simulated runs, and their form in a message from a worker."""

from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.simulation.labelled import Labelled


class Flown(NamedTuple):
    """Results of simulated runs.

    Attributes:
        columns: Columns of the table, name -> (runs,): "run", the drawn values, "status", "ended"
            and the metrics; (runs, numbers) for the lists of the pointing budget.
        histories: Histories of the requested runs over `run` and `time`; None if none were
            requested.
    """

    columns: dict[str, Vector]
    histories: Labelled | None

    def __reduce__(self) -> tuple[Any, ...]:
        """With columns of one type in one array: to send an array takes as long as its numbers."""
        types: dict[Any, list[str]] = {}
        for name, column in self.columns.items():
            types.setdefault((column.dtype, column.shape), []).append(name)
        stacks = [
            (names, np.stack([self.columns[name] for name in names])) for names in types.values()
        ]
        return _received, ([*self.columns], stacks, self.histories)


def _received(
    order: list[str], stacks: list[tuple[list[str], Matrix]], histories: Labelled | None
) -> Flown:
    """Results from their form in a message."""
    columns = {
        name: column for names, stack in stacks for name, column in zip(names, stack, strict=True)
    }
    return Flown({name: columns[name] for name in order}, histories)
