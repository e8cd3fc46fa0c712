"""Measured waterfall: densities of the loads of a wheel over speed and frequency."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.signal import get_window

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.model import KINDS, LOADS

LARGEST_HALF_WIDTH = 8
"""Largest half width of a line, bins, with which harmonics can be told apart."""
CAPTURED = 0.999
"""Share of the power of a line within its half width."""
UNEVEN = 1e-3
"""Largest deviation of a frequency from an even grid, in its steps."""


@dataclass(frozen=True)
class Window:
    """What the window of the spectra does to a line and to a smooth density.

    Attributes:
        name: Name of the window in `scipy.signal.get_window`.
        half_width: Bins to either side of the nearest bin that have 99.9 % of a line.
        kernel: Weights with which a density is averaged over neighbouring bins, (2 m + 1,).
        noise_bandwidth: Equivalent noise bandwidth, bins.
        leak: Largest share of the power of a line in one bin at n bins or more from it, (n,).
    """

    name: str
    half_width: int
    kernel: Vector
    noise_bandwidth: float
    leak: Vector

    @classmethod
    def named(cls, name: str) -> "Window":
        """Window of SciPy by its name.

        Raises:
            InputError: There is none, or its lines are too wide.
        """
        samples, fine = 512, 32
        try:
            values: Any = get_window(name, samples)
        except (ValueError, TypeError, KeyError):
            raise InputError(f"--window: found {name!r}, expected hann, flattop or such") from None
        power = np.abs(np.fft.fft(values, samples * fine)) ** 2 / (samples * np.sum(values**2))
        reach = 64
        worst = [power[fine * n - fine // 2] for n in range(1, reach)]
        bins = power[fine // 2 :: fine]  # a line half way between two bins
        captured = [float(2.0 * bins[:n].sum()) for n in range(1, LARGEST_HALF_WIDTH + 1)]
        enough = [n for n, share in enumerate(captured, 1) if share >= CAPTURED]
        if not enough:
            raise InputError(
                f"--window: found {name!r}, whose lines are wider than {LARGEST_HALF_WIDTH} bins, "
                "expected a window such as hann"
            )
        kernel = power[: fine * (enough[0] + 1) : fine]
        kernel = np.concatenate([kernel[:0:-1], kernel])
        leak = np.maximum.accumulate(np.array([1.0, *worst])[::-1])[::-1]
        bandwidth = samples * float(np.sum(values**2) / np.sum(values) ** 2)
        return cls(name, enough[0], kernel / kernel.sum(), bandwidth, leak)

    def mask_width(self, excess: Vector) -> Any:
        """Bins to either side in which a line adds more than 1 % to the density around it.

        Args:
            excess: Power of the line over the power of the density in a bin.
        """
        far = np.searchsorted(-self.leak, -0.01 / np.maximum(excess, 1e-9))
        return np.clip(far, self.half_width, len(self.leak) - 1)


@dataclass(frozen=True, eq=False)
class Waterfall:
    """Densities of the loads of a wheel.

    Attributes:
        name: Name of the measurement.
        speed: Wheel speeds, increasing, (S,), rad/s.
        frequency: Frequencies at equal steps, (F,), Hz.
        density: Load -> one-sided density, (S, F), N²/Hz or (N·m)²/Hz.
        window: Window of the spectra.

    Raises:
        InputError: A shape, a step or a number cannot be used.
    """

    name: str
    speed: Vector
    frequency: Vector
    density: Mapping[str, Matrix]
    window: Window

    def __post_init__(self):
        shape = (len(self.speed), len(self.frequency))
        if not self.density:
            raise InputError(f"{self.name}: found no load, expected some of {', '.join(LOADS)}")
        if shape[0] < 2 or shape[1] < 16:
            raise InputError(
                f"{self.name}: found {shape[0]} speeds and {shape[1]} frequencies, expected at "
                "least 2 and 16"
            )
        if np.any(np.diff(self.speed) <= 0.0) or self.speed[0] <= 0.0:
            raise InputError(f"{self.name}: speed: expected different speeds above 0")
        steps = np.diff(self.frequency)
        if self.frequency[0] < 0.0 or np.ptp(steps) > UNEVEN * abs(float(steps.mean())):
            raise InputError(
                f"{self.name}: frequency: found steps of {steps.min():.6g} to {steps.max():.6g} Hz,"
                " expected frequencies of 0 or more at equal steps"
            )
        for load, values in self.density.items():
            if load not in LOADS or np.shape(values) != shape:
                raise InputError(
                    f"{self.name}: {load}: found shape {np.shape(values)}, expected one of "
                    f"{', '.join(LOADS)} with {shape}"
                )
            bad = ~np.isfinite(values) | (values < 0.0)
            if bad.any():
                row, column = (int(k) for k in np.argwhere(bad)[0])
                raise InputError(
                    f"{self.name}: {load} at {self.speed[row]:.5g} rad/s and "
                    f"{self.frequency[column]:.5g} Hz: found {values[row, column]}, expected a "
                    "density of 0 or more"
                )

    @property
    def step(self) -> float:
        """Step of the frequencies, Hz."""
        return float(self.frequency[-1] - self.frequency[0]) / (len(self.frequency) - 1)

    @cached_property
    def kinds(self) -> dict[str, tuple[Matrix, int]]:
        """Kind of load -> mean density of its measured loads, (S, F), and their number."""
        found = {}
        for kind, loads in KINDS.items():
            parts = [self.density[load] for load in loads if load in self.density]
            if parts:
                found[kind] = (np.mean(parts, axis=0), len(parts))
        return found
