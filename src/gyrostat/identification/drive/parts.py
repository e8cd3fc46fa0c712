"""Segments of records with their windows."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.motion import Drive, Motion, smoothed
from gyrostat.identification.drive.weak_form import CUTOFF, Rows, Windows, rows_of
from gyrostat.identification.read.statistics import noise_level

POWER = 0.95
"""Share of the power of the predicted acceleration that defines its bandwidth."""
ABOVE = 10.0
"""Cutoff of the windows over this bandwidth."""
SMOOTHING = 4
"""Width of a window over that of the parabola whose speed gives the sense of rotation."""
NARROWEST, WIDEST = 3, 0.02
"""Half-width of a window: smallest in sample intervals, largest as a fraction of the record."""
SLOWEST = 1e-3
"""Speed, relative to the largest one, below which the drive may rest."""


@dataclass(frozen=True, eq=False)
class Part:
    """Segment with its windows.

    Attributes:
        drive: Segment.
        windows: Windows.
        used: Indices of the windows that are used, (m,).
        weight: Weight of its rows: one over the rms torque error of its record.
    """

    drive: Drive
    windows: Windows
    used: NDArray[np.intp]
    weight: float = 1.0

    def rows(self, equation: Equation, motion: Motion) -> Rows:
        """Terms of the equation of motion in the windows that are used."""
        rows = rows_of(self.drive, self.windows, motion, equation.law, equation.start())
        return rows.at(self.used)


def half_width(drive: Drive, predicted: Motion) -> float:
    """Half-width of the windows, s, from the bandwidth of the predicted acceleration."""
    interval = drive.interval
    acceleration = np.diff(predicted.mean_speed)
    power = np.cumsum(np.abs(np.fft.rfft(acceleration)) ** 2)
    edge = int(np.searchsorted(power, POWER * power[-1]))
    frequency = max(edge, 1) / (len(acceleration) * interval)
    width = CUTOFF / (ABOVE * frequency)
    return max(min(width, WIDEST * float(np.ptp(drive.time))), NARROWEST * interval)


def part_of(drive: Drive, width: float) -> Part:
    """Segment with its windows; those with missing samples, a crossing or rest are not used.

    The sense of rotation is not clear there, and the friction at rest is not that of the law.
    """
    samples = max(round(2.0 * width / SMOOTHING / drive.interval), 1)
    mean_speed = drive.measured.mean_speed
    drive = replace(drive, measured=Motion(mean_speed, smoothed(mean_speed, samples)))
    noise = noise_level(mean_speed) * 1.5 / np.sqrt(samples)
    edge = max(4.0 * noise, SLOWEST * float(np.max(np.abs(mean_speed))))
    slow = np.abs(drive.measured.speed) <= edge
    unclear = slow[1:] | slow[:-1] | (drive.measured.speed[1:] * drive.measured.speed[:-1] < 0.0)
    windows = Windows.over(drive.time, width)
    unused = windows.touched @ (unclear | ~drive.present).astype(float)
    return Part(drive, windows, np.flatnonzero(unused == 0.0))
