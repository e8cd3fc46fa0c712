"""Start values of the densities of one kind of load: a grid of modes, levels by least squares."""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.microvibration.kind_model import SHAPE, KindModel
from gyrostat.microvibration.model import TWO_PI

GRID = 48
"""Natural frequencies that are tried."""
DAMPINGS = (0.006, 0.02, 0.07)
RATIOS = (0.0, 0.6, 1.0, 1.4, 1.8)
EXPONENT = 1.5
ROWS = 8
"""Speeds that the grid looks at."""


def start_values(model: KindModel) -> Vector:
    """Parameters of the density from which the fit starts; coefficients are 0.

    Args:
        model: Model of the kind of load.
    """
    count = len(SHAPE) + 2 * len(model.numbers)
    values = np.zeros(count)
    values[2] = EXPONENT
    values[3:5] = np.log([TWO_PI * model.waterfall.frequency[-1], 0.02])
    if not model.has_mode:
        values[0], values[1], _ = _levels(model, values, np.arange(len(model.density)))
        return values
    rows = np.unique(np.linspace(0, len(model.density) - 1, ROWS).astype(int))
    low, high = model.waterfall.frequency[[0, -1]]
    best = np.inf
    start = values.copy()
    natural = TWO_PI * np.geomspace(max(low, high / 200.0), high, GRID)
    for ratio in RATIOS if model.is_gyroscopic else (0.0,):
        for damping in DAMPINGS:
            for frequency in natural:
                values[3:6] = np.log(frequency), np.log(damping), ratio
                values[0], values[1], deviance = _levels(model, values, rows)
                if deviance < best:
                    best, start = deviance, values.copy()
    return start


def _levels(
    model: KindModel, values: Vector, rows: NDArray[np.int64]
) -> tuple[float, float, float]:
    """Floor and noise by weighted least squares, and the deviance."""
    speed = model.waterfall.speed[rows, None]
    trial = values.copy()
    trial[0], trial[1] = 0.0, 1.0
    ahead, behind = model.noise(trial, model.waterfall.frequency[None], speed)
    shape = (0.5 * (ahead + behind)).ravel()
    used, density = model.used[rows].ravel(), model.density[rows].ravel()
    middle = float(np.median(density))
    expected = np.full_like(density, middle)
    floor = noise = 0.0
    for _ in range(3):
        weight = used / expected**2
        floor, noise = _two_levels(weight, shape, density)
        expected = np.maximum(floor + noise * shape, 1e-3 * middle)
    ratio = np.maximum(density, 1e-300) / expected
    return floor, noise, float(np.sum(used * (ratio - 1.0 - np.log(ratio))))


def _two_levels(weight: Vector, shape: Vector, density: Vector) -> tuple[float, float]:
    """Least squares of density = floor + noise shape with neither below 0."""
    shaped = weight * shape
    mixed = shape @ weight
    matrix = np.array([[np.sum(weight), mixed], [mixed, shape @ shaped]])
    right = np.array([weight @ density, shaped @ density])
    determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] ** 2
    if determinant > 1e-9 * matrix[0, 0] * matrix[1, 1]:
        floor, noise = np.linalg.solve(matrix, right)
        if floor >= 0.0 and noise >= 0.0:
            return float(floor), float(noise)
        if floor < 0.0:
            return 1e-3 * float(right[0] / matrix[0, 0]), float(right[1] / matrix[1, 1])
    return float(right[0] / matrix[0, 0]), 0.0
