"""Metrics of a window of a run, computed during the simulation with constant memory.

A window has one or more intervals, for example each time that a mode is active. Only metrics whose
keys the scenario gives are compiled.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Int

from gyrostat.control.guidance import Mode
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import angle_between, error, error_angle, rotation_vector, to_inertial
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import TOLERANCE
from gyrostat.scenario.metrics.results import kinds_of_window
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.tracker_view import TRACKER_PERIODS, heads_of
from gyrostat.scenario.metrics.window_metric import WindowMetric, WindowSample, WindowStart
from gyrostat.scenario.scenario import Window
from gyrostat.scenario.sensing import options_of
from gyrostat.scenario.structure import Structure
from gyrostat.scenario.timeline import event_times, modes, slew_times


class SeenWindow(NamedTuple):
    """Running values of a window.

    Attributes:
        samples: Number of samples in the window.
        inside: Whether the last sample was in the window.
        metrics: Memory of each of its metrics.
    """

    samples: Int[Array, ""]
    inside: Bool[Array, ""]
    metrics: tuple[Any, ...]


class WindowObserver(eqx.Module):
    """Accumulates the metrics of a window sample by sample.

    Attributes:
        window: Window.
        mode: Number of its mode; None for all modes.
        boresight: Body direction whose pointing is evaluated, (3,); None for the full attitude.
        begin: Start of the window, s; from the start of its mode, if it has one.
        end: End of the window, s; from the start of its mode, if it has one.
        next_slew: Time from which a later slew holds, s; infinite if it does not end the window.
        metrics: Its metrics.
    """

    window: Window = eqx.field(static=True)
    mode: int | None = eqx.field(static=True)
    boresight: tuple[float, ...] | None = eqx.field(static=True)
    begin: Scalar
    end: Scalar
    next_slew: Scalar
    metrics: tuple[WindowMetric, ...]

    @classmethod
    def of(cls, window: Window, structure: Structure, values: Mapping[str, Scalar]) -> Self:
        """Create the observer of a window for a run with the given values."""
        options = options_of(values, f"window.{window.name}")
        start, next_slew = 0.0, jnp.array(jnp.inf)
        if window.event is not None:
            start = values[event_times(structure.events, structure.parts)[window.event]]
            for key in slew_times(structure.events, structure.parts):
                slew_time = jnp.where(values[key] > start, values[key], jnp.inf)
                next_slew = jnp.minimum(next_slew, slew_time)
        boresight = window.boresight or structure.boresight
        keys = ("run.control_period", "metrics.settled_angle", "metrics.settled_rate")
        window_start = WindowStart(
            *(window, structure.wheels, boresight, options),
            *(values[key] for key in keys),
            heads=heads_of(structure.parts),
            tracker_periods=values.get(TRACKER_PERIODS, 1.0),
        )
        return cls(
            window,
            None if window.mode is None else modes(structure.parts).index(window.mode),
            boresight,
            start + options["from"],
            start + options["until"],
            # an end in the scenario replaces the default end
            jnp.where(jnp.isinf(options["until"]), next_slew, jnp.inf),
            tuple(kind.of(window_start) for kind in kinds_of_window(window_start)),
        )

    def start(self) -> SeenWindow:
        """Initial values before the first sample."""
        memories = tuple(metric.start() for metric in self.metrics)
        return SeenWindow(jnp.zeros((), dtype=int), jnp.array(False), memories)

    def __call__(self, seen: SeenWindow, sample: Sample, k: Any) -> tuple[SeenWindow, Scalar]:
        """Update with sample k; returns the values and the error, infinite outside the window."""
        begin, inside = self.contains(sample.time, sample.mode)
        angle, turn, line = self._pointing(sample)
        rate = jnp.sqrt(sample.rate_error @ sample.rate_error)
        entered = inside & ~seen.inside
        view = WindowSample(sample, k == 0, inside, entered, begin, angle, turn, line, rate)
        memories = tuple(
            metric(memory, view) for metric, memory in zip(self.metrics, seen.metrics, strict=True)
        )
        after = SeenWindow(seen.samples + inside, inside, memories)
        return after, jnp.where(inside, angle, jnp.inf)

    def contains(self, time: Scalar, mode: Mode) -> tuple[Scalar, Bool[Array, ""]]:
        """Start of the interval of the window, s, and whether a time is in it.

        Args:
            time: Time, s.
            mode: Mode of the reference at this time.
        """
        start = 0.0 if self.mode is None else mode.start
        begin = start + self.begin
        inside: Any = (time + TOLERANCE >= begin) & (time <= start + self.end + TOLERANCE)
        inside &= time + TOLERANCE < self.next_slew
        if self.mode is not None:
            inside &= mode.number == self.mode
        return begin, inside

    def _pointing(self, sample: Sample) -> tuple[Scalar, Quaternion, Vector3]:
        """Pointing error, its rotation, and the direction that jitter and smear evaluate.

        The direction is that of the boresight in axes of the reference; without a boresight it is
        the rotation vector of the error.
        """
        turn = error(sample.state.attitude, sample.reference.attitude)
        if self.boresight is None:
            return sample.error, turn, rotation_vector(turn)
        angle = sample.error
        if self.window.boresight is not None:
            angle = pointing_error(sample.state.attitude, sample.reference.attitude, self.boresight)
        return angle, turn, to_inertial(turn, jnp.asarray(self.boresight))


def pointing_error(
    attitude: Quaternion, target: Quaternion, boresight: tuple[float, ...] | None
) -> Scalar:
    """Angle between the actual and the target direction of a boresight; None: full attitude."""
    if boresight is None:
        return error_angle(attitude, target)
    body = jnp.asarray(boresight)
    return angle_between(to_inertial(attitude, body), to_inertial(target, body))


def concluded(kinds: Sequence[type[WindowMetric]], seen: SeenWindow) -> dict[str, Vector]:
    """Metrics of a window, (runs,), except percentiles; NaN for a run without samples in it.

    Args:
        kinds: Its metrics.
        seen: Running values with a leading axis of runs, NumPy.
    """
    samples = np.maximum(seen.samples, 1)
    results: dict[str, Any] = {}
    for kind, memory in zip(kinds, seen.metrics, strict=True):
        results |= kind.results(memory, samples)
    return {
        name: np.where((seen.samples > 0) & np.isfinite(value), value, np.nan)
        for name, value in results.items()
    }
