"""Metrics of a run: base of the classes in the folder run_metrics."""

from collections.abc import Mapping
from typing import Any, ClassVar, NamedTuple, Self

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.statistic import LAST, Statistic
from gyrostat.scenario.schema import Key
from gyrostat.spacecraft import Spacecraft
from gyrostat.spacecraft.sensors.keep_out import KeepOut

TOLERANCE = 1e-9
"""Tolerance of times, s: a multiple of the control period has a rounding error."""


class Column(NamedTuple):
    """Column of the table of runs.

    Attributes:
        unit: SI unit.
        meaning: One sentence.
        statistic: Statistic of the signal with the name of the column, where the class of the
            metric computes no results itself.
    """

    unit: str
    meaning: str
    statistic: Statistic = LAST


class RunStart(NamedTuple):
    """Start of a run, from which its metrics are made.

    Attributes:
        values: Values of the sections "metrics", "run" and "sensors", SI.
        spacecraft: Spacecraft.
        state: State of the plant.
        heads: Number of star tracker heads.
        keep_outs: Instruments that keep angles to bright bodies.
    """

    values: Mapping[str, Scalar]
    spacecraft: Spacecraft
    state: Any
    heads: int = 0
    keep_outs: tuple[KeepOut, ...] = ()


class RunEnd(NamedTuple):
    """End of several runs.

    Attributes:
        samples: Number of valid samples of each run, at least 1, (runs,).
        period: Control period, s.
    """

    samples: Vector
    period: float


class Metric(eqx.Module):
    """Metrics of a run that share a memory.

    This class computes statistics of signals over all samples. A subclass with another memory
    replaces `start`, `__call__` and `results`.

    Attributes:
        place: Place of its columns in the table of runs.
        columns: Metric -> its column.
        keys: Keys of the section "metrics" that it adds.
        asked_by: Section of a part with which a scenario has it; empty: every scenario has it.
    """

    place: ClassVar[int]
    columns: ClassVar[Mapping[str, Column]]
    keys: ClassVar[Mapping[str, Key]] = {}
    asked_by: ClassVar[str] = ""

    @classmethod
    def of(cls, run: RunStart) -> Self:
        """Create the metrics of a run."""
        return cls()

    def signals(self, sample: Sample) -> Mapping[str, Any]:
        """Signal of each column at a sample."""
        raise NotImplementedError

    def start(self) -> Any:
        """Memory before the first sample."""
        return started(self.columns)

    def __call__(self, memory: Any, sample: Sample, is_last: Bool[Array, ""]) -> Any:
        """Memory after a valid sample, of the same structure, shapes and types."""
        return updated(self.columns, memory, self.signals(sample))

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """Each metric, (runs,), of memories with a leading axis of runs; NaN: a run has none."""
        return results(cls.columns, memory, end.samples)


def started(columns: Mapping[str, Column]) -> dict[str, Scalar]:
    """Memory of the statistics of columns before the first sample."""
    return {name: jnp.array(column.statistic.start) for name, column in columns.items()}


def updated(
    columns: Mapping[str, Column], memory: Mapping[str, Scalar], signals: Mapping[str, Any]
) -> dict[str, Any]:
    """Memory of the statistics of columns after a sample."""
    return {
        name: _column(columns, name).statistic.updated(old, signals[name])
        for name, old in memory.items()
    }


def results(
    columns: Mapping[str, Column], memory: Mapping[str, Vector], samples: Vector
) -> dict[str, Vector]:
    """Statistics of columns, (runs,)."""
    return {
        name: _column(columns, name).statistic.result(sums, samples)
        for name, sums in memory.items()
    }


def _column(columns: Mapping[str, Column], name: str) -> Column:
    """Column of a name; those of single wheels, such as "dwell.a", are as that of all."""
    return columns[name.partition(".")[0]]
