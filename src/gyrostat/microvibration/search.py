"""Search for harmonics: matched filter along lines through the origin of a waterfall."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.lines import FEWEST_SPEEDS, line_mask
from gyrostat.microvibration.model import TWO_PI
from gyrostat.microvibration.waterfall import Waterfall

PATCH = (7, 9)
"""Speeds and bins of the median that stands for the density without lines."""
THRESHOLD = 6.0
"""Smallest signal of a harmonic in its standard deviations: a chance of some 1e-9 for each of the
thousands of numbers that are tried."""
MOST = 30
"""Largest number of harmonics."""
LOWEST_NUMBER = 0.2
STATIONARY = 4.0
"""Median over speeds of a bin over its neighbours from which it is a line that does not move."""


def smooth_density(density: Matrix) -> Matrix:
    """Density without lines: the median over a patch of speeds and frequencies, (S, F)."""
    values = median_filter(density, size=PATCH, mode="nearest")
    return np.maximum(values, 1e-12 * float(density.max()) + 1e-300)


def stationary_bins(density: Matrix) -> NDArray[np.bool_]:
    """Bins of lines whose frequency does not depend on the speed, such as mains, (F,)."""
    column = np.median(density, axis=0)
    around = median_filter(column, size=25, mode="nearest")
    bins = column > STATIONARY * np.maximum(around, 1e-300)
    # a resonance is broad, a line is not
    wide = np.convolve(bins, np.ones(9), mode="same") > 7
    bins = bins & ~wide
    return np.convolve(bins, np.ones(7), mode="same") > 0


@dataclass(frozen=True, eq=False)
class _Signal:
    """Data of the matched filter for one kind of load: excess and its variance, (S, F)."""

    excess: Matrix
    variance: Matrix


def find_harmonics(waterfall: Waterfall, models: dict[str, Matrix]) -> Vector:
    """Numbers of the harmonics that stand out from noise, increasing, (H,).

    The strongest is found first and its bins are left out of the search for the next.

    Args:
        waterfall: Measured waterfall.
        models: Kind of load -> density without lines, (S, F).
    """
    speed, step = waterfall.speed / TWO_PI, waterfall.step
    usable = np.sort(speed)[min(FEWEST_SPEEDS, len(speed)) - 1]
    highest = waterfall.frequency[-1] / usable
    grid = np.arange(LOWEST_NUMBER, highest, 0.5 * step / speed[-1])
    place = np.round((grid[:, None] * speed - waterfall.frequency[0]) / step).astype(int)
    # the first bin has no two neighbours and never counts
    place = np.where((place >= 0) & (place < len(waterfall.frequency)), place, 0)
    free = {kind: np.ones(density.shape) for kind, (density, _) in waterfall.kinds.items()}
    for kind, (density, _) in waterfall.kinds.items():
        free[kind][:, stationary_bins(density)] = 0.0
    signals = {kind: _signal(waterfall.kinds[kind][0], models[kind]) for kind in models}
    numbers: list[float] = []
    while len(numbers) < MOST:
        best, signal = -1.0, 0.0
        for kind, data in signals.items():
            value = _statistic(data, free[kind], place, waterfall.speed)
            at = int(np.argmax(value))
            if value[at] > signal:
                best, signal = float(grid[at]), float(value[at])
        if signal < THRESHOLD:
            break
        numbers.append(_refined(waterfall, signals, free, best))
        for kind, (density, _) in waterfall.kinds.items():
            reached = line_mask(waterfall, density, models[kind], np.array(numbers[-1:]))
            free[kind][reached > 0] = 0.0
    return np.sort(np.array(numbers))


def _signal(density: Matrix, model: Matrix) -> _Signal:
    ratio = density / model
    # spread of the density, from its quartiles: lines are few
    low, high = np.quantile(ratio, [0.25, 0.75])
    spread = ((high - low) / 1.349) ** 2
    middle = float(np.median(ratio))
    return _Signal(density - middle * model, spread * model**2)


def _statistic(data: _Signal, free: Matrix, place: NDArray[np.int64], speed: Vector) -> Vector:
    """Signal of each number over its standard deviation, the strongest speed left out."""
    rows = np.arange(len(speed))
    # three bins, whose noise is correlated by the window: some 2.7 times the sum of variances
    variance = 2.7 * _three(data.variance)
    alone = (_three(free) > 2.5) & (variance > 0.0)
    weight = np.where(alone, speed[:, None] ** 4 / np.where(alone, variance, 1.0), 0.0)
    parts = (weight * _three(data.excess))[rows, place]
    noise = (weight**2 * variance)[rows, place]
    top = np.argmax(parts, axis=1)[:, None]
    total = parts.sum(axis=1) - np.take_along_axis(parts, top, 1)[:, 0]
    left = noise.sum(axis=1) - np.take_along_axis(noise, top, 1)[:, 0]
    enough = alone[rows, place].sum(axis=1) >= FEWEST_SPEEDS
    return np.where(enough, total / np.sqrt(np.maximum(left, 1e-300)), 0.0)


def _three(values: Matrix) -> Matrix:
    """Sum of each bin and its neighbours, 0 at the ends, (S, F)."""
    result = np.zeros_like(values)
    result[:, 1:-1] = values[:, 1:-1] + values[:, :-2] + values[:, 2:]
    return result


def _refined(
    waterfall: Waterfall, signals: dict[str, _Signal], free: dict[str, Matrix], number: float
) -> float:
    """Number from the centres of the line at each speed, twice."""
    width = waterfall.window.half_width
    offset = np.arange(-width, width + 1)
    for _ in range(2):
        top = bottom = 0.0
        for kind, data in signals.items():
            for row, speed in enumerate(waterfall.speed / TWO_PI):
                place = round((number * speed - waterfall.frequency[0]) / waterfall.step)
                bins = place + offset
                if bins[0] < 0 or bins[-1] >= len(waterfall.frequency):
                    continue
                if not free[kind][row, bins].all():
                    continue
                power = np.maximum(data.excess[row, bins], 0.0)
                spread = float(np.sqrt(data.variance[row, bins].sum()))
                if power.sum() < 4.0 * spread:
                    continue
                weight = min(float(power.sum()) / spread, 100.0) * speed**2
                centre = waterfall.frequency[bins] @ power / power.sum()
                top += weight * centre / speed
                bottom += weight
        number = top / bottom if bottom > 0.0 else number
    return float(number)
