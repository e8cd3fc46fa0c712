"""Noise parameters of one axis of a gyro from its record at rest."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.identification.gyro.allan_deviation import (
    allan_deviations,
    cluster_sizes,
    confidence_limits,
    degrees_of_freedom,
)
from gyrostat.identification.gyro.likelihood import LEVEL, Maximum, Transformed, transformed
from gyrostat.identification.gyro.noise import NAMES
from gyrostat.identification.gyro.parameters import Estimate

FEWEST_SAMPLES = 200
"""Smallest number of samples to which parameters are fitted."""
FALSE_ALARMS = 1e-3
"""Probability that a record of the modelled noise gets a warning."""
LEAST_MISFIT = 0.1
"""Smallest relative misfit of a spectrum that is worth a warning."""


@dataclass(frozen=True, eq=False)
class AxisNoise(Described):
    """Noise of one axis.

    Attributes:
        axis: Name of the axis.
        time: Averaging times, (T,), s.
        deviation: Overlapping Allan deviation, (T,), rad/s.
        low: Lower ends of its 95 % intervals, (T,), rad/s.
        high: Upper ends, (T,), rad/s.
        mean: Mean of the record, rad/s.
        parameters: Estimates in the order of `PARAMETERS`.
        warnings: Where the record does not follow the fitted noise.
    """

    axis: str
    time: Vector
    deviation: Vector
    low: Vector
    high: Vector
    mean: float
    parameters: dict[str, Estimate]
    warnings: tuple[str, ...]


def axis_noise(axis: str, rate: Vector, interval: float, shortest: int = 1) -> AxisNoise:
    """Estimate the noise of an axis.

    Args:
        axis: Name of the axis.
        rate: Mean rates over the intervals, (N,), rad/s.
        interval: Interval, s.
        shortest: Number of samples that are averaged before the parameters are fitted.
    """
    sizes = cluster_sizes(rate.size)
    deviation = allan_deviations(rate, sizes)
    count = rate.size // shortest
    averaged = rate[: count * shortest].reshape(count, shortest).mean(axis=1)
    record = transformed(averaged, interval * shortest)
    best = record.maximise()
    parameters = {}
    for index, name in enumerate(NAMES):
        low, high = record.limits(index, best)
        ends = np.sqrt([best.variances[index], low, high])
        parameters[name] = Estimate(name, *(float(each) for each in ends))
    half = record.ramp_half_width(best)
    parameters["rate_ramp"] = Estimate("rate_ramp", best.ramp, best.ramp - half, best.ramp + half)
    freedom = degrees_of_freedom(best.variances, rate.size, interval, sizes)
    low, high = confidence_limits(deviation, freedom, LEVEL)
    return AxisNoise(
        axis,
        interval * sizes,
        deviation,
        low,
        high,
        float(np.mean(rate)),
        parameters,
        tuple(_misfits(record, best)),
    )


def _misfits(record: Transformed, best: Maximum) -> list[str]:
    """Octaves of frequency in which the record does not follow the fitted noise, as lines."""
    ratio = record.power / (best.variances @ record.basis)
    slope = best.ramp - record.slope
    early = (record.low - slope * record.line) ** 2
    ratio[: early.size] *= early / record.power[: early.size]
    octave = np.floor(np.log2(record.frequency[-1] / record.frequency)).astype(int)
    found, octaves = [], np.unique(octave)
    for each in octaves:
        inside = octave == each
        members = float(record.members[inside].sum())
        total = float(record.members[inside] @ ratio[inside])
        tail = min(chi2.cdf(total, members), chi2.sf(total, members))
        if tail < 0.5 * FALSE_ALARMS / octaves.size and abs(total / members - 1.0) > LEAST_MISFIT:
            ends = record.frequency[inside][[0, -1]]
            found.append(
                f"from {ends[0]:.3g} to {ends[1]:.3g} Hz, the noise power is "
                f"{total / members:.3g} times that of the fit: the intervals do not hold if "
                "vibration, temperature or the bandwidth of the gyro shape this part"
            )
    return found
