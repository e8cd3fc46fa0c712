"""Spectrum of a torque over time, and its waterfall over speed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.plateaus import mean_sigma

MEAN_SQUARE_OF_HANN = 0.375
"""Mean square of the Hann window, by which its spectra are divided."""


@dataclass(frozen=True)
class Spectrum:
    """One-sided power spectral density, and those of its segments.

    Attributes:
        frequency: Frequencies, (f,), Hz.
        density: Mean density, (f,), unit²/Hz; its sum times the interval of the frequencies is the
            mean square of the signal (Parseval).
        rows: Density of each segment, (s, f), unit²/Hz.
        centres: Index of the middle sample of each segment, (s,).
    """

    frequency: Vector
    density: Vector
    rows: Matrix
    centres: NDArray[np.intp]

    def rms(self, low: float, high: float) -> tuple[float, float]:
        """Root mean square in a band, and its sigma.

        The power of each segment in the band is one repetition; the correlation of neighbours, of
        which those that overlap by half have a little (Welch 1967), is taken into account.

        Args:
            low: Lower end, Hz.
            high: Upper end, Hz.
        """
        band = (self.frequency >= low) & (self.frequency <= high)
        powers = self.rows[:, band].sum(axis=1) * (self.frequency[1] - self.frequency[0])
        mean = float(powers.mean())
        value = np.sqrt(mean)
        if len(powers) < 2 or value == 0.0:
            return float(value), float(value)
        return float(value), 0.5 * mean_sigma(powers, None) / float(value)


def spectrum(signal: Vector, rate: float, length: int) -> Spectrum:
    """Welch's spectrum: segments that overlap by half, each without its mean and line.

    Args:
        signal: Samples, (N,), evenly spaced.
        rate: Samples per second, Hz.
        length: Samples in a segment, at most N.
    """
    step = max(length // 2, 1)
    starts = np.arange(0, len(signal) - length + 1, step)
    window = np.sin(np.pi * (np.arange(length) + 0.5) / length) ** 2
    place = np.linspace(-1.0, 1.0, length)
    segments = signal[starts[:, None] + np.arange(length)]
    segments = segments - segments.mean(axis=1, keepdims=True)
    segments = segments - np.outer(segments @ place / (place @ place), place)
    power = np.abs(np.fft.rfft(segments * window, axis=1)) ** 2
    power *= 2.0 / (rate * length * MEAN_SQUARE_OF_HANN)
    power[:, 0] *= 0.5
    if length % 2 == 0:
        power[:, -1] *= 0.5
    frequency = np.arange(power.shape[1]) * (rate / length)
    return Spectrum(frequency, power.mean(axis=0), power, starts + length // 2)
