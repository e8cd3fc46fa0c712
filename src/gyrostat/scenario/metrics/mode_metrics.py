"""Metrics of the modes of a reference that branches: times, errors, and changes."""

from collections.abc import Sequence
from typing import Any, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Column, RunEnd
from gyrostat.scenario.metrics.sample import Sample

COLUMNS = {
    "time": Column("s", "Time in this mode."),
    "error_rms": Column("rad", "Root mean square of the pointing error in this mode."),
    "error_max": Column("rad", "Largest pointing error in this mode."),
}
"""Metric of a mode -> its column."""
TAKEN = Column("1", "Number of times that this change of mode was taken.")
"""Column of a change of mode."""


def columns_of(modes: Sequence[str], changes: Sequence[str]) -> dict[str, Column]:
    """Columns of all modes and of all changes of mode."""
    columns = {f"mode.{mode}.{n}": column for mode in modes for n, column in COLUMNS.items()}
    return columns | {f"change.{name}": TAKEN for name in changes}


class ModeMetrics(eqx.Module):
    """Times, pointing errors and changes of the modes of a reference.

    Attributes:
        period: Control period, s.
        modes: Names of the modes.
        changes: Names of the changes of mode.
    """

    period: Scalar
    modes: tuple[str, ...] = eqx.field(static=True)
    changes: tuple[str, ...] = eqx.field(static=True)

    @classmethod
    def of(cls, period: Scalar, modes: Sequence[str], changes: Sequence[str]) -> Self:
        """Metrics of modes and changes with these names."""
        return cls(period, tuple(modes), tuple(changes))

    def start(self) -> dict[str, Any]:
        """Memory before the first sample."""
        zeros = {name: jnp.zeros(()) for name in columns_of(self.modes, self.changes)}
        return {**zeros, "start": jnp.zeros(()), "number": jnp.zeros((), dtype=int)}

    def __call__(
        self, memory: dict[str, Any], sample: Sample, is_last: Bool[Array, ""]
    ) -> dict[str, Any]:
        """Memory after a sample; the last one, after which no time follows, is in no mode."""
        after, mode = dict(memory), sample.mode
        for number, name in enumerate(self.modes):
            inside = (mode.number == number) & jnp.logical_not(is_last)
            place = f"mode.{name}."
            after[f"{place}time"] += jnp.where(inside, self.period, 0.0)
            after[f"{place}error_rms"] += jnp.where(inside, sample.error**2, 0.0)
            largest = jnp.maximum(after[f"{place}error_max"], sample.error)
            after[f"{place}error_max"] = jnp.where(inside, largest, after[f"{place}error_max"])
        changed = (mode.number != memory["number"]) | (mode.start != memory["start"])
        for number, name in enumerate(self.changes, 1):
            taken = changed & (sample.command.mode_change == number)
            after[f"change.{name}"] += jnp.where(taken, 1.0, 0.0)
        return {**after, "start": mode.start, "number": mode.number}

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """Each metric, (runs,); NaN for a mode in which a run was not."""
        table = {n: v for n, v in memory.items() if n not in ("start", "number")}
        for name in [n for n in table if n.endswith(".error_rms")]:
            place = name.removesuffix("error_rms")
            time = table[f"{place}time"]
            samples = np.maximum(np.round(time / end.period), 1.0)
            visited = time > 0.0
            table[name] = np.where(visited, np.sqrt(table[name] / samples), np.nan)
            largest = f"{place}error_max"
            table[largest] = np.where(visited, table[largest], np.nan)
        return table
