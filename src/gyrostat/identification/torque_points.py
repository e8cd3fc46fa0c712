"""Measured points of a friction curve: what the motor torque has left after acceleration.

Within a short window of constant current the speed is nearly a straight line; its slope is the
acceleration, and friction is k_m I - J dw/dt (inverse dynamics). Windows are pooled in bins of
speed. No model of friction takes part.
"""

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit import Fit, FrictionPoints
from gyrostat.telemetry import Record

WINDOW, WINDOWS = 12, 300
"""Samples of a window at least, and windows of a long record at most."""
BINS = 14
"""Bins of speed on each side of zero."""
FEWEST = 3
"""Windows that a bin must hold."""
STEADY = 0.02
"""Spread of the current within a window, as a share of its largest, up to which it is constant."""


def _points(record: Record, motor: float, inertia: float, bias: float, noise: float) -> Matrix:
    """Mean speed, friction torque and time of each usable window of a record, (m, 3)."""
    length = max(WINDOW, len(record.time) // WINDOWS)
    starts = np.concatenate(
        [np.arange(part.start, part.stop - length + 1, length) for part in record.segments]
    )
    places = starts[:, None].astype(int) + np.arange(length)
    # the current of the last sample acts after the window
    current = record.current[places][:, :-1]
    steady = np.ptp(current, axis=1) <= STEADY * np.max(np.abs(record.current))
    usable = steady & record.valid[places].all(axis=1)
    places, current = places[usable], current[usable]
    time, speed = record.time[places], record.speed[places]
    centred = time - time.mean(axis=1, keepdims=True)
    slope = np.sum(centred * speed, axis=1) / np.sum(centred**2, axis=1)
    mean = speed.mean(axis=1)
    # neither rest nor a change of sense inside
    moves = np.abs(mean) > 0.5 * np.abs(slope) * np.ptp(time, axis=1) + 2.0 * noise
    torque = motor * (current.mean(axis=1) + bias) - inertia * slope
    when = (time[:, 0] - record.time[0]) / np.ptp(record.time)
    return np.column_stack([mean, torque, when])[moves]


def torque_points(fit: Fit) -> FrictionPoints | None:
    """Friction torque over speed, as the records of a fit measure it.

    Args:
        fit: with motor constant and inertia.

    Returns:
        Points with the standard errors of their means; None where the records show too little.
    """
    known = fit.parameters
    if not {"motor_constant", "inertia"} <= set(known):
        return None
    motor, inertia, bias = (
        known["motor_constant"],
        known["inertia"],
        known.get("current_bias", 0.0),
    )
    parts = [_points(r, motor, inertia, bias, fit.speed_sigma) for r in fit.records]
    return _binned(*np.concatenate(parts).T)


def _binned(speed: Vector, torque: Vector, when: Vector) -> FrictionPoints | None:
    """Means and standard errors in bins of speed."""
    if len(speed) < FEWEST:
        return None
    width = float(np.max(np.abs(speed))) / BINS
    place = np.floor(speed / width)
    rows = []
    for k in np.unique(place):
        own = place == k
        count = int(own.sum())
        if count >= FEWEST:
            error = float(np.std(torque[own], ddof=1)) / np.sqrt(count)
            rows.append((speed[own].mean(), torque[own].mean(), error, when[own].mean()))
    return FrictionPoints(*map(np.array, zip(*rows, strict=True))) if rows else None
