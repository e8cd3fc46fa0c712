"""Motion predicted from the reference alone, by a linear model of the closed loop."""

import numpy as np
from scipy.signal import lfilter

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.drive.motion import Drive, Motion

ORDER = 5
"""Laguerre functions of the model."""
TIME_CONSTANTS = 14
"""Time constants tried."""


def _responses(reference: Vector, pole: float) -> Matrix:
    """Laguerre functions of a pole applied to a signal (Wahlberg 1991), and a constant."""
    columns = [lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], reference)]
    for _ in range(ORDER - 1):
        columns.append(lfilter([-pole, 1.0], [1.0, -pole], columns[-1]))
    return np.column_stack([*columns, np.ones_like(reference)])


def filtered_reference(drive: Drive) -> Motion:
    """Motion predicted from the reference, by the best of some Laguerre models.

    Its coefficients are those of a linear regression of the measured on the commanded speed, of
    which the disturbances of a record average out.
    """
    longest = max(len(drive.reference) / 20.0, 2.0)
    best, least = np.zeros_like(drive.reference), np.inf
    for samples in np.geomspace(0.5, longest, TIME_CONSTANTS):
        rows = _responses(drive.reference, float(np.exp(-1.0 / samples)))[drive.present]
        target = drive.measured.mean_speed[drive.present]
        solution = np.linalg.lstsq(rows, target, rcond=1e-10)[0]
        cost = float(np.sum((target - rows @ solution) ** 2))
        if cost < least:
            least = cost
            best = _responses(drive.reference, float(np.exp(-1.0 / samples))) @ solution
    inner = 0.5 * (best[1:] + best[:-1])
    return Motion(best, np.concatenate([best[:1], inner, best[-1:]]))
