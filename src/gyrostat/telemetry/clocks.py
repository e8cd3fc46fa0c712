"""Lag and rate of the clock of a speed log against that of a current log.

Within a block of samples that turn one way, friction is nearly a line over time for any law:

    w(s) = a + d s + k Q(t) + noise,   t = s + lag + rate (s - centre),   Q = integral of current

with a and d of each block, and k of all. Steps of the current bend the speed and so show the lag.
What viscous friction and a falling curve of friction add within a block has common columns.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.telemetry.record import Record
from gyrostat.telemetry.signals import held_integral, scatter, trapezoidal

COARSE = 1500
"""Intervals of the longer log in the search for the lag."""
BLOCKS = (12, 25, 50, 100, 200, 400)
"""Samples of a block that are tried; the one with the smallest sigma is taken."""
FEWEST = 20
"""Smallest number of blocks, whose scatter gives sigma."""
DISTINCT = 40.0
"""Smallest difference of 2 log(likelihood) between the best lag and another one."""
SHOWN = 5.0
"""Rate difference that is applied, in its standard deviations."""
SCALES = (0.01, 0.04, 0.16)
"""Speeds over which friction falls, in the largest speed."""
STEPS = 30
"""Largest number of iterations."""


@dataclass(frozen=True)
class ClockDifference:
    """Clock of the current log against that of the speed log.

    Attributes:
        centre: Time of the speed log at which the lag is stated, s.
        lag: Time of the current log less time of the speed log, at the centre, s.
        lag_sigma: Its standard deviation, s.
        rate: Relative excess of the rate of the current log's clock; 0 if it does not show.
        rate_sigma: Its standard deviation, or 0.
    """

    centre: float
    lag: float
    lag_sigma: float
    rate: float = 0.0
    rate_sigma: float = 0.0

    def times(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Times of the speed log on the clock of the current log, (N,), s."""
        return time + self.lag + self.rate * (time - self.centre)


def clock_difference(current: Record, speed: Record) -> ClockDifference:
    """Find the difference of the clocks of a current log and a speed log.

    The current is constant from each sample to the next. A delay of the speed's measurement is part
    of the lag.

    Args:
        current: Record with currents.
        speed: Record with speeds.

    Raises:
        InputError: The logs do not show one lag within a sample interval.
    """
    if speed.averaged:
        # the mean over the interval before a sample is the speed in its middle
        before = np.diff(speed.time, prepend=2.0 * speed.time[0] - speed.time[1])
        speed = replace(speed, time=speed.time - 0.5 * before)
    start, step = _coarse_lag(current, speed)
    fits = []
    for size in BLOCKS:
        blocks = _blocks(speed, size)
        if len(blocks) >= FEWEST:
            fits += [fit for fit in [_refined(current, speed, blocks, start)] if fit is not None]
    usual = max(float(np.median(np.diff(log.time))) for log in (current, speed))
    best = min(fits, key=lambda fit: fit.lag_sigma, default=None)
    if best is None or not (best.lag_sigma < usual and abs(best.lag - start) < 3.0 * step):
        sigma = "" if best is None else f" (sigma {best.lag_sigma:.2g} s)"
        raise _unknown(current, speed, f"no lag within a sample interval{sigma}")
    return best


def _unknown(current: Record, speed: Record, found: str) -> InputError:
    return InputError(
        f"{speed.name}: found {found} against the current of {current.name}, expected currents "
        "that change at irregular times while the wheel turns, and logs that overlap"
    )


def charge(record: Record, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Integral of the held current from the start of a record, (N,), A·s."""
    return np.interp(times, record.time, held_integral(record.current, record.time))


def _coarse_lag(current: Record, speed: Record) -> tuple[float, float]:
    """Lag that explains the accelerations best, and the interval of the search, s."""
    spans = [float(np.ptp(log.time)) for log in (current, speed)]
    usual = max(float(np.median(np.diff(log.time))) for log in (current, speed))
    step = max(2.0 * usual, max(spans) / COARSE)
    while min(spans) >= 4 * FEWEST * step:
        lag = _distinct_lag(current, speed, step)
        if lag is not None:
            return lag, step
        # noise weighs less over longer intervals
        step *= 2.0
    raise _unknown(current, speed, "no lag that explains the speed better than others")


def _distinct_lag(current: Record, speed: Record, step: float) -> float | None:
    """Lag that explains the mean accelerations over intervals best; None if others do as well."""
    logs = (current, speed)
    counts = [int(np.ptp(log.time) / step) for log in logs]
    edges = [log.time[0] + step * np.arange(n + 1) for log, n in zip(logs, counts, strict=True)]
    means = np.diff(charge(current, edges[0])) / step
    at = np.interp(edges[1], speed.time[speed.valid], speed.speed[speed.valid])
    middle = 0.5 * (at[1:] + at[:-1])
    shortest = min(counts) // 2
    shifts = np.arange(shortest - counts[1], counts[0] - shortest + 1)
    score = _gains(means, np.diff(at) / step, middle, shifts)
    best = int(np.argmax(score))
    others = score[np.abs(shifts - shifts[best]) > 3]
    if not score[best] - np.max(others, initial=0.0) > DISTINCT:
        return None
    return float(edges[0][0] - edges[1][0] + shifts[best] * step)


def _gains(
    means: NDArray[np.float64],
    acceleration: NDArray[np.float64],
    speed: NDArray[np.float64],
    shifts: NDArray[np.intp],
) -> NDArray[np.float64]:
    """2 log(likelihood) that the current adds to friction, at each shift, in intervals.

    Normal equations: their sums over the common intervals are differences of cumulative sums, and
    those with the shifted current are correlations.
    """
    # friction has a constant: what is taken off changes nothing, and the sums keep their digits
    means, turned = means - np.mean(means), speed - np.mean(speed)
    turned = turned / max(float(np.max(np.abs(turned))), 1e-300)
    friction = np.stack([np.ones_like(speed), turned, np.sign(speed)])
    first = np.maximum(0, -shifts)
    last = np.minimum(len(acceleration), len(means) - shifts)

    def total(series: NDArray[np.float64], since: Any, until: Any) -> NDArray[np.float64]:
        sums = np.cumsum(series, axis=-1)
        sums = np.concatenate([np.zeros_like(sums[..., :1]), sums], axis=-1)
        return np.moveaxis(sums[..., until] - sums[..., since], -1, 0)

    def shifted(series: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.correlate(means, series, "full")[shifts + len(series) - 1]

    inverse = np.linalg.pinv(
        total(friction[:, None] * friction, first, last), rcond=1e-10, hermitian=True
    )
    own = total(friction * acceleration, first, last)
    other = np.stack([shifted(row) for row in friction], axis=-1)
    projected = np.einsum("ni,nij->nj", other, inverse)
    power = total(acceleration**2, first, last)
    without = power - np.einsum("ni,nij,nj->n", own, inverse, own)
    without = np.maximum(without, 1e-12 * power + 1e-15 * np.sum(acceleration**2) + 1e-300)
    squares = total(means**2, first + shifts, last + shifts)
    left = squares - np.sum(projected * other, axis=-1)
    common = shifted(acceleration) - np.sum(projected * own, axis=-1)
    # a current that friction explains shows no shift
    shown = left > 1e-10 * squares + 1e-14 * np.sum(means**2)
    gain = np.where(shown, common**2 / np.where(shown, left, 1.0), 0.0)
    # neighbouring accelerations share a speed: half of them count
    return 0.5 * (last - first) * np.log(without / np.maximum(without - gain, 1e-12 * without))


def _blocks(speed: Record, size: int) -> list[NDArray[np.intp]]:
    """Indices of the samples of each block, which turn one way without stopping."""
    present = np.flatnonzero(speed.valid)
    values = speed.speed[present]
    turning = np.abs(values) > max(6.0 * scatter(values), 0.01 * float(np.max(np.abs(values))))
    way = np.where(turning, np.sign(values), 0.0)
    edges = np.flatnonzero(np.diff(way)) + 1
    blocks = []
    for run in np.split(present, edges):
        if way[np.searchsorted(present, run[0])] != 0.0:
            blocks += [run[k : k + size] for k in range(0, len(run) - size + 1, size)]
    return blocks


def _refined(
    current: Record, speed: Record, blocks: list[NDArray[np.intp]], start: float
) -> ClockDifference | None:
    """Least-squares fit from a start; None if it does not converge."""
    index = np.stack(blocks)
    time = speed.time[index]
    inside = np.all((time + start > current.time[0]) & (time + start < current.time[-1]), axis=1)
    if np.sum(inside) < FEWEST:
        return None
    index, time = index[inside], time[inside]
    centre = float(time.mean())
    blocks_in = _Blocks(time, centre)
    common = np.stack([blocks_in.without_lines(each[index]) for each in _friction(speed)], axis=-1)
    left, size, _ = np.linalg.svd(common.reshape(index.size, -1), full_matrices=False)
    basis = left[:, size > 1e-6 * size[0]]
    samples = replace(blocks_in, friction=basis)
    lag = _fit(current, samples, speed.speed[index], np.array([start]))
    if lag is None:
        return None
    both = _fit(current, samples, speed.speed[index], np.append(lag[0], 0.0))
    if both is not None and abs(both[0][1]) > SHOWN * both[1][1]:
        lag_value, rate = both[0].tolist()
        lag_sigma, rate_sigma = both[1].tolist()
        return ClockDifference(centre, lag_value, lag_sigma, rate, rate_sigma)
    return ClockDifference(centre, float(lag[0][0]), float(lag[1][0]))


def _friction(speed: Record) -> list[NDArray[np.float64]]:
    """Integrals over time of speed and of falling friction, (N,) each."""
    present = speed.valid
    values = np.interp(speed.time, speed.time[present], speed.speed[present])
    largest = float(np.max(np.abs(values)))
    falling = [np.sign(values) * np.exp(-np.abs(values) / (a * largest)) for a in SCALES]
    return [trapezoidal(each, speed.time) for each in (values / largest, *falling)]


@dataclass(frozen=True)
class _Blocks:
    """Times of the samples in blocks, (B, n), their centre, and a basis of friction, (B n, k)."""

    time: NDArray[np.float64]
    centre: float
    friction: NDArray[np.float64] | None = None

    def without_lines(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values less their line over time in each block and less friction, (B, n)."""
        since = self.time - self.time.mean(axis=1, keepdims=True)
        values = values - values.mean(axis=1, keepdims=True)
        slope = np.sum(since * values, axis=1) / np.sum(since**2, axis=1)
        values = values - slope[:, None] * since
        if self.friction is None:
            return values
        flat = values.ravel()
        return (flat - self.friction @ (self.friction.T @ flat)).reshape(values.shape)


def _fit(
    current: Record,
    blocks: _Blocks,
    speed: NDArray[np.float64],
    clock: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Lag, and the rate if it has a start, with their standard deviations between blocks.

    Gauss-Newton iterations; None if they do not converge.
    """
    speed = blocks.without_lines(speed)
    since = blocks.time - blocks.centre
    for _ in range(STEPS):
        at = blocks.time + clock[0] + (clock[1] * since if clock.size > 1 else 0.0)
        column = blocks.without_lines(charge(current, at))
        held = current.current[np.clip(np.searchsorted(current.time, at, "right") - 1, 0, None)]
        power = float(np.sum(column**2))
        if not power > 0.0:
            return None
        gain = float(np.sum(column * speed)) / power
        slopes = [gain * held, gain * held * since][: clock.size]
        columns = np.stack([column, *map(blocks.without_lines, slopes)], axis=-1)
        residual = speed - gain * column
        normal = np.einsum("bni,bnj->ij", columns, columns)
        scale = np.sqrt(np.diag(normal))
        if not np.all(scale > 0.0) or np.linalg.cond(normal / np.outer(scale, scale)) > 1e10:
            return None
        inverse = np.linalg.inv(normal)
        change = inverse @ np.einsum("bni,bn->i", columns, residual)
        clock = clock + change[1:]
        parts = np.einsum("bni,bn->bi", columns, residual - columns @ change)
        spread = parts.T @ parts * len(parts) / max(len(parts) - len(change), 1)
        sigma = np.sqrt(np.diag(inverse @ spread @ inverse))
        if np.all(np.abs(change[1:]) < 1e-3 * sigma[1:]):
            return clock, sigma[1:]
    return None
