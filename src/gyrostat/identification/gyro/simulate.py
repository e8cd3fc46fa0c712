"""Simulated records of a gyro at rest."""

from collections.abc import Mapping

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.identification.gyro.noise import mean_rate_covariance
from gyrostat.identification.gyro.parameters import PARAMETERS


def simulated_rates(
    parameters: Mapping[str, float], count: int, interval: float, generator: np.random.Generator
) -> Vector:
    """Simulate mean rates over equal intervals, (count,), rad/s.

    Each kind of noise has its exact distribution, flicker noise by circulant embedding of its
    differences (R. B. Davies and D. S. Harte, "Tests for Hurst effect", Biometrika 74, 1987).

    Args:
        parameters: Name of a parameter, as in `PARAMETERS` -> its value, SI units; others are 0.
        count: Number of rates.
        interval: Interval, s.
        generator: Source of the draws.

    Raises:
        InputError: A name is unknown.
    """
    for name in parameters:
        if name not in PARAMETERS:
            raise InputError(f"parameters: found {name!r}, expected {', '.join(PARAMETERS)}")
    white = generator.standard_normal((4, count))
    ends = generator.standard_normal(count + 1)
    rate = parameters.get("angle_walk", 0.0) / np.sqrt(interval) * white[0]
    rate += parameters.get("quantisation", 0.0) / interval * np.diff(ends)
    # the walk at the beginning of each interval, and its mean over the interval given both ends
    steps = np.sqrt(interval) * white[1]
    walk = np.cumsum(steps) - 0.5 * steps + np.sqrt(interval / 12.0) * white[2]
    rate += parameters.get("bias_walk", 0.0) * walk
    flicker = parameters.get("bias_instability", 0.0)
    if flicker:
        rate += flicker * np.cumsum(_flicker_steps(count, generator))
    return rate + parameters.get("rate_ramp", 0.0) * interval * np.arange(count)


def _flicker_steps(count: int, generator: np.random.Generator) -> Vector:
    """Differences of mean rates of flicker noise, (count,), whose covariance is stationary."""
    lag = np.arange(count + 1.0)
    covariance = 2.0 * mean_rate_covariance("bias_instability", lag)
    for shift in (-1.0, 1.0):
        covariance -= mean_rate_covariance("bias_instability", np.abs(lag + shift))
    spectrum = np.fft.rfft(np.concatenate([covariance, covariance[-2:0:-1]])).real
    draws = np.fft.rfft(generator.standard_normal(2 * count))
    return np.fft.irfft(np.sqrt(np.maximum(spectrum, 0.0)) * draws, 2 * count)[:count]
