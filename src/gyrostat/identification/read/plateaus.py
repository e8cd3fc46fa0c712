"""Find plateaus of steady speed in a record.

The speed of a record is approximated by straight lines, as many as its noise supports. A line is a
plateau if the wheel clearly turns and if the speed drift is neither significant nor large enough to
need a relevant torque. The method does not depend on how the wheel is driven.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.identification.read.lines import Line, fastest_acceleration, straight_lines
from gyrostat.identification.read.statistics import correlation_length, quantum, serial_meat
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import scatter

MIN_SAMPLES = 16
"""Smallest number of speed samples in a plateau; with fewer, their scatter is unknown."""
CLEAR = 3.0
"""Standard deviations beyond which a drift or a difference of means is significant."""
SMALL = 0.005
"""Relative difference of a current below which it is ignored."""
SMALL_DRIFT = 0.001
"""Drift, relative to the fastest acceleration of the record, below which it is ignored even if it
is significant: it needs about this fraction of the largest motor torque."""
POSSIBLE_DRIFT = 0.01
"""Largest relative drift within its uncertainty. A line for which a larger drift is possible is too
short to be classified as a plateau."""
PARTS = 8
"""Parts into which a line is divided. An end part whose mean speed or current differs significantly
from the rest is a transient and is removed, as long as half of the line remains."""
CLEAR_OF_REST = 2.0
"""Steady speed over its scatter, below which the wheel counts as resting."""
RESOLUTION = 1e-4
"""Scatter, relative to the rms speed, below which speeds count as equal."""


@dataclass(frozen=True)
class Plateau:
    """Interval of steady speed.

    Attributes:
        start: Index of the first sample.
        stop: Index after the last sample.
        speed: Mean speed, rad/s.
        speed_sigma: Standard deviation of the mean speed, rad/s.
        scatter: Standard deviation of one measured speed about the mean, rad/s.
        current: Mean current, A.
        current_sigma: Standard deviation of the mean current, A.
        drift: Slope of a straight line fitted to the speeds, rad/s².
        drift_sigma: Standard deviation of the drift, rad/s².
        count: Number of valid speed samples.
    """

    start: int
    stop: int
    speed: float
    speed_sigma: float
    scatter: float
    current: float
    current_sigma: float
    drift: float
    drift_sigma: float
    count: int


def _noise(speed: Vector) -> float:
    """Noise of a speed signal, rad/s, white or correlated over less than a plateau.

    From second differences over several strides; their median is insensitive to motion.
    """
    return max(scatter(speed[::stride]) for stride in (1, MIN_SAMPLES // 2, MIN_SAMPLES))


def _rounding_sigma(misfit: Vector, step: float | None) -> float:
    """Standard deviation of the mean's error that quantisation causes.

    Args:
        misfit: Distance of the samples from their mean or trend, (m,).
        step: Quantisation step, or None. If the scatter is well above the step, quantisation errors
            average out. If it is below, the mean is as uncertain as one quantised sample.
    """
    if step is None:
        return 0.0
    scatter = max(float(np.mean(misfit**2)) - step**2 / 12.0, 0.0)
    return step / np.sqrt(12.0) * float(np.exp(-2.0 * np.pi**2 * scatter / step**2))


def mean_sigma(samples: Vector, step: float | None) -> float:
    """Standard deviation of the mean of a stationary series.

    Args:
        samples: Samples in time order, (m,), m >= 2; serial correlation is taken into account.
        step: Quantisation step of the samples, or None.
    """
    count = len(samples)
    misfit = samples - samples.mean()
    variance = serial_meat(misfit[:, None], correlation_length(misfit))[0, 0] / count**2
    return float(np.hypot(np.sqrt(variance * count / (count - 1.0)), _rounding_sigma(misfit, step)))


def _drift(time: Vector, speed: Vector, step: float | None, least: float) -> tuple[float, float]:
    """Drift of a speed and its standard deviation, rad/s², with the noise model of `mean_sigma`.

    The standard deviation is at least that for independent noise of `least`, rad/s.
    """
    t = time - time.mean()
    power = float(t @ t)
    rate = float(t @ speed) / power
    misfit = speed - speed.mean() - rate * t
    meat = serial_meat((t * misfit)[:, None], correlation_length(misfit))[0, 0] / power**2
    # quantisation that does not average out hides a difference between the two ends
    ends = np.sqrt(2.0) * _rounding_sigma(misfit, step) / (time[-1] - time[0])
    return rate, float(np.hypot(np.sqrt(max(meat, least**2 / power)), ends))


def _trim(record: Record, line: Line, least: float) -> NDArray[np.intp]:
    """Samples of a line without the end parts that differ from the rest."""
    parts = np.array_split(line.index, PARTS)

    def stands_out(part: NDArray[np.intp], remainder: NDArray[np.intp]) -> bool:
        for series, small in (
            (record.speed, least),
            (record.current, SMALL * abs(record.current[remainder].mean())),
        ):
            sigma = mean_sigma(series[remainder], None) * np.sqrt(1.0 + len(remainder) / len(part))
            if abs(series[part].mean() - series[remainder].mean()) > max(CLEAR * sigma, small):
                return True
        return False

    while len(parts) > PARTS // 2:
        if stands_out(parts[0], np.concatenate(parts[1:])):
            parts = parts[1:]
        elif stands_out(parts[-1], np.concatenate(parts[:-1])):
            parts = parts[:-1]
        else:
            break
    return np.concatenate(parts)


def _level(drift: float, sigma: float, fastest: float) -> bool:
    """Whether a drift can be ignored in a record with a given fastest acceleration, all rad/s²."""
    level = abs(drift) <= max(CLEAR * sigma, SMALL_DRIFT * fastest)
    return level and (fastest == 0.0 or abs(drift) + CLEAR * sigma <= POSSIBLE_DRIFT * fastest)


def find_plateaus(record: Record, speed_sigma: float | None = None) -> list[Plateau]:
    """Find intervals in which a wheel turned at steady speed.

    Lines end where the setpoint changes, if the record has one; otherwise only the speed is used.

    Args:
        record: Record of one wheel; may have uneven sampling, quantised and missing speeds.
        speed_sigma: Standard deviation of a measured speed, rad/s; by default from the record.

    Returns:
        Plateaus in time order, without those at rest.
    """
    valid = record.speed[record.valid]
    speed_step, current_step = quantum(valid), quantum(record.current)
    rounding = 0.0 if speed_step is None else speed_step / np.sqrt(12.0)
    least = max(rounding, RESOLUTION * float(np.sqrt(np.mean(valid**2))), np.finfo(float).tiny)
    floor = max(least, _noise(valid) if speed_sigma is None else speed_sigma)
    changes = [] if record.setpoint is None else np.flatnonzero(np.diff(record.setpoint)) + 1
    edges = [0, *changes, len(record.time)]
    lines = [
        line
        for start, stop in pairwise(edges)
        for line in straight_lines(record, int(start), int(stop), floor)
    ]
    fastest = fastest_acceleration(record, lines, floor)
    plateaus = []
    for line in lines:
        if len(line.index) < MIN_SAMPLES:
            continue
        part = _trim(record, line, least)
        speed, current = record.speed[part], record.current[part]
        scatter = max(float(np.std(speed)), least)
        drift, drift_sigma = _drift(record.time[part], speed, speed_step, least)
        turns = abs(speed.mean()) > CLEAR_OF_REST * scatter
        if turns and _level(drift, drift_sigma, fastest):
            plateaus.append(
                Plateau(
                    start=int(part[0]),
                    stop=int(part[-1]) + 1,
                    speed=float(speed.mean()),
                    speed_sigma=mean_sigma(speed, speed_step),
                    scatter=scatter,
                    current=float(current.mean()),
                    current_sigma=mean_sigma(current, current_step),
                    drift=drift,
                    drift_sigma=drift_sigma,
                    count=len(part),
                )
            )
    return plateaus
