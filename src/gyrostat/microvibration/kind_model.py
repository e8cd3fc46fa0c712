"""Expected densities and line powers of one kind of load, and their variances.

Parameters are a vector: floor, noise, exponent, ln frequency, ln damping, inertia ratio, then the
squares of the forward coefficients of all harmonics and those of the backward ones. Densities are
means over the one or two loads of the kind. With two, x + iy has the densities Z+ at w and Z- at
-w; their mean (Z+ + Z-) / 2 is what is measured, and its relative variance is that of one spectrum
times (Z+² + Z-²) / (Z+ + Z-)².
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import convolve1d

from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.lines import Lines
from gyrostat.microvibration.model import TWO_PI, Mode
from gyrostat.microvibration.waterfall import Waterfall

SHAPE = ("floor", "noise", "exponent", "frequency", "damping", "inertia_ratio")
"""Parameters of the density, in the order of the vector."""


@dataclass(frozen=True, eq=False)
class KindModel:
    """Model of one kind of load.

    Attributes:
        waterfall: Measured waterfall.
        density: Mean density, (S, F), N²/Hz or (N·m)²/Hz.
        loads: Number of measured loads, 1 or 2.
        used: 1 where a bin belongs to no line, (S, F).
        numbers: Numbers of the harmonics, (H,).
        has_mode: Whether there is a structural mode.
        is_gyroscopic: Whether the mode is that of a tilt, which the speed splits.
    """

    waterfall: Waterfall
    density: Matrix
    loads: int
    used: Matrix
    numbers: Vector
    has_mode: bool
    is_gyroscopic: bool

    def mode(self, values: Vector) -> Mode | None:
        """Mode of the parameters."""
        if not self.has_mode:
            return None
        frequency, damping = np.exp(values[3:5])
        return Mode(float(frequency), float(damping), float(values[5]))

    def gains(self, values: Vector, frequency: Any, speed: Any) -> tuple[Any, Any]:
        """Squared gains at a frequency in Hz, forward and backward."""
        mode = self.mode(values)
        if mode is None:
            one = np.ones(np.broadcast(frequency, speed).shape)
            return one, one
        w = TWO_PI * frequency
        forward = mode.power_gain(w, speed)
        return forward, forward if mode.inertia_ratio == 0.0 else mode.power_gain(-w, speed)

    def noise(self, values: Vector, frequency: Any, speed: Any) -> tuple[Any, Any]:
        """Densities of x + iy at a frequency in Hz and its negative."""
        level = values[1] * (speed / self.waterfall.speed[-1]) ** values[2]
        return tuple(values[0] + level * gain for gain in self.gains(values, frequency, speed))

    def background(self, values: Vector) -> tuple[Matrix, Matrix]:
        """Density without lines as the window shows it, and its relative variance, (S, F) each."""
        speed = self.waterfall.speed[:, None]
        forward, backward = self.noise(values, self.waterfall.frequency[None], speed)
        total = forward + backward
        kernel = self.waterfall.window.kernel
        shown = convolve1d(0.5 * total, kernel, axis=1, mode="nearest")
        if self.loads == 2:
            return shown, (forward**2 + backward**2) / total**2
        return shown, np.ones_like(total)

    def level_slopes(self, values: Vector) -> tuple[Matrix, Matrix, Matrix]:
        """Derivatives of the shown density by floor, noise and exponent, (S, F) each."""
        unit = values.copy()
        unit[:2] = 0.0, 1.0
        shape = self.background(unit)[0]
        logarithm = np.log(self.waterfall.speed / self.waterfall.speed[-1])[:, None]
        return np.ones_like(shape), shape, values[1] * logarithm * shape

    def line_gains(self, values: Vector) -> tuple[Matrix, Matrix]:
        """Power of each line for squared coefficients of 1, forward and backward, (H, S)."""
        speed = self.waterfall.speed
        frequency = self.numbers[:, None] * speed / TWO_PI
        forward, backward = self.gains(values, frequency, speed)
        return 0.5 * speed**4 * forward, 0.5 * speed**4 * backward

    def powers(self, values: Vector) -> tuple[Matrix, Matrix]:
        """Power of each line in its forward and its backward part, (H, S)."""
        forward, backward = np.split(values[len(SHAPE) :, None], 2)
        gains = self.line_gains(values)
        return forward * gains[0], backward * gains[1]

    def power_variance(self, values: Vector, lines: Lines, spread: float) -> Matrix:
        """Variance of the measured power of each line, (H, S).

        Args:
            values: Parameters.
            lines: Measured lines.
            spread: Relative variance of the density times its correlated bins.
        """
        speed = self.waterfall.speed
        frequency = self.numbers[:, None] * speed / TWO_PI
        ahead, behind = (
            lines.floor * part for part in self.noise(values, frequency, speed + 0.0 * frequency)
        )
        forward, backward = self.powers(values)
        step = self.waterfall.step
        bins = 2 * self.waterfall.window.half_width + 1
        band = step * bins * (1.0 + bins / lines.flank)
        if self.loads == 2:
            total = forward * ahead + backward * behind + 0.25 * band * (ahead**2 + behind**2)
        else:
            middle = 0.5 * (ahead + behind)
            total = 2.0 * (forward + backward) * middle + band * middle**2
        return spread * step * total
