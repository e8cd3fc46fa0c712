"""Series that pictures of a flying wheel show: means over bins of windows."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import RPM
from gyrostat.monitoring.agreement import OBSERVABLE
from gyrostat.monitoring.change.assess import WheelHealth
from gyrostat.monitoring.windows import REGRESSED, Windows

DAY = 86400.0
YEAR = 365.25
MANY_DAYS = 1100.0
"""Longest time whose unit is the day."""
BINS = 90
"""Largest number of bins; a longer history has bins of several windows."""
ROWS = 24
"""Number of speeds of the friction surface."""
FIRST = 10
"""Number of windows whose mean friction is the start of the surface."""
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Trend:
    """Estimates of one parameter in bins of windows.

    Attributes:
        value: Mean of the estimates that are observable, (B,); NaN without one.
        sigma: Their mean standard deviation, that of one window, (B,).
        unknown: Whether most windows of the bin do not determine it, (B,).
    """

    value: Vector
    sigma: Vector
    unknown: Mask


@dataclass(frozen=True, eq=False)
class WheelSeries:
    """History of one wheel in bins of windows.

    Attributes:
        edges: Limits of the bins since the start of the first window, (B + 1,), in `unit`.
        unit: "d" or "years".
        per_bin: Number of windows that a bin spans.
        trends: Parameter -> estimates.
        level: Parameter -> level at 20 °C and its standard deviation, each (B,).
        friction: Friction torque at the speed of the limit and 20 °C, N·m.
        statistic: Log of the alarm statistic, the largest of a bin, (B,).
        speeds: Limits of the speeds of the surface, (R + 1,), rpm.
        change: Friction torque over that of the first windows less 1, (R, B); NaN where unknown.
        unsteady: Whether the windows of a bin are not valid or do not determine friction, (B,).
    """

    edges: Vector
    unit: str
    per_bin: int
    trends: dict[str, Trend]
    level: dict[str, tuple[Vector, Vector]]
    friction: Trend
    statistic: Vector
    speeds: Vector
    change: Matrix
    unsteady: Mask

    @property
    def middle(self) -> Vector:
        """Middle of each bin, (B,)."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])


@dataclass(frozen=True, eq=False)
class _Bins:
    """Windows in bins.

    Attributes:
        number: Bin of each window, (N,).
        count: Number of bins.
    """

    number: NDArray[np.int64]
    count: int

    def mean(self, values: Vector, used: Mask) -> Vector:
        """Mean of the used values of each bin; NaN without one."""
        total = np.bincount(self.number[used], values[used], self.count)
        count = np.bincount(self.number[used], minlength=self.count)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    def mostly(self, flags: Mask) -> Mask:
        """Whether more than half of the windows of a bin have a flag."""
        count = np.bincount(self.number, minlength=self.count)
        return np.bincount(self.number[flags], minlength=self.count) > 0.5 * count

    def trend(self, value: Vector, sigma: Vector, used: Mask) -> Trend:
        """Estimates in bins."""
        used = used & np.isfinite(value) & np.isfinite(sigma)
        return Trend(self.mean(value, used), self.mean(sigma, used), self.mostly(~used))


def wheel_series(windows: Windows, health: WheelHealth, most: int = BINS) -> WheelSeries:
    """History of one wheel for its pictures.

    Args:
        windows: Windows of the wheel, in order of time; at least one.
        health: Its health.
        most: Largest number of bins.
    """
    start, length = windows["start"], float(np.median(windows["end"] - windows["start"]))
    place = np.round((start - start[0]) / length).astype(np.int64)
    per_bin = -(-int(place[-1] + 1) // most)
    bins = _Bins(place // per_bin, int(place[-1] // per_bin) + 1)
    days = np.arange(bins.count + 1.0) * (per_bin * length / DAY)
    is_long = float(days[-1]) > MANY_DAYS
    valid = windows["valid"]
    every = np.ones(len(windows), bool)
    speeds, change, unsteady = _surface(windows, bins)
    statistic = np.full(bins.count, -np.inf)
    np.maximum.at(statistic, bins.number, [verdict.statistic for verdict in health.verdicts])
    return WheelSeries(
        days / YEAR if is_long else days,
        "years" if is_long else "d",
        per_bin,
        {
            name: bins.trend(
                windows[name], windows[f"{name}_sigma"], valid & windows[f"{name}_observable"]
            )
            for name in REGRESSED
        },
        {
            name: (bins.mean(health.level[:, k], every), bins.mean(health.level_sigma[:, k], every))
            for k, name in enumerate(REGRESSED)
        },
        bins.trend(health.friction, health.friction_sigma, valid),
        np.where(np.isfinite(statistic), statistic, np.nan),
        speeds / RPM,
        change,
        unsteady,
    )


def _surface(windows: Windows, bins: _Bins) -> tuple[Vector, Matrix, Mask]:
    """Limits of the speeds, rad/s, change of the friction in each cell, and bins without it."""
    used = windows["valid"] & np.isfinite(windows["speed_min"])
    if not used.any():
        return np.array([0.0, 1.0]), np.full((1, bins.count), np.nan), np.ones(bins.count, bool)
    low, high = float(windows["speed_min"][used].min()), float(windows["speed_max"][used].max())
    room = max(0.02 * (high - low), 1e-3 * max(abs(low), abs(high)), RPM)
    speeds = np.linspace(low - room, high + room, ROWS + 1)
    middle, half = 0.5 * (speeds[1:] + speeds[:-1]), 0.5 * (speeds[1] - speeds[0])
    torque, sigma = _torque(windows, middle)
    started = np.flatnonzero(used)[:FIRST]
    begin = torque[:, started].mean(axis=1, keepdims=True)
    told = used & (sigma < OBSERVABLE * np.abs(torque))
    flown = (middle[:, None] > windows["speed_min"] - half) & (
        middle[:, None] < windows["speed_max"] + half
    )
    change = np.array(
        [
            bins.mean(relative, cells)
            for relative, cells in zip(torque / begin - 1.0, told & flown, strict=True)
        ]
    )
    return speeds, change, bins.mostly(~(told & flown).any(axis=0))


def _torque(windows: Windows, speed: Vector) -> tuple[Matrix, Matrix]:
    """Friction torque against the motion at each speed in each window, and its sigma, (R, N)."""
    sign, fast = np.sign(speed)[:, None], np.abs(speed)[:, None]
    weights: dict[str, Any] = {"coulomb": 1.0, "viscous": fast, "offset": sign}
    torque = np.zeros((speed.size, len(windows)))
    variance = np.zeros_like(torque)
    for name, weight in weights.items():
        torque += weight * windows[name]
        variance += (weight * windows[f"{name}_sigma"]) ** 2
    for first, second in (("coulomb", "viscous"), ("coulomb", "offset"), ("viscous", "offset")):
        covariance = windows[f"cov_{first}_{second}"]
        variance += 2.0 * weights[first] * weights[second] * covariance
    return torque, np.sqrt(np.maximum(variance, 0.0))
