"""Friction from coasts without current, in one sense of rotation or over a record."""

from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.bench.coast import find_coasts
from gyrostat.identification.bench.methods import identify_dedicated
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.drifting_coast import drifting_coast
from gyrostat.telemetry import Record
from gyrostat.telemetry.record import CHANNELS
from gyrostat.telemetry.signals import runs

RESTING = 0.02
"""Current, relative to the largest, below which the motor counts as switched off."""
SHORTEST = 20
"""Smallest number of samples of a coast."""


@dataclass(frozen=True)
class Coasted:
    """Viscous and Coulomb friction of coasts.

    Attributes:
        values: Viscous coefficient, N·m·s/rad, and Coulomb torque, N·m, (2,).
        covariance: Covariance of their errors, (2, 2).
        inertia: Inertia, kg·m².
        scale: Relative sigma that all torques have in common.
        speed_scale: Relative sigma of the measured speeds.
        clock: Relative sigma of the measured times.
    """

    values: Vector
    covariance: Matrix
    inertia: float
    scale: float
    speed_scale: float = 0.0
    clock: float = 0.0

    def loss(self, speed: float) -> tuple[float, float]:
        """Friction torque at a speed of 0 or more, rad/s, and its sigma, N·m."""
        slope = np.array([speed, 1.0])
        torque = float(slope @ self.values)
        return torque, self._sigma(slope, torque)

    def time(self, speed: float) -> tuple[float, float]:
        """Time from a speed, rad/s, to rest, and its sigma, s: J/b ln(1 + b w/c)."""
        viscous, coulomb = self.values
        ratio = max(viscous, 1e-12 * coulomb / speed) * speed / coulomb
        time = self.inertia * speed / coulomb * np.log1p(ratio) / ratio
        by_coulomb = -self.inertia * speed / (coulomb**2 * (1.0 + ratio))
        by_viscous = (
            (self.inertia * speed / (coulomb * (1.0 + ratio)) - time) * speed / (coulomb * ratio)
        )
        slope = np.array([by_viscous, by_coulomb])
        # the ratio of torques to inertia is measured, without the error of the inertia; a scale
        # error of the speed changes c/J
        scales = np.hypot(by_coulomb * coulomb * self.speed_scale, time * self.clock)
        variance = max(float(slope @ self.covariance @ slope), 0.0)
        return float(time), float(np.hypot(np.sqrt(variance), scales))

    def _sigma(self, slope: Vector, value: float) -> float:
        variance = max(float(slope @ self.covariance @ slope), 0.0)
        return float(np.hypot(np.sqrt(variance), self.scale * value))


def coast_friction(sheet: BenchSheet, record: Record, *, drifts: bool = True) -> Coasted:
    """Viscous and Coulomb friction of all coasts of a record.

    Args:
        sheet: Spec sheet.
        record: Record.
        drifts: Whether friction drifts over the record, with the standard deviation that the sheet
            states.

    Raises:
        InputError: The record has no coast, or the fit is not valid.
    """
    inertia = sheet.value("inertia")
    options = {"model": None, "hold": {}, "speed_sigma": None}
    fit = identify_dedicated("coast", [record], inertia=inertia, **options)
    if not fit.converged:
        raise InputError(f"{record.name}: found no friction that fits the coasts, expected one")
    places = [fit.names.index(name) for name in ("viscous", "coulomb")]
    values, covariance = fit.values[places], fit.covariance[np.ix_(places, places)]
    if drifts and sheet.bench.drift > 0.0:
        coasts = find_coasts(record, fit.speed_sigma)
        first, last = record.time[[0, -1]].tolist()
        drifting = drifting_coast(coasts, first, last, values / inertia, sheet.bench.drift)
        if drifting is None:
            raise InputError(f"{record.name}: found no friction that fits the coasts, expected one")
        values, covariance = inertia * drifting[0], inertia**2 * drifting[1]
    scales = sheet.tolerances()
    scales = (scales.get("speed_scale", 0.0), scales.get("clock", 0.0))
    return Coasted(values, covariance, inertia, sheet.inertial_scale(), *scales)


def each_coast(record: Record) -> list[tuple[float, Record]]:
    """Parts of a record with one coast each: time of its start, s, and the part."""
    off = np.abs(record.current) <= RESTING * np.max(np.abs(record.current))
    speed = np.where(record.valid, record.speed, 0.0)
    turning = 0.05 * np.max(np.abs(speed))
    coasts = [
        (first, last)
        for first, last in runs(off)
        if last - first >= SHORTEST and abs(speed[first]) > turning
    ]
    parts, end = [], 0
    for first, last in coasts:
        start = (end + first) // 2
        stop = min(last + 1, len(record.time))
        parts.append((float(record.time[first]), part_of(record, slice(start, stop))))
        end = stop
    return parts


def part_of(record: Record, part: slice) -> Record:
    """Part of a record."""
    names = ("time", "current", "speed", "valid", *CHANNELS, "restart")
    series = {name: getattr(record, name) for name in names}
    return replace(record, **{n: None if s is None else s[part] for n, s in series.items()})
