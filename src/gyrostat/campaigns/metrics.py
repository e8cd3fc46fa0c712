"""Metrics of a run, computed during the simulation with constant memory."""

from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float, Int

from gyrostat.campaigns.build import Setup
from gyrostat.campaigns.percentiles import Collector
from gyrostat.campaigns.scenario import Scenario
from gyrostat.campaigns.structure import Structure
from gyrostat.control.guidance import Mode
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import angle_between, error_angle, to_inertial
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


class Pointing(NamedTuple):
    """Pointing at one sample.

    Attributes:
        error: Pointing error, rad.
        counted: Pointing error, rad; infinite at samples that are not evaluated.
    """

    error: Scalar
    counted: Scalar


class Observer(eqx.Module):
    """Accumulates the metrics of a run sample by sample.

    Attributes:
        setup: Parts of the run.
        values: Values of the sections "metrics" and "run", SI.
        count: Number of control periods of the run.
        boresight: Body direction whose pointing is evaluated, (3,); None for the full attitude.
    """

    setup: Setup
    values: dict[str, Scalar]
    count: int = eqx.field(static=True)
    boresight: tuple[float, ...] | None = eqx.field(static=True)

    @classmethod
    def of(cls, structure: Structure, setup: Setup, values: dict[str, Scalar]) -> Self:
        """Create the observer of a run with the given values."""
        own = {k: v for k, v in values.items() if k.split(".")[0] in ("metrics", "run")}
        return cls(setup, own, structure.count, structure.boresight)

    def start(self) -> Seen:
        """Initial values before the first sample."""
        zero, none = jnp.zeros(()), jnp.zeros((), dtype=int)
        return Seen(
            *(none, none, none),
            *(zero, zero, zero, jnp.array(jnp.inf)),
            jnp.sign(self.setup.start.wheel_speed),
            *(jnp.array(-jnp.inf), none, zero, zero, zero, zero, none, zero),
        )

    def target(self, row: Histories, time: Scalar) -> Quaternion:
        """Target attitude at a sample, (4,); that of the reference by its recorded mode."""
        if self.setup.reference is not None:
            mode = Mode(row.command.mode, row.command.mode_start)
            return self.setup.reference.at(mode, time).attitude
        phase = jnp.sum(self.setup.starts <= time + 1e-9) - 1
        return self.setup.targets[phase]

    def error(self, attitude: Quaternion, target: Quaternion) -> Scalar:
        """Pointing error, rad."""
        if self.boresight is None:
            return error_angle(attitude, target)
        body = jnp.asarray(self.boresight)
        return angle_between(to_inertial(attitude, body), to_inertial(target, body))

    def __call__(self, seen: Seen, row: Histories, k: Int[Array, ""]) -> tuple[Seen, Pointing]:
        """Update with sample k; returns the new values and the pointing error."""
        valid = (row.status == 0) & (k <= self.count)
        time = k * self.values["run.control_period"]
        error = self.error(row.state.attitude, self.target(row, time))
        after = self._seen(seen, row, time, error)
        kept = jax.tree.map(lambda new, old: jnp.where(valid, new, old), after, seen)
        counts = valid & (time + 1e-9 >= self.values["metrics.after"])
        status = jnp.where(k <= self.count, row.status, seen.status)
        return kept._replace(status=status), Pointing(error, jnp.where(counts, error, jnp.inf))

    def _seen(self, seen: Seen, row: Histories, time: Scalar, error: Scalar) -> Seen:
        """New values except the status, for a valid sample."""
        values, wheels = self.values, self.setup.plant.spacecraft.wheels
        momentum, torque = row.record.wheel_momentum, row.command.torque
        counts = time + 1e-9 >= values["metrics.after"]
        sense = jnp.sign(row.state.wheel_speed)
        crossing = jnp.sum(counts & (sense != seen.sense) & (seen.sense != 0.0))
        crossed = jnp.where(crossing > 0, time, seen.crossed)
        near = counts & (time - crossed <= values["metrics.crossing_window"] + 1e-9)
        settled = error < values["metrics.settled_angle"]
        settled &= row.record.rate @ row.record.rate < values["metrics.settled_rate"] ** 2
        full = row.record.saturated | (jnp.abs(torque) >= FULL * jnp.asarray(wheels.torque_limit))
        full |= jnp.abs(momentum) >= FULL * jnp.asarray(wheels.momentum_limit)
        return Seen(
            status=seen.status,
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
            power=seen.power + jnp.sum(jnp.abs(torque * row.state.wheel_speed)),
        )


def ended(seen: Any, period: float) -> Vector:
    """Time of the last valid sample of each run, s; 0 for a run that diverges at its start.

    Args:
        seen: `Seen` with a leading axis of runs.
        period: Control period, s.
    """
    return np.maximum(np.asarray(seen.samples) - 1, 0) * period


def concluded(scenario: Scenario, seen: Any, errors: Collector) -> dict[str, Vector]:
    """Compute the metrics of several runs; NaN for incomplete runs and missing metrics.

    Args:
        scenario: Scenario of the runs.
        seen: `Seen` with a leading axis of runs.
        errors: Collected pointing errors of the runs.
    """
    seen = jax.tree.map(np.asarray, seen)
    period = scenario.values["run.control_period"]
    counted, samples = np.maximum(seen.counted, 1), np.maximum(seen.samples, 1)
    found = {f"error_p{p:g}": errors.percentile(p) for p in scenario.percentiles}
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
    return {name: np.where(seen.status == 0, entry, np.nan) for name, entry in found.items()}
