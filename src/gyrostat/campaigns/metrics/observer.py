"""Metrics of a run, computed during the simulation with constant memory."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float, Int

from gyrostat.campaigns.build import Setup
from gyrostat.campaigns.metrics import windows
from gyrostat.campaigns.metrics.percentiles import Collector
from gyrostat.campaigns.metrics.results import metrics_of, percentile_name
from gyrostat.campaigns.metrics.sample import Sample
from gyrostat.campaigns.metrics.schema import GAINED
from gyrostat.campaigns.metrics.windows import SeenWindow, WindowObserver, pointing_error
from gyrostat.campaigns.pointing.signals import error_vector
from gyrostat.campaigns.requirement import ErrorSignal
from gyrostat.campaigns.scenario import Scenario
from gyrostat.campaigns.structure import Structure
from gyrostat.control.guidance import AttitudeReference, Mode
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error, to_body
from gyrostat.core.types import Vector
from gyrostat.simulation import Histories

FULL = 0.999
"""Fraction of a limit at which a wheel counts as saturated."""


class Seen(NamedTuple):
    """Running sums and extremes of a run, from which its metrics are computed.

    Attributes:
        status: Status of the run.
        samples: Number of valid samples.
        counted: Number of valid samples after `metrics.after`.
        error: Pointing error at the last valid sample, rad.
        error_max: Largest pointing error after `metrics.after`, rad.
        error_square: Sum of squared pointing errors after `metrics.after`, rad².
        settled_from: Time since which the run is settled, s; infinite if it is not settled.
        sense: Sense of rotation of the wheels at the last sample, (wheels,).
        crossed: Time of the last zero crossing of a wheel, s.
        crossings: Number of zero crossings.
        crossing_peak: Largest pointing error within the window after a crossing, rad.
        momentum_peak: Largest momentum of any wheel, N·m·s.
        torque_peak: Largest commanded motor torque of any wheel, N·m.
        torque_square: Sum of mean squared commanded motor torques of the wheels, N²·m².
        saturated: Number of samples with a saturated wheel.
        power: Sum of the mechanical power, W.
        windows: Running values of each window.
        own: Own metric -> its memory, and its result after the last sample.
        gained: External torque -> its integral in inertial axes, (3,), N·m·s.
        mode: Mode of the reference at the last sample.
    """

    status: Int[Array, ""]
    samples: Int[Array, ""]
    counted: Int[Array, ""]
    error: Scalar
    error_max: Scalar
    error_square: Scalar
    settled_from: Scalar
    sense: Float[Array, " wheels"]
    crossed: Scalar
    crossings: Int[Array, ""]
    crossing_peak: Scalar
    momentum_peak: Scalar
    torque_peak: Scalar
    torque_square: Scalar
    saturated: Int[Array, ""]
    power: Scalar
    windows: tuple[SeenWindow, ...]
    own: dict[str, tuple[Any, Scalar]]
    gained: dict[str, Vector3]
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
        values: Values of the sections "metrics" and "run", SI.
        count: Number of control periods of the run.
        boresight: Body direction whose pointing is evaluated, (3,); None for the full attitude.
        windows: Observers of the windows.
        signals: Error vectors that pointing requirements need.
    """

    setup: Setup
    values: dict[str, Scalar]
    windows: tuple[WindowObserver, ...]
    count: int = eqx.field(static=True)
    boresight: tuple[float, ...] | None = eqx.field(static=True)
    signals: tuple[ErrorSignal, ...] = eqx.field(static=True)

    @classmethod
    def of(cls, structure: Structure, setup: Setup, values: dict[str, Scalar]) -> Self:
        """Create the observer of a run with the given values."""
        own = {k: v for k, v in values.items() if k.split(".")[0] in ("metrics", "run")}
        windows = tuple(WindowObserver.of(w, structure, values) for w in structure.windows)
        return cls(setup, own, windows, structure.count, structure.boresight, structure.signals)

    def start(self) -> Seen:
        """Initial values before the first sample."""
        zero, none = jnp.zeros(()), jnp.zeros((), dtype=int)
        return Seen(
            *(none, none, none),
            *(zero, zero, zero, jnp.array(jnp.inf)),
            jnp.sign(self.setup.start.wheel_speed),
            *(jnp.array(-jnp.inf), none, zero, zero, zero, zero, none, zero),
            tuple(window.start() for window in self.windows),
            {name: (own.start(), zero) for name, own in self.setup.metrics.items()},
            {} if self.setup.budget is None else self.setup.budget.start(),
            Mode(none, zero) if self.setup.reference is None else self.setup.reference.start(),
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
            mode = reference.entered(mode, row.command.mode, row.command.mode_start)
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
        valid = (row.status == 0) & (k <= self.count)
        time = k * self.values["run.control_period"]
        sample = self.sample(row, time, seen.mode)
        after = self._seen(seen, sample)
        pairs = [each(old, sample, k) for each, old in zip(self.windows, seen.windows, strict=True)]
        after = after._replace(windows=tuple(new for new, _ in pairs))
        inside = {
            w.window.name: new.inside for w, new in zip(self.windows, after.windows, strict=True)
        }
        after = after._replace(own=self._own(seen, sample._replace(windows=inside), k))
        if self.setup.budget is not None:
            period = jnp.where(k < self.count, self.values["run.control_period"], 0.0)
            after = after._replace(gained=self.setup.budget(seen.gained, sample, period))
        kept = jax.tree.map(lambda new, old: jnp.where(valid, new, old), after, seen)
        counts = valid & (time + 1e-9 >= self.values["metrics.after"])
        status = jnp.where(k <= self.count, row.status, seen.status)
        counted = (
            jnp.where(counts, sample.error, jnp.inf),
            *(jnp.where(valid, own, jnp.inf) for _, own in pairs),
        )
        vectors = tuple(error_vector(signal, sample) for signal in self.signals)
        return kept._replace(status=status), Pointing(sample.error, counted, vectors)

    def _own(self, seen: Seen, sample: Sample, k: Int[Array, ""]) -> dict[str, Any]:
        """New memories and results of the own metrics, for a valid sample."""
        found = {}
        for name, own in self.setup.metrics.items():
            memory = own(seen.own[name][0], sample)
            found[name] = memory, own.result_if(k == self.count, memory)
        return found

    def _seen(self, seen: Seen, sample: Sample) -> Seen:
        """New values for a valid sample, except status, windows, own metrics and budget."""
        values, wheels = self.values, self.setup.plant.spacecraft.wheels
        time, error, record = sample.time, sample.error, sample.record
        momentum, torque = record.wheel_momentum, sample.command.torque
        counts = time + 1e-9 >= values["metrics.after"]
        sense = jnp.sign(sample.state.wheel_speed)
        crossing = jnp.sum(counts & (sense != seen.sense) & (seen.sense != 0.0))
        crossed = jnp.where(crossing > 0, time, seen.crossed)
        near = counts & (time - crossed <= values["metrics.crossing_window"] + 1e-9)
        settled = error < values["metrics.settled_angle"]
        settled &= sample.rate_error @ sample.rate_error < values["metrics.settled_rate"] ** 2
        full = record.saturated | (jnp.abs(torque) >= FULL * jnp.asarray(wheels.torque_limit))
        full |= jnp.abs(momentum) >= FULL * jnp.asarray(wheels.momentum_limit)
        return seen._replace(
            samples=seen.samples + 1,
            counted=seen.counted + counts,
            error=error,
            error_max=jnp.where(counts, jnp.maximum(seen.error_max, error), seen.error_max),
            error_square=seen.error_square + jnp.where(counts, error**2, 0.0),
            settled_from=jnp.where(settled, jnp.minimum(seen.settled_from, time), jnp.inf),
            sense=sense,
            crossed=crossed,
            crossings=seen.crossings + crossing,
            crossing_peak=jnp.where(
                near, jnp.maximum(seen.crossing_peak, error), seen.crossing_peak
            ),
            momentum_peak=jnp.maximum(seen.momentum_peak, jnp.max(jnp.abs(momentum))),
            torque_peak=jnp.maximum(seen.torque_peak, jnp.max(jnp.abs(torque))),
            torque_square=seen.torque_square + jnp.mean(torque**2),
            saturated=seen.saturated + jnp.any(full),
            power=seen.power + jnp.sum(jnp.abs(torque * sample.state.wheel_speed)),
            mode=sample.mode,
        )


def ended(seen: Any, period: float) -> Vector:
    """Time of the last valid sample of each run, s; 0 for a run that diverges at its start.

    Args:
        seen: `Seen` with a leading axis of runs.
        period: Control period, s.
    """
    return np.maximum(np.asarray(seen.samples) - 1, 0) * period


def concluded(
    scenario: Scenario, seen: Any, errors: Sequence[Collector], budget: Mapping[str, Vector]
) -> dict[str, Vector]:
    """Compute the metrics of several runs; NaN for incomplete runs and missing metrics.

    Args:
        scenario: Scenario of the runs.
        seen: `Seen` with a leading axis of runs.
        errors: Collected pointing errors of the runs, and of each window.
        budget: Metrics of the pointing requirements.
    """
    seen = jax.tree.map(np.asarray, seen)
    period = scenario.values["run.control_period"]
    counted, samples = np.maximum(seen.counted, 1), np.maximum(seen.samples, 1)
    found = _percentiles(scenario, errors[0])
    some = seen.counted > 0
    found |= {
        "error_max": np.where(some, seen.error_max, np.nan),
        "error_rms": np.where(some, np.sqrt(seen.error_square / counted), np.nan),
        "error_end": seen.error,
        "settling": np.where(np.isfinite(seen.settled_from), seen.settled_from, np.nan),
        "crossings": seen.crossings.astype(float),
        "crossing_peak": np.where(seen.crossings > 0, seen.crossing_peak, np.nan),
        "momentum_peak": seen.momentum_peak,
        "torque_peak": seen.torque_peak,
        "torque_rms": np.sqrt(seen.torque_square / samples),
        "saturated": seen.saturated / samples,
        "energy": seen.power * period,
    }
    for window, own, collected in zip(scenario.windows, seen.windows, errors[1:], strict=True):
        each = _percentiles(scenario, collected) | windows.concluded(own)
        found |= {f"{window.name}.{name}": entry for name, entry in each.items()}
    found |= {name: result for name, (_, result) in seen.own.items()} | dict(budget)
    found |= {f"{GAINED}.{n}": np.linalg.norm(own, axis=-1) for n, own in seen.gained.items()}
    return {name: np.where(seen.status == 0, found[name], np.nan) for name in metrics_of(scenario)}


def _percentiles(scenario: Scenario, errors: Collector) -> dict[str, Vector]:
    """Percentiles of collected errors, by name."""
    return {percentile_name(p): errors.percentile(p) for p in scenario.percentiles}
