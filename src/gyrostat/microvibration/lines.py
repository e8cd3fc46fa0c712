"""Lines of harmonics in a waterfall: where they are, their power, their number."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.model import TWO_PI
from gyrostat.microvibration.waterfall import Waterfall

FLANK = 8
"""Bins to either side of a line from which the density below it is taken."""
FEWEST_FLANK = 6
"""Smallest number of them that belong to no other line."""
FEWEST_SPEEDS = 5
"""Smallest number of speeds at which a harmonic must stand alone."""


@dataclass(frozen=True, eq=False)
class Lines:
    """Powers of the lines of harmonics for one kind of load.

    Attributes:
        power: Mean square of each line, (H, S), N² or (N·m)²; NaN where a line is not alone.
        floor: Density below it over the density of the model, (H, S).
        flank: Number of bins from which the floor is taken, (H, S).
        centre: Frequency of the centre of the line, (H, S), Hz.
    """

    power: Matrix
    floor: Matrix
    flank: Matrix
    centre: Matrix


def line_mask(
    waterfall: Waterfall, density: Matrix, model: Matrix, numbers: Vector
) -> NDArray[np.int64]:
    """Number of lines whose power reaches each bin, (S, F).

    Args:
        waterfall: Measured waterfall.
        density: Density of one kind of load, (S, F).
        model: Density without lines, (S, F).
        numbers: Numbers of the harmonics, (H,).
    """
    count = np.zeros(density.shape, dtype=np.int64)
    for number in numbers:
        for row, low, high in _reach(waterfall, density, model, float(number)):
            count[row, low:high] += 1
    return count


def _reach(
    waterfall: Waterfall, density: Matrix, model: Matrix, number: float
) -> list[tuple[int, int, int]]:
    """Rows and range of bins that the line of a harmonic reaches."""
    width = waterfall.window.half_width
    bins = len(waterfall.frequency)
    found = []
    place = (number * waterfall.speed / TWO_PI - waterfall.frequency[0]) / waterfall.step
    for row, centre in enumerate(np.round(place).astype(int)):
        if not -width < centre < bins + width:
            continue
        low, high = max(centre - width, 0), min(centre + width + 1, bins)
        below = model[row, low:high]
        excess = np.array([float((density[row, low:high] - below).sum() / below.mean())])
        reach = int(waterfall.window.mask_width(excess)[0])
        found.append((row, max(centre - reach, 0), min(centre + reach + 1, bins)))
    return found


def measure_lines(
    waterfall: Waterfall,
    density: Matrix,
    model: Matrix,
    numbers: Vector,
    stationary: NDArray[np.bool_],
) -> Lines:
    """Measure the power of each line above the density to both sides of it.

    Args:
        waterfall: Measured waterfall.
        density: Density of one kind of load, (S, F).
        model: Density without lines, (S, F).
        numbers: Numbers of the harmonics, (H,).
        stationary: Bins of lines that do not move, next to which no harmonic is alone, (F,).
    """
    shape = (len(numbers), len(waterfall.speed))
    power, floor, flank, centre = (np.full(shape, np.nan) for _ in range(4))
    count = line_mask(waterfall, density, model, numbers) + stationary
    width, bins, step = waterfall.window.half_width, density.shape[1], waterfall.step
    offset = np.arange(-width, width + 1)
    for k, number in enumerate(numbers):
        for row, low, high in _reach(waterfall, density, model, float(number)):
            middle = float(number) * waterfall.speed[row] / TWO_PI - waterfall.frequency[0]
            place = round(middle / step)
            if place - width < 0 or place + width >= bins or np.any(count[row, low:high] > 1):
                continue
            sides = np.r_[max(low - FLANK, 0) : low, high : min(high + FLANK, bins)]
            sides = sides[count[row, sides] == 0]
            if len(sides) < FEWEST_FLANK:
                continue
            ratio = float(density[row, sides].sum() / model[row, sides].sum())
            inside = place + offset
            above = density[row, inside] - ratio * model[row, inside]
            power[k, row] = step * above.sum()
            floor[k, row] = ratio
            flank[k, row] = len(sides)
            shift = float(offset @ above / above.sum()) if above.sum() > 0.0 else np.nan
            centre[k, row] = waterfall.frequency[0] + step * (place + shift)
    return Lines(power, floor, flank, centre)


def number_of(
    speed: Vector, lines: list[Lines], sigma: list[Matrix], index: int
) -> tuple[float, float, float]:
    """Number of a harmonic from the centres of its lines: value, sigma and half width of 95 %.

    The sigma is that of the scatter between speeds, so that it has the errors of the speeds too.

    Args:
        speed: Wheel speeds, (S,), rad/s.
        lines: Lines of the kinds of load.
        sigma: Standard deviations of their powers, (H, S) each.
        index: Index of the harmonic.
    """
    values, weights = [], []
    for each, spread in zip(lines, sigma, strict=True):
        ratio = each.power[index] / spread[index]
        good = np.isfinite(ratio) & np.isfinite(each.centre[index]) & (ratio > 5.0)
        values.append(TWO_PI * each.centre[index][good] / speed[good])
        weights.append((ratio[good] * speed[good]) ** 2)
    value, weight = np.concatenate(values), np.concatenate(weights)
    if len(value) < FEWEST_SPEEDS:
        return np.nan, np.nan, np.nan
    weight = weight / weight.sum()
    mean = float(weight @ value)
    freedom = 1.0 / float(weight @ weight) - 1.0
    # each residual is smaller than its error by the share that its value has in the mean
    scatter = float(np.sum(weight**2 * (value - mean) ** 2 / (1.0 - weight) ** 2))
    spread = float(np.sqrt(scatter))
    return mean, spread, spread * float(student.ppf(0.975, max(freedom, 1.0)))
