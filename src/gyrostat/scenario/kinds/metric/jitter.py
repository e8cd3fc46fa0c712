"""Jitter of the line of sight by the wheels, at the speeds that a run flies."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.scenario import WINDOWS, Scenario
from gyrostat.scenario.schema import positive

if TYPE_CHECKING:
    from gyrostat.microvibration.sight_table import SightTable


class JitterTable(eqx.Module):
    """Smear and jitter of the line of sight over wheel speeds.

    Attributes:
        table: Mean square by each wheel over its speed.
        senses: 1 for a wheel whose axis is that of the structure, -1 for the opposite, (wheels,).
    """

    table: "SightTable"
    senses: PerWheel

    def __call__(self, speed: PerWheel) -> Scalar:
        """Mean square about both axes by all wheels, rad²; NaN: a wheel is faster than the table.

        Args:
            speed: Wheel speeds, (wheels,), rad/s.
        """
        lowest, highest, first, squares = map(jnp.asarray, self.table)
        turned = speed * self.senses
        size = jnp.abs(turned)
        cells = len(first) - 1
        place = jnp.maximum((size - lowest) / (highest - lowest) * cells, 0.0)
        cell = jnp.minimum(place.astype(int), cells - 1)
        intervals = first[cell + 1] - first[cell] - 1
        within = (place - cell) * intervals
        row = jnp.minimum(within.astype(int), intervals - 1)
        wheel, sense = jnp.arange(len(size)), jnp.where(turned < 0.0, 1, 0)
        low, high = (squares[first[cell] + row + k, wheel, sense] for k in (0, 1))
        total = jnp.sum(low + (within - row) * (high - low))
        return jnp.where(jnp.any(size > highest), jnp.nan, total)


class Jitter(eqx.Module):
    """Metric of a run, a `gyrostat.scenario.user.metric.RunMetric`.

    Attributes:
        table: Smear and jitter over wheel speeds.
        scale: Factor on the loads of all wheels.
        windows: Names of the windows whose samples count; none: all samples.
    """

    table: JitterTable
    scale: Scalar
    windows: tuple[str, ...] = eqx.field(static=True)

    def start(self) -> tuple[tuple[Scalar, Scalar], Scalar]:
        """Sum of mean squares and number of samples before the first one, and the metric."""
        zero = jnp.zeros(())
        return (zero, zero), zero

    def __call__(
        self, memory: tuple[tuple[Scalar, Scalar], Scalar], sample: Sample, is_last: Bool[Array, ""]
    ) -> tuple[tuple[Scalar, Scalar], Scalar]:
        """Memory after a sample, and the metric until it, rad."""
        total, count = memory[0]
        counts: Any = jnp.array(True)
        if self.windows:
            counts = jnp.any(jnp.stack([sample.windows[name] for name in self.windows]))
        square = self.table(sample.state.wheel_speed)
        total = jnp.where(counts, total + square, total)
        count = jnp.where(counts, count + 1.0, count)
        return (total, count), self.scale * jnp.sqrt(total / count)


@dataclass(frozen=True, eq=False)
class JitterKind(Kind):
    """Root mean square of smear and jitter of the line of sight by the wheels in its windows."""

    name = "jitter"
    unit = "rad"
    texts = ("file",)
    links: ClassVar[Mapping[str, str]] = {"window": WINDOWS}
    scale: Annotated[Scalar, positive("1", 1.0, "Factor on the loads of all wheels.")]

    @classmethod
    def check(cls, place: str, scenario: Scenario) -> None:
        """See `Kind.check`: the windows exist, which can be replaced."""
        names = [window.name for window in scenario.windows]
        for part in scenario.parts:
            for name in part.linked("window") if f"{part.section}.{part.name}" == place else ():
                if name not in names:
                    raise InputError(
                        f"key {place}.window: found {name!r}, expected one of "
                        f"{', '.join(names) or 'the windows of the metrics'}"
                    )

    @classmethod
    def tabulated(cls, scenario: Scenario, text: str) -> JitterTable:
        """Table of which the metric is made.

        Args:
            scenario: Scenario.
            text: Wheels on their structure, of `gyrostat.microvibration.structure_text`.

        Raises:
            InputError: The structure has other wheels, or its motion changes too fast.
        """
        # they import SciPy, which takes long
        from gyrostat.microvibration.mounting import senses_of
        from gyrostat.microvibration.sight_table import sight_table
        from gyrostat.microvibration.structure_text import structure_from

        structure = structure_from(text)
        axes = np.array(scenario.axes)
        senses: Any = senses_of(structure.wheels, scenario.wheels, axes, scenario.name)
        return JitterTable(sight_table(structure), senses)

    def make(self, context: Context) -> Jitter:
        """See `Kind.make`."""
        windows = context.links.get("window", ())
        return Jitter(context.tables[context.place], self.scale, windows)
