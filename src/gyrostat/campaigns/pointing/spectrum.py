r"""Pointing indices of a stationary error from its spectrum: transfer functions of the windows.

For a linear system the spectral density of the error is known without a simulation. An index is a
linear function of the error, with the squared gain (frequency f, window T, stability time S, and
sinc(x) = sin(pi x) / (pi x)):

    APE, AKE      1
    MPE, MKE      sinc(f T)^2
    RPE, RKE      any:     1 - sinc(f T)^2
                  centre:  (1 - sinc(f T))^2
                  end:     1 - 2 cos(pi f T) sinc(f T) + sinc(f T)^2
    PDE           4 sin(pi f S)^2 sinc(f T)^2
    PRE           2 sinc(f T)^2, without correlation between observation periods

ESSB-HB-E-003, "ESA pointing error engineering handbook", 2011. The level of a stationary error is
that of the mixed interpretation, and of the temporal one if all runs have the same spectrum; an
ensemble interpretation, at all times, does not follow from a spectrum alone.
"""

from typing import cast

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.scenario.requirement import AXES_OF_ERROR, Requirement

_PLACES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
"""Places in a window, -1 to 1, and their weights, for a time anywhere in it."""


def window_gain(requirement: Requirement, frequency: Vector) -> Vector:
    """Squared gain from the error to the index of a requirement.

    Args:
        requirement: Requirement; its index, times and instant are used.
        frequency: Frequency, Hz, (frequencies,).
    """
    # the sinc of NumPy has the factor pi
    mean = np.sinc(frequency * requirement.window)
    if requirement.operation == "mean":
        return mean**2
    if requirement.operation == "relative":
        if requirement.instant == "any":
            return 1.0 - mean**2
        return _relative_gain(requirement, frequency, float(requirement.instant == "end"))
    if requirement.operation == "drift":
        return 4.0 * np.sin(np.pi * frequency * requirement.stability) ** 2 * mean**2
    return 2.0 * mean**2 if requirement.operation == "reproducibility" else np.ones_like(mean)


def _relative_gain(requirement: Requirement, frequency: Vector, position: float) -> Vector:
    """Squared gain to the error relative to the mean, at a position from -1 (start) to 1 (end)."""
    mean = np.sinc(frequency * requirement.window)
    turn = np.cos(np.pi * frequency * requirement.window * position)
    return 1.0 - 2.0 * turn * mean + mean**2


def size_from_spectrum(
    requirement: Requirement, frequency: Vector, density: NDArray[np.float64]
) -> float:
    """Size of an index that a stationary normal error without mean does not exceed at the level.

    Args:
        requirement: Requirement; its required value is not used.
        frequency: Frequencies, Hz, rising, (frequencies,). The integral over them is by the
            trapezoidal rule: they must resolve the spectrum and the inverse of its times.
        density: One-sided spectral densities, rad²/Hz, (frequencies,) for one axis, or (2,
            frequencies) for the two uncorrelated axes of a half cone.

    Raises:
        InputError: The spectrum has not the axes of the requirement, or is not a spectrum.
    """
    frequency, rows = np.asarray(frequency), np.atleast_2d(density)
    expected = 2 if requirement.axis == "half_cone" else 1
    if requirement.axis == "full" or rows.shape != (expected, len(frequency)):
        raise InputError(
            f"spectrum of {requirement.name}: found the shape {np.shape(density)} for the axis "
            f"{requirement.axis}, expected one row for {', '.join(AXES_OF_ERROR[:3])} and about, "
            "two for half_cone"
        )
    rising = np.all(np.diff(frequency) > 0.0) and frequency[0] >= 0.0
    if not rising or not np.all(rows >= 0.0) or not np.all(np.isfinite(rows)):
        raise InputError(
            f"spectrum of {requirement.name}: found negative or unordered numbers, expected rising "
            "frequencies and densities of 0 or more"
        )
    if requirement.operation == "relative" and requirement.instant == "any":
        # normal at each position in the window, with another variance
        gains = [_relative_gain(requirement, frequency, position) for position in _PLACES]
        weights = 0.5 * _WEIGHTS
    else:
        gains, weights = [window_gain(requirement, frequency)], np.ones(1)
    sigmas = np.sqrt([np.trapezoid(rows * gain, frequency, axis=1) for gain in gains])
    largest = float(np.max(sigmas))
    if largest == 0.0:
        return 0.0

    from scipy.optimize import brentq  # slow to import

    def beyond(size: float) -> float:
        shares = [_share_within(size, *ratios.tolist()) for ratios in sigmas / largest]
        return float(weights @ shares) - requirement.level

    # two equal components have the largest quantile
    most = float(np.sqrt(-2.0 * np.log1p(-requirement.level)))
    return largest * float(cast(float, brentq(beyond, 0.0, 1.001 * most, xtol=1e-13)))


def _share_within(size: float, first: float, second: float = 0.0) -> float:
    """Probability that two independent normal components are within a circle.

    R. S. Hoyt, "Probability functions for the modulus and angle of the normal complex variate",
    1947. One component: a normal distribution.
    """
    from scipy.integrate import quad  # slow to import
    from scipy.special import erf, ive

    large, small = max(first, second), min(first, second)
    if small < 1e-9 * large or large == 0.0:
        return float(erf(size / large / np.sqrt(2.0))) if large > 0.0 else 1.0
    ratio = small / large

    def density(radius: float) -> float:
        # in units of the larger standard deviation; ive is scaled by exp(-|x|)
        mean, half = 0.25 * (1.0 / ratio**2 + 1.0), 0.25 * (1.0 / ratio**2 - 1.0)
        return radius / ratio * np.exp((half - mean) * radius**2) * ive(0, half * radius**2)

    return float(quad(density, 0.0, size / large, epsabs=1e-13, limit=200)[0])
