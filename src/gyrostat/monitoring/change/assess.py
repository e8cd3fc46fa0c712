"""Health of the wheels from their window table: trend, changes, alarms and forecast."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.monitoring.change.channels import CHANNELS, Reference
from gyrostat.monitoring.change.detector import AlarmSettings, Detector, Verdict
from gyrostat.monitoring.change.forecast import Forecast, Series, forecast
from gyrostat.monitoring.wheel_data import REFERENCE_TEMPERATURE, KnownWheel
from gyrostat.monitoring.windows import Windows

DAY = 86400.0
MERGED = 14.0
"""Alarms less than this apart are one, days."""
HORIZON = np.unique(np.round(np.geomspace(1.0, 3653.0, 200), 1))
"""Days ahead that a forecast covers."""
FIRST = 10
"""Windows whose median is the reference where no nominal wheel is given."""


@dataclass(frozen=True, eq=False)
class Limit:
    """Limit of the friction torque.

    Attributes:
        torque: N·m.
        speed: Wheel speed at which the friction counts, rad/s; None: the wheel's median.
    """

    torque: float
    speed: float | None = None


@dataclass(frozen=True, eq=False)
class WheelHealth(Described):
    """Health of one wheel.

    Attributes:
        wheel: Name.
        start: Start of each window, (N,), s.
        level: Coulomb torque, viscous coefficient, motor constant and offset at 20 °C, from the
            windows so far, with the most probable change where an alarm stands, (N, 4), SI.
        level_sigma: Their standard deviations, (N, 4).
        verdicts: Verdict after each window.
        alarms: Windows in which an alarm began; alarms less than 14 days apart are one.
        speed: Speed at which the friction counts: the limit's, or the wheel's median, rad/s.
        friction: Friction torque at this speed and 20 °C, (N,), N·m; NaN where unknown.
        friction_sigma: Its standard deviation, (N,), N·m.
        limit: Limit of the friction torque, N·m; None without one.
        forecast: Time to the limit; None without a limit.
    """

    wheel: str
    start: Vector
    level: Vector
    level_sigma: Vector
    verdicts: tuple[Verdict, ...]
    alarms: tuple[int, ...]
    speed: float
    friction: Vector
    friction_sigma: Vector
    limit: float | None
    forecast: Forecast | None

    @property
    def alarm(self) -> bool:
        """Whether an alarm stands after the last window."""
        return bool(self.verdicts) and self.verdicts[-1].alarm

    @property
    def text(self) -> str:
        """One line on the alarm that stands; empty without one."""
        if not self.alarm:
            return ""
        _, low, high = self.verdicts[-1].onset or (0, 0, 0)
        return (
            f"{self.class_text}; began between {self._time(low):.0f} s and "
            f"{self._time(high) + DAY:.0f} s on the clock of the telemetry (90 %)"
        )

    @property
    def class_text(self) -> str:
        """Classes of the change after the last window, with their probabilities."""
        classes = self.verdicts[-1].classes
        if classes:
            return " or ".join(map(self._share, classes))
        return "of open class, most probable " + ", ".join(map(self._share, self._ordered[:3]))

    @property
    def probable(self) -> str:
        """Most probable class where an alarm stands; else empty."""
        return self._ordered[0] if self.alarm else ""

    @property
    def _ordered(self) -> list[str]:
        """Classes, the most probable ones first."""
        shares = self.verdicts[-1].probabilities
        return sorted((name for name in shares if name != "none"), key=lambda name: -shares[name])

    def _share(self, name: str) -> str:
        return f"{name} ({100.0 * self.verdicts[-1].probabilities[name]:.0f} %)"

    def as_json(self) -> dict[str, Any]:
        """Health as JSON; times are in s on the clock of the telemetry."""
        content: dict[str, Any] = {
            "wheel": self.wheel,
            "windows": len(self.verdicts),
            "alarm": self.alarm,
            "alarms": [float(self.start[k]) for k in self.alarms],
        }
        if self.verdicts:
            last = self.verdicts[-1]
            content |= {
                "log_odds": last.statistic,
                "probabilities": dict(last.probabilities),
                "classes": list(last.classes),
                "onset": None
                if last.onset is None
                else dict(zip(("start", "from", "to"), map(self._time, last.onset), strict=True)),
            }
        if self.forecast is not None:
            content["forecast"] = {
                "days_10": _finite(self.forecast.quantile(0.1)),
                "days_50": _finite(self.forecast.quantile(0.5)),
                "days_90": _finite(self.forecast.quantile(0.9)),
                "reached_within_a_year": float(
                    np.interp(365.25, self.forecast.days, self.forecast.reached)
                ),
            }
        return content

    def _time(self, window: int) -> float:
        return float(self.start[window])


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def reference_to(wheel: KnownWheel) -> Reference:
    """Reference of a wheel that is known beforehand."""
    return Reference(
        wheel.coulomb,
        wheel.viscous,
        wheel.motor_constant,
        wheel.offset,
        (wheel.sigma_of("viscous"), wheel.sigma_of("motor_constant"), wheel.sigma_of("offset")),
    )


def reference_of(windows: Windows) -> Reference:
    """Reference of a wheel that is not known beforehand: medians of its first valid windows.

    Args:
        windows: Windows of one wheel.
    """

    def median(name: str) -> float:
        values = windows[name][windows["valid"] & (windows[name] > 0.0)][:FIRST]
        return float(np.median(values)) if values.size else 1.0

    return Reference(median("coulomb"), median("viscous"), median("motor_constant"))


def assess(
    windows: Windows,
    settings: AlarmSettings | None = None,
    references: Mapping[str, Reference] | None = None,
    limits: Mapping[str, Limit] | None = None,
) -> list[WheelHealth]:
    """Health of every wheel of a window table.

    Args:
        windows: Window table.
        settings: Settings of alarm and classes.
        references: Wheel -> what the estimator knew beforehand.
        limits: Wheel -> limit of its friction.
    """
    healths = []
    for name in windows.wheels:
        table = windows.wheel(name)
        reference = (references or {}).get(name) or reference_of(table)
        detector = Detector(reference, settings or AlarmSettings())
        healths.append(assess_wheel(table, detector, (limits or {}).get(name)))
    return healths


def assess_wheel(windows: Windows, detector: Detector, limit: Limit | None = None) -> WheelHealth:
    """Health of one wheel.

    Args:
        windows: Its windows, in order of time.
        detector: Its detector, before the first window.
        limit: Limit of its friction; None: the friction at the mean speed, and no forecast.
    """
    reference = detector.reference
    scales = reference.scales()
    speeds = np.abs(windows["speed_mean"])
    usual = float(np.nanmedian(speeds)) if np.any(np.isfinite(speeds)) else 0.0
    speed = usual if limit is None or limit.speed is None else limit.speed
    unit = reference.coulomb + reference.viscous * speed
    weights = np.array([reference.coulomb, reference.viscous * speed]) / unit
    verdicts, level, sigma = [], [], []
    for k in range(len(windows)):
        row = {name: values[k] for name, values in windows.columns.items()}
        verdicts.append(detector.update(row))
        state = detector.changed(verdicts[-1])
        level.append((state.state[:4] + state.change[:4]) * scales)
        sigma.append(np.sqrt(np.diag(detector.levels.covariance)[:4]) * scales)
    # the temperature coefficients of today hold for the past too
    warm = detector.changed(verdicts[-1]).state[len(CHANNELS) :] if verdicts else np.zeros(2)
    friction, variance = _friction(windows, detector.reference, speed)
    cold = windows["temperature_mean"] - REFERENCE_TEMPERATURE
    friction -= np.where(np.isfinite(cold), cold, 0.0) * (warm @ weights)
    series = Series(
        friction,
        variance,
        np.diff(windows["start"], prepend=windows["start"][:1] - DAY) / DAY,
    )
    return WheelHealth(
        str(windows["wheel"][0]) if len(windows) else "",
        windows["start"],
        np.array(level).reshape(-1, 4),
        np.array(sigma).reshape(-1, 4),
        tuple(verdicts),
        episodes([v.alarm for v in verdicts], windows["start"]),
        speed,
        series.value * unit,
        np.sqrt(series.variance) * unit,
        None if limit is None else limit.torque,
        None
        if limit is None
        else forecast(series, verdicts[-1].onset or (), limit.torque / unit, HORIZON),
    )


def _friction(windows: Windows, reference: Reference, speed: float) -> tuple[Vector, Vector]:
    """Friction torque at a speed in each window, relative to the reference, and its variance."""
    unit = reference.coulomb + reference.viscous * speed
    value = windows["coulomb"] + speed * windows["viscous"]
    variance = (
        windows["coulomb_sigma"] ** 2
        + (speed * windows["viscous_sigma"]) ** 2
        + 2.0 * speed * windows["cov_coulomb_viscous"]
    )
    value = np.where(windows["valid"], value, np.nan)
    return value / unit, variance / unit**2


def episodes(alarms: list[bool], start: Vector) -> tuple[int, ...]:
    """Windows in which an alarm begins; alarms less than 14 days apart are one.

    Args:
        alarms: Whether the alarm stands after each window.
        start: Start of each window, s.
    """
    begin: list[int] = []
    last = -np.inf
    for k in np.flatnonzero(alarms):
        if start[k] - last > MERGED * DAY:
            begin.append(int(k))
        last = start[k]
    return tuple(begin)
