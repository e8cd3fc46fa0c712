"""Equation of motion in weak form: averages over windows, without derivatives of measured signals.

The equation J dw/dt = k_m I - F(w) is multiplied by a smooth window p(t) and integrated. By parts,
the acceleration becomes -∫ p'(t) w(t) dt, so that the speed is not differentiated, and torque and
all regressors pass the same low-pass filter (the parallel filter of Gautier, Janot and Vandanjon
2013). The window is linear between samples: with a held current and mean speeds of the intervals,
the terms of inertia and current are then exact.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.drive.motion import Drive, Motion
from gyrostat.identification.fit.friction_torques import friction_torques
from gyrostat.wheel.friction import Friction

CUTOFF = 0.40
"""Frequency, times the half-width of the window, at which its power response is one half."""
HOPS = 2
"""Windows per half-width."""


def _window(x: Vector) -> Vector:
    """Window 35/32 (1 - x²)³ on [-1, 1], whose integral is 1."""
    return 35.0 / 32.0 * (1.0 - np.clip(x, -1.0, 1.0) ** 2) ** 3


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows over a segment, as matrices that act on values of its n sample intervals.

    Attributes:
        mean: Weights of the mean over each window, (m, n).
        slope: Weights of the mean speeds that give the mean acceleration, (m, n), 1/s.
        touched: Whether an interval is in a window, (m, n), 0 or 1.
    """

    mean: csr_array
    slope: csr_array
    touched: csr_array

    @classmethod
    def over(cls, time: Vector, half_width: float) -> "Windows":
        """Windows at equal distances.

        Args:
            time: Sample times, (n + 1,), s.
            half_width: Half of the width of a window, s.
        """
        first, last = float(time[0]) + half_width, float(time[-1]) - half_width
        centres = np.arange(first, last + 1e-9 * half_width, half_width / HOPS)
        low = np.searchsorted(time, centres - half_width, "right") - 1
        high = np.searchsorted(time, centres + half_width, "left")
        low, high = np.maximum(low, 0), np.minimum(high, len(time) - 1)
        starts = np.concatenate([[0], np.cumsum(high - low)])
        mean, slope = np.zeros(starts[-1]), np.zeros(starts[-1])
        column = np.zeros(starts[-1], dtype=np.int64)
        for k, centre in enumerate(centres):
            nodes = slice(low[k], high[k] + 1)
            value = _window((time[nodes] - centre) / half_width) / half_width
            part = slice(starts[k], starts[k + 1])
            mean[part] = 0.5 * (value[1:] + value[:-1]) * np.diff(time[nodes])
            slope[part] = -np.diff(value)
            column[part] = np.arange(low[k], high[k])
        shape = (len(centres), len(time) - 1)
        matrices = [
            csr_array((data, column, starts), shape=shape)
            for data in (mean, slope, np.ones_like(mean))
        ]
        return cls(*matrices)


def friction_columns(law: type[Friction], values: dict[str, float], motion: Motion) -> Matrix:
    """Mean derivatives of the friction over each interval by the parameters of its law, (n, p).

    In an interval with a crossing, the two senses have the shares of a linear speed.
    """
    each = friction_torques(law, values, motion.speed).by_parameters
    size = np.abs(motion.speed)
    total = size[1:] + size[:-1]
    crossing = motion.speed[1:] * motion.speed[:-1] < 0.0
    share = np.where(crossing, size[:-1] / np.where(total > 0.0, total, 1.0), 0.5)[:, None]
    return share * each[:-1] + (1.0 - share) * each[1:]


@dataclass(frozen=True, eq=False)
class Rows:
    """Terms of the equation of motion in m windows.

    Attributes:
        current: Current, (m,), A.
        acceleration: Acceleration, (m,), rad/s².
        friction: Derivatives of the friction by the parameters of its law, (m, p).
    """

    current: Vector
    acceleration: Vector
    friction: Matrix

    def at(self, index) -> "Rows":
        """Rows at some windows."""
        return Rows(self.current[index], self.acceleration[index], self.friction[index])


def rows_of(
    drive: Drive, windows: Windows, motion: Motion, law: type[Friction], values: dict[str, float]
) -> Rows:
    """Terms of the equation of motion in the windows of a segment.

    Args:
        drive: Segment.
        windows: Its windows.
        motion: Motion, measured or predicted.
        law: Friction law.
        values: Name -> value of its parameters, SI.
    """
    return Rows(
        windows.mean @ drive.current,
        windows.slope @ motion.mean_speed,
        windows.mean @ friction_columns(law, values, motion),
    )
