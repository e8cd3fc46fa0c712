"""Metrics of a window of a run, computed during the simulation with constant memory.

A window has one or more intervals, for example each time that a mode is active. Only metrics whose
keys the scenario gives are compiled.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Int

from gyrostat.campaigns.metrics.band_filter import (
    Sections,
    States,
    at_rest,
    filtered,
    high_pass,
    low_pass,
)
from gyrostat.campaigns.metrics.exposures import Exposures, exposed, no_exposures
from gyrostat.campaigns.metrics.results import window_metrics
from gyrostat.campaigns.metrics.sample import Sample
from gyrostat.campaigns.scenario import Window
from gyrostat.campaigns.structure import Structure
from gyrostat.campaigns.timeline import event_times, modes, slew_times
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import angle_between, error, error_angle, rotation_vector, to_inertial
from gyrostat.core.types import Vector

TOLERANCE = 1e-9
"""Tolerance of times, s: a multiple of the control period has a rounding error."""
STATISTIC = {
    "error_max": "max",
    "error_rms": "rms",
    "error_end": "last",
    "rotation_max": "max",
    "rotation_rms": "rms",
    "rate_error_max": "max",
    "rate_error_rms": "rms",
    "smear": "max",
    "jitter": "rms",
    "dwell": "mean",
    "propellant": "sum",
}
"""Metric -> statistic of its signal over the samples of the window; settling has none."""


class SeenWindow(NamedTuple):
    """Running values of a window.

    Attributes:
        samples: Number of samples in the window.
        inside: Whether the last sample was in the window.
        since: Start of the last interval, s.
        settled_from: Time since which the last interval is settled, s; infinite: not settled.
        settling: Longest settling time of the intervals before the last, s.
        statistics: Metric -> running sum, maximum or last value of its signal.
        band: States of the jitter filter; None without jitter.
        exposures: Exposures; None without smear.
    """

    samples: Int[Array, ""]
    inside: Bool[Array, ""]
    since: Scalar
    settled_from: Scalar
    settling: Scalar
    statistics: dict[str, Scalar]
    band: States | None
    exposures: Exposures | None


class WindowObserver(eqx.Module):
    """Accumulates the metrics of a window sample by sample.

    Attributes:
        window: Window.
        wheels: Names of the wheels.
        mode: Number of its mode; None for all modes.
        boresight: Body direction whose pointing is evaluated, (3,); None for the full attitude.
        values: Numbers of the window, SI.
        begin: Start of the window, s; from the start of its mode, if it has one.
        end: End of the window, s; from the start of its mode, if it has one.
        next_slew: Time from which a later slew holds, s; infinite if it does not end the window.
        period: Control period, s.
        settled_angle: Settling threshold of the pointing error, rad.
        settled_rate: Settling threshold of the rate error, rad/s.
    """

    window: Window = eqx.field(static=True)
    wheels: tuple[str, ...] = eqx.field(static=True)
    mode: int | None = eqx.field(static=True)
    boresight: tuple[float, ...] | None = eqx.field(static=True)
    values: dict[str, Scalar]
    begin: Scalar
    end: Scalar
    next_slew: Scalar
    period: Scalar
    settled_angle: Scalar
    settled_rate: Scalar

    @classmethod
    def of(cls, window: Window, structure: Structure, values: Mapping[str, Scalar]) -> Self:
        """Create the observer of a window for a run with the given values."""
        prefix = f"window.{window.name}."
        own = {k.removeprefix(prefix): v for k, v in values.items() if k.startswith(prefix)}
        start, next_slew = 0.0, jnp.array(jnp.inf)
        if window.event is not None:
            start = values[event_times(structure.events, structure.parts)[window.event]]
            for key in slew_times(structure.events, structure.parts):
                later = jnp.where(values[key] > start, values[key], jnp.inf)
                next_slew = jnp.minimum(next_slew, later)
        return cls(
            window,
            structure.wheels,
            None if window.mode is None else modes(structure.parts).index(window.mode),
            window.boresight or structure.boresight,
            own,
            start + own["from"],
            start + own["until"],
            # an end in the scenario replaces the default end
            jnp.where(jnp.isinf(own["until"]), next_slew, jnp.inf),
            values["run.control_period"],
            values["metrics.settled_angle"],
            values["metrics.settled_rate"],
        )

    def start(self) -> SeenWindow:
        """Initial values before the first sample."""
        zero, never = jnp.zeros(()), jnp.array(-jnp.inf)
        names = window_metrics(self.window, self.values, self.wheels, self.boresight)
        return SeenWindow(
            *(jnp.zeros((), dtype=int), jnp.array(False), zero, never, never),
            {
                name: never if _statistic(name) == "max" else zero
                for name in names
                if name != "settling"
            },
            at_rest(self._filter(), jnp.zeros(3)) if "jitter_above" in self.values else None,
            no_exposures() if "exposure" in self.values else None,
        )

    def __call__(self, seen: SeenWindow, sample: Sample, k: Any) -> tuple[SeenWindow, Scalar]:
        """Update with sample k; returns the values and the error, infinite outside the window."""
        time = sample.time
        start = 0.0 if self.mode is None else sample.mode.start
        begin = start + self.begin
        inside: Any = (time + TOLERANCE >= begin) & (time <= start + self.end + TOLERANCE)
        inside &= time + TOLERANCE < self.next_slew
        if self.mode is not None:
            inside &= sample.mode.number == self.mode
        entered = inside & ~seen.inside
        angle, line, signals = self._pointing(sample)
        band, exposures = seen.band, seen.exposures
        if band is not None:
            sections = self._filter()
            # the first sample starts the filter without a step
            band = jnp.where(k == 0, at_rest(sections, line), band)
            band, output = filtered(sections, band, line)
            signals["jitter"] = jnp.sqrt(output @ output)
        if exposures is not None:
            periods = jnp.round(self.values["exposure"] / self.period)
            exposures, signals["smear"] = exposed(exposures, line, inside, periods)
        rate = jnp.sqrt(sample.rate_error @ sample.rate_error)
        signals |= {"error_max": angle, "error_rms": angle, "error_end": angle}
        signals |= {"rate_error_max": rate, "rate_error_rms": rate}
        signals |= self._of_wheels(sample) | self._propellant(sample)
        settled = (angle < self.settled_angle) & (rate < self.settled_rate)
        before = jnp.where(entered, jnp.inf, seen.settled_from)
        settled_from = jnp.where(settled, jnp.minimum(before, time), jnp.inf)
        after = SeenWindow(
            samples=seen.samples + inside,
            inside=inside,
            since=jnp.where(entered, begin, seen.since),
            settled_from=jnp.where(inside, settled_from, seen.settled_from),
            settling=jnp.where(
                entered, jnp.maximum(seen.settling, seen.settled_from - seen.since), seen.settling
            ),
            statistics={
                name: jnp.where(inside, _updated(_statistic(name), old, signals[name]), old)
                for name, old in seen.statistics.items()
            },
            band=band,
            exposures=exposures,
        )
        return after, jnp.where(inside, angle, jnp.inf)

    def _pointing(self, sample: Sample) -> tuple[Scalar, Vector3, dict[str, Any]]:
        """Pointing error, the direction that jitter and smear evaluate, and signals of both.

        The direction is that of the boresight in axes of the reference; without a boresight it is
        the rotation vector of the error.
        """
        turn = error(sample.state.attitude, sample.reference.attitude)
        if self.boresight is None:
            return sample.error, rotation_vector(turn), {}
        axis = jnp.asarray(self.boresight)
        angle = sample.error
        if self.window.boresight is not None:
            angle = pointing_error(sample.state.attitude, sample.reference.attitude, self.boresight)
        # the error is a rotation about the boresight, followed by one that tilts it
        about = jnp.abs(2.0 * jnp.arctan2(turn[1:] @ axis, turn[0]))
        return angle, to_inertial(turn, axis), {"rotation_max": about, "rotation_rms": about}

    def _filter(self) -> Sections:
        """Sections of the jitter filter."""
        sections = high_pass(self.values["jitter_above"], self.period)
        if "jitter_below" in self.values:
            sections += low_pass(self.values["jitter_below"], self.period)
        return sections

    def _of_wheels(self, sample: Sample) -> dict[str, Any]:
        """Whether the speed of each wheel, and of any, is in the forbidden band."""
        if "dwell_below" not in self.values:
            return {}
        speed = jnp.abs(sample.state.wheel_speed)
        within = (speed >= self.values["dwell_above"]) & (speed <= self.values["dwell_below"])
        each = {f"dwell.{name}": within[i] for i, name in enumerate(self.wheels)}
        return {"dwell": jnp.any(within), **each}

    def _propellant(self, sample: Sample) -> dict[str, Any]:
        """Propellant in one control period, kg."""
        name = self.window.propellant
        if name is None:
            return {}
        known: dict[str, Any] = {}
        for part in (sample.record, sample.command):
            known |= part._asdict()
        if name not in known:
            raise InputError(
                f"key metrics.window[{self.window.name}].propellant: found {name!r}, expected a "
                f"signal of the command or of the record: {', '.join(known)}"
            )
        return {"propellant": jnp.sum(known[name]) * self.period}


def pointing_error(
    attitude: Quaternion, target: Quaternion, boresight: tuple[float, ...] | None
) -> Scalar:
    """Angle between the actual and the target direction of a boresight; None: full attitude."""
    if boresight is None:
        return error_angle(attitude, target)
    body = jnp.asarray(boresight)
    return angle_between(to_inertial(attitude, body), to_inertial(target, body))


def _statistic(name: str) -> str:
    return STATISTIC[name.split(".")[0]]


def _updated(statistic: str, old: Scalar, value: Scalar) -> Scalar:
    if statistic == "max":
        return jnp.maximum(old, value)
    if statistic == "last":
        return value
    return old + (value**2 if statistic == "rms" else value)


def concluded(seen: SeenWindow) -> dict[str, Vector]:
    """Metrics of a window, (runs,), except percentiles; NaN for a run without samples in it.

    Args:
        seen: Running values with a leading axis of runs, NumPy.
    """
    samples = np.maximum(seen.samples, 1)
    found: dict[str, Any] = {"settling": np.maximum(seen.settling, seen.settled_from - seen.since)}
    for name, value in seen.statistics.items():
        statistic = _statistic(name)
        value = value / samples if statistic in ("rms", "mean") else value
        found[name] = np.sqrt(value) if statistic == "rms" else value
    return {
        name: np.where((seen.samples > 0) & np.isfinite(value), value, np.nan)
        for name, value in found.items()
    }
