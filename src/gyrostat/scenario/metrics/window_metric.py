"""Metrics of a window: base of the classes in the folder window_metrics."""

from collections.abc import Collection, Mapping
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Column, results, started, updated
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.scenario import Window
from gyrostat.scenario.schema import Key


class WindowStart(NamedTuple):
    """Window of a run, from which its metrics are made.

    Attributes:
        window: Window.
        wheels: Names of the wheels.
        boresight: Body direction whose pointing is evaluated, (3,); None for the full attitude.
        values: Numbers of the window, SI; only their names are known where columns are asked for.
        period: Control period, s.
        settled_angle: Settling threshold of the pointing error, rad.
        settled_rate: Settling threshold of the rate error, rad/s.
        heads: Number of star tracker heads.
        tracker_periods: Control periods between samples of the star tracker.
    """

    window: Window
    wheels: Collection[str]
    boresight: tuple[float, ...] | None
    values: Mapping[str, Any]
    period: Scalar | float = 0.0
    settled_angle: Scalar | float = 0.0
    settled_rate: Scalar | float = 0.0
    heads: int = 0
    tracker_periods: Scalar | float = 1.0


class WindowSample(NamedTuple):
    """Sample of a run as a window sees it.

    Attributes:
        run: Sample of the run.
        first: Whether it is the first sample of the run.
        inside: Whether it is in the window.
        entered: Whether it is the first sample of an interval of the window.
        begin: Start of the interval, s.
        angle: Pointing error, rad.
        turn: Rotation from the reference to the attitude, quaternion, (4,).
        line: Boresight in axes of the reference, (3,); without a boresight the rotation vector of
            the error, rad.
        rate: Size of the rate error, rad/s.
    """

    run: Sample
    first: Bool[Array, ""]
    inside: Bool[Array, ""]
    entered: Bool[Array, ""]
    begin: Scalar
    angle: Scalar
    turn: Quaternion
    line: Vector3
    rate: Scalar


class WindowTable(Protocol):
    """Table of a window in a scenario file."""

    def refuse(self, key: str, found: object, expected: str) -> InputError:
        """Error that says what was found and what is expected."""
        ...

    def multiple(self, key: str, value: float, name: str, part: float, most: int) -> int:
        """Validate a whole number of units; raises `InputError`."""
        ...


class WindowMetric(eqx.Module):
    """Metrics of a window that share a memory; a window has those that its keys ask for.

    This class computes statistics of signals over the samples of the window. A subclass whose
    signals need a memory replaces `before` and `signals`; one with another memory `start`,
    `__call__` and `results`.

    Attributes:
        place: Place of its columns in the table of runs.
        columns: Metric -> its column.
        keys: Keys of a window that it adds.
        asked_by: Key of a window that asks for it, or "star_tracker": the heads of one; empty:
            every window has it.
    """

    place: ClassVar[int]
    columns: ClassVar[Mapping[str, Column]]
    keys: ClassVar[Mapping[str, Key]] = {}
    asked_by: ClassVar[str] = ""

    @classmethod
    def of(cls, window: WindowStart) -> Self:
        """Create the metrics of a window."""
        return cls()

    @classmethod
    def check(cls, window: WindowStart, length: float, table: WindowTable) -> None:
        """Validate the numbers of a window, also of one that does not ask for it.

        Args:
            window: Window, with the keys that it gives.
            length: Length of the window, s.
            table: Table of the window, for messages.

        Raises:
            InputError: A number contradicts another one.
        """

    @classmethod
    def columns_of(cls, window: WindowStart) -> Mapping[str, Column]:
        """Columns in a window that has this metric."""
        return cls.columns

    def before(self) -> Any:
        """Memory of the signals before the first sample."""
        return ()

    def signals(self, memory: Any, sample: WindowSample) -> tuple[Any, Mapping[str, Any]]:
        """Memory after a sample, and the signal of each column; of samples outside too."""
        raise NotImplementedError

    def start(self) -> Any:
        """Memory before the first sample."""
        return self.before(), started(self.columns)

    def __call__(self, memory: Any, sample: WindowSample) -> Any:
        """Memory after a valid sample, of the same structure, shapes and types."""
        before, old = memory
        after, signals = self.signals(before, sample)
        new = updated(self.columns, old, signals)
        return after, jax.tree.map(lambda n, o: jnp.where(sample.inside, n, o), new, old)

    @classmethod
    def results(cls, memory: Any, samples: Vector) -> dict[str, Vector]:
        """Each metric, (runs,), of memories with a leading axis of runs.

        Args:
            memory: Memories after the runs, NumPy.
            samples: Number of samples in the window, at least 1, (runs,).
        """
        return results(cls.columns, memory[1], samples)


def check_band(values: Mapping[str, float], name: str, table: WindowTable) -> None:
    """Validate the ends of a band, NAME_above and NAME_below; raises `InputError`."""
    above, below = values.get(f"{name}_above"), values.get(f"{name}_below")
    if above is not None and below is not None and above >= below:
        raise table.refuse(f"{name}_below", below, f"more than {name}_above, {above:g}")
