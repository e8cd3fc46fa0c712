"""Metrics of a run, computed during the simulation with constant memory."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Int

from gyrostat.control.guidance import AttitudeReference, Mode
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error, to_body
from gyrostat.core.types import Vector
from gyrostat.runs.build import Setup
from gyrostat.runs.metrics import windows
from gyrostat.runs.metrics.error_vectors import error_vector
from gyrostat.runs.metrics.percentiles import Percentiles
from gyrostat.runs.metrics.windows import SeenWindow, WindowObserver, pointing_error
from gyrostat.scenario.metrics.budget import Budget
from gyrostat.scenario.metrics.kinds import kinds_of_run
from gyrostat.scenario.metrics.metric import TOLERANCE, RunEnd, RunStart
from gyrostat.scenario.metrics.mode_metrics import ModeMetrics
from gyrostat.scenario.metrics.results import (
    kinds_of_window,
    metrics_of,
    percentile_name,
    window_start,
)
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.metrics.tracker_view import heads_of
from gyrostat.scenario.requirement import ErrorSignal
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import Structure
from gyrostat.scenario.timeline import branches, mode_names
from gyrostat.simulation import Histories


class Seen(NamedTuple):
    """Running values of a run, from which its metrics are computed.

    Attributes:
        status: Status of the run.
        samples: Number of valid samples.
        windows: Running values of each window.
        metrics: Memory of each metric of the run, then of the momentum budget if there is one.
        own: Own metric -> its memory, and its result after the last sample.
        mode: Mode of the reference at the last sample.
    """

    status: Int[Array, ""]
    samples: Int[Array, ""]
    windows: tuple[SeenWindow, ...]
    metrics: tuple[Any, ...]
    own: dict[str, tuple[Any, Scalar]]
    mode: Mode


class Pointing(NamedTuple):
    """Pointing at one sample.

    Attributes:
        error: Pointing error, rad.
        counted: Pointing errors of the run and of each window, rad; infinite at samples that are
            not evaluated.
        vectors: Error vectors that pointing requirements need, (3,) each, rad.
    """

    error: Scalar
    counted: tuple[Scalar, ...]
    vectors: tuple[Vector3, ...]


class Observer(eqx.Module):
    """Accumulates the metrics of a run sample by sample.

    Attributes:
        setup: Parts of the run.
        values: Values of the sections "metrics", "run" and "sensors", SI.
        windows: Observers of the windows.
        metrics: Metrics of the run, and the momentum budget if there is one.
        count: Number of control periods of the run.
        boresight: Body direction whose pointing is evaluated, (3,); None for the full attitude.
        signals: Error vectors that pointing requirements need.
    """

    setup: Setup
    values: dict[str, Scalar]
    windows: tuple[WindowObserver, ...]
    metrics: tuple[Any, ...]
    count: int = eqx.field(static=True)
    boresight: tuple[float, ...] | None = eqx.field(static=True)
    signals: tuple[ErrorSignal, ...] = eqx.field(static=True)

    @classmethod
    def of(cls, structure: Structure, setup: Setup, values: dict[str, Scalar]) -> Self:
        """Create the observer of a run with the given values."""
        sections = ("metrics", "run", "sensors")
        options = {k: v for k, v in values.items() if k.split(".")[0] in sections}
        windows = tuple(WindowObserver.of(w, structure, values) for w in structure.windows)
        start = options, setup.plant.spacecraft, setup.start
        run = RunStart(*start, heads_of(structure.parts), setup.keep_outs)
        metrics: tuple[Any, ...] = tuple(kind.of(run) for kind in kinds_of_run(structure.parts))
        if branches(structure.parts):
            period = values["run.control_period"]
            metrics += (ModeMetrics.of(period, *mode_names(structure)),)
        metrics += () if setup.budget is None else (setup.budget,)
        static_fields = (structure.count, structure.boresight, structure.signals)
        return cls(setup, options, windows, metrics, *static_fields)

    def start(self) -> Seen:
        """Initial values before the first sample."""
        count, zero = jnp.zeros((), dtype=int), jnp.zeros(())
        return Seen(
            *(count, count),
            tuple(window.start() for window in self.windows),
            tuple(metric.start() for metric in self.metrics),
            {name: metric.start() for name, metric in self.setup.metrics.items()},
            Mode(count, zero)
            if self.setup.reference is None
            else self.setup.reference.start(watched=False),
        )

    def reference(self, row: Histories, time: Scalar, mode: Mode) -> tuple[AttitudeReference, Mode]:
        """Reference at a sample, and its mode as recorded; of fixed targets the mode is 0.

        Args:
            row: Sample.
            time: Its time, s.
            mode: Mode at the sample before.
        """
        reference = self.setup.reference
        if reference is not None:
            number, start = row.command.mode, row.command.mode_start
            around, before = reference.around, mode.number

            def begin(now: AttitudeReference) -> AttitudeReference:
                assert around is not None
                at_body = row.command.turn_from, row.command.turn_rate, now.acceleration
                found = around.begin(now, before, number, AttitudeReference(*at_body))
                # a change at a missing sample is recorded later, and starts at the reference
                is_now = start == time
                return jax.tree.map(lambda a, b: jnp.where(is_now, a, b), found, now)

            is_recorded = around is not None and "turn_from" in row.command._fields
            mode = reference.entered(mode, number, start, begin if is_recorded else None)
            return reference.at(mode, time), mode
        phase = jnp.sum(self.setup.starts <= time + 1e-9) - 1
        at_rest = jnp.zeros(3)
        target = AttitudeReference(self.setup.targets[phase], at_rest, at_rest)
        return target, mode

    def sample(self, row: Histories, time: Scalar, mode: Mode) -> Sample:
        """Sample from which the metrics are computed; `mode`: that of the sample before."""
        reference, mode = self.reference(row, time, mode)
        attitude, rate = row.state.attitude, row.record.rate
        if self.setup.reference is not None:
            rate = rate - to_body(error(attitude, reference.attitude), reference.rate)
        return Sample(
            time,
            pointing_error(attitude, reference.attitude, self.boresight),
            rate,
            reference,
            mode,
            {},
            *(row.state, row.measurement, row.command, row.record),
        )

    def __call__(self, seen: Seen, row: Histories, k: Int[Array, ""]) -> tuple[Seen, Pointing]:
        """Update with sample k; returns the new values and the pointing error."""
        valid, is_last = (row.status == 0) & (k <= self.count), k == self.count
        time = k * self.values["run.control_period"]
        sample = self.sample(row, time, seen.mode)
        pairs = [each(old, sample, k) for each, old in zip(self.windows, seen.windows, strict=True)]
        inside = {
            each.window.name: new.inside for each, (new, _) in zip(self.windows, pairs, strict=True)
        }
        sample_in_windows = sample._replace(windows=inside)
        metrics = zip(self.metrics, seen.metrics, strict=True)
        after = Seen(
            seen.status,
            seen.samples + 1,
            tuple(new for new, _ in pairs),
            tuple(metric(memory, sample_in_windows, is_last) for metric, memory in metrics),
            {
                name: metric(seen.own[name], sample_in_windows, is_last)
                for name, metric in self.setup.metrics.items()
            },
            sample.mode,
        )
        values = jax.tree.map(lambda new, old: jnp.where(valid, new, old), after, seen)
        counts = valid & (time + TOLERANCE >= self.values["metrics.after"])
        status = jnp.where(k <= self.count, row.status, seen.status)
        counted = (
            jnp.where(counts, sample.error, jnp.inf),
            *(jnp.where(valid, error, jnp.inf) for _, error in pairs),
        )
        vectors = tuple(error_vector(signal, sample) for signal in self.signals)
        return values._replace(status=status), Pointing(sample.error, counted, vectors)


def ended(seen: Any, period: float) -> Vector:
    """Time of the last valid sample of each run, s; 0 for a run that diverges at its start.

    Args:
        seen: `Seen` of NumPy with a leading axis of runs.
        period: Control period, s.
    """
    return np.maximum(seen.samples - 1, 0) * period


def concluded(
    scenario: Scenario, seen: Any, errors: Sequence[Percentiles], budget: Mapping[str, Vector]
) -> dict[str, Vector]:
    """Compute the metrics of several runs; NaN for incomplete runs and missing metrics.

    Args:
        scenario: Scenario of the runs.
        seen: `Seen` of NumPy with a leading axis of runs.
        errors: Percentiles of the pointing errors of the runs, and of each window.
        budget: Metrics of the pointing requirements.
    """
    end = RunEnd(np.maximum(seen.samples, 1), scenario.values["run.control_period"])
    table = _percentiles(scenario, errors[0]) | dict(budget)
    kinds: list[Any] = [*kinds_of_run(scenario.parts)]
    kinds += [ModeMetrics] if branches(scenario.parts) else []
    kinds += [Budget] if scenario.budget else []
    for kind, memory in zip(kinds, seen.metrics, strict=True):
        table |= kind.results(memory, end)
    for window, values, collector in zip(scenario.windows, seen.windows, errors[1:], strict=True):
        window_kinds = kinds_of_window(window_start(scenario, window))
        each = _percentiles(scenario, collector) | windows.concluded(window_kinds, values)
        table |= {f"{window.name}.{name}": entry for name, entry in each.items()}
    table |= {name: result for name, (_, result) in seen.own.items()}
    return {name: np.where(seen.status == 0, table[name], np.nan) for name in metrics_of(scenario)}


def _percentiles(scenario: Scenario, errors: Percentiles) -> dict[str, Vector]:
    """Percentiles of collected errors, by name."""
    return {percentile_name(p): errors.percentile(p) for p in scenario.percentiles}
