"""Measured points of a friction curve by inverse dynamics: k_m I - J dw/dt.

Within a short window of constant current the speed is nearly a straight line, the slope of which
is the acceleration. Friction is the motor torque minus the torque of acceleration. Windows are
pooled in bins of speed. No friction model is used.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.result.fit import Fit, FrictionPoints
from gyrostat.telemetry import Record

WINDOW, WINDOWS = 12, 300
"""Smallest number of samples in a window, and largest number of windows in a record."""
BINS = 14
"""Bins of speed on each side of zero."""
FEWEST = 3
"""Smallest number of windows in a bin."""
STEADY = 0.02
"""Largest range of the current in a window, relative to its maximum, that counts as constant."""


def _windows(record: Record, noise: float) -> Matrix:
    """Mean speed, current, acceleration and time of each usable window of a record, (m, 4)."""
    length = max(WINDOW, len(record.time) // WINDOWS)
    starts = np.concatenate(
        [np.arange(part.start, part.stop - length + 1, length) for part in record.segments]
    )
    places = starts[:, None].astype(int) + np.arange(length)
    # the current of the last sample acts only after the window
    current = record.current[places][:, :-1]
    steady = np.ptp(current, axis=1) <= STEADY * np.max(np.abs(record.current))
    usable = steady & record.valid[places].all(axis=1)
    places, current = places[usable], current[usable]
    time, speed = record.time[places], record.speed[places]
    centred = time - time.mean(axis=1, keepdims=True)
    slope = np.sum(centred * speed, axis=1) / np.sum(centred**2, axis=1)
    mean = speed.mean(axis=1)
    # exclude rest and changes of the sense of rotation
    moves = np.abs(mean) > 0.5 * np.abs(slope) * np.ptp(time, axis=1) + 2.0 * noise
    fraction = (time[:, 0] - record.time[0]) / np.ptp(record.time)
    return np.column_stack([mean, current.mean(axis=1), slope, fraction])[moves]


def torque_points(fit: Fit) -> FrictionPoints | None:
    """Friction torque over speed, measured from the records of a fit.

    Args:
        fit: Fit with motor constant and inertia.

    Returns:
        Points with the standard errors of their means; None if the records give too few.
    """
    wheel = fit.parameters
    if not {"motor_constant", "inertia"} <= set(wheel):
        return None
    speed, current, slope, time = _all_windows(fit).T
    motor = wheel["motor_constant"] * (current + wheel.get("current_bias", 0.0))
    return _bin(speed, motor - wheel["inertia"] * slope, time)


def _all_windows(fit: Fit) -> Matrix:
    """Windows of all records, (m, 4)."""
    return np.concatenate([_windows(r, fit.speed_sigma) for r in fit.records])


@dataclass(frozen=True)
class Regression(Described):
    """Estimate of one parameter by linear regression on torque, for comparison with the fit.

    Attributes:
        name: Name of the parameter.
        value: Estimate by regression, SI.
        sigma: Standard deviation from the scatter about the regression, SI.
        disagreement: Difference from the fit, in combined standard deviations.
    """

    name: str
    value: float
    sigma: float
    disagreement: float


def torque_regression(fit: Fit) -> list[Regression]:
    """Regress the torque of acceleration on current, speed and sense of rotation.

    J dw/dt = k_m I - b w - c sgn(w) over windows of constant current: linear, and independent of
    the integration of the model over the record.

    Args:
        fit: Fit of a model with one viscous coefficient and one Coulomb torque.

    Returns:
        One row for each of motor constant, viscous and Coulomb friction that the fit estimates;
        empty if the records or the model do not allow it.
    """
    names = ("motor_constant", "viscous", "coulomb")
    wheel = fit.parameters
    if not {*names, "inertia"} <= set(wheel):
        return []
    speed, current, slope, _ = _all_windows(fit).T
    bias = wheel.get("current_bias", 0.0)
    rows = np.column_stack([current + bias, -speed, -np.sign(speed)])
    free = [k for k, name in enumerate(names) if name in fit.names]
    fixed = [k for k in range(len(names)) if k not in free]
    right = wheel["inertia"] * slope - rows[:, fixed] @ np.array([wheel[names[k]] for k in fixed])
    rows = rows[:, free]
    if not free or len(right) < FEWEST * len(names):
        return []
    size = np.linalg.norm(rows, axis=0)
    if not np.all(size > 0.0) or np.linalg.matrix_rank(rows / size) < len(free):
        return []
    inverse = np.linalg.inv((rows / size).T @ (rows / size)) / np.outer(size, size)
    solution = inverse @ rows.T @ right
    scatter = np.sum((right - rows @ solution) ** 2) / (len(right) - len(free))
    table = []
    for value, variance, k in zip(solution, scatter * np.diag(inverse), free, strict=True):
        sigma = fit.sigma[fit.names.index(names[k])]
        apart = (value - wheel[names[k]]) / np.hypot(sigma, np.sqrt(variance))
        table.append(Regression(names[k], float(value), float(np.sqrt(variance)), float(apart)))
    return table


def _bin(speed: Vector, torque: Vector, time: Vector) -> FrictionPoints | None:
    """Means and standard errors in bins of speed."""
    if len(speed) < FEWEST:
        return None
    width = float(np.max(np.abs(speed))) / BINS
    bin_index = np.floor(speed / width)
    rows = []
    for k in np.unique(bin_index):
        in_bin = bin_index == k
        count = int(in_bin.sum())
        if count >= FEWEST:
            error = float(np.std(torque[in_bin], ddof=1)) / np.sqrt(count)
            rows.append((speed[in_bin].mean(), torque[in_bin].mean(), error, time[in_bin].mean()))
    return FrictionPoints(*map(np.array, zip(*rows, strict=True))) if rows else None
