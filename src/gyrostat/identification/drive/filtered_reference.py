"""Motion predicted from the reference alone, by a linear model of the closed loop."""

import numpy as np
from scipy.signal import lfilter, lfilter_zi

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.drive.motion import Drive, Motion

ORDER = 5
"""Laguerre functions of the model."""
TIME_CONSTANTS = 14
"""Time constants tried."""


def _filtered(series: Vector, numerator: list[float], pole: float) -> Vector:
    """Output of a filter that was at rest at the first value of its input."""
    denominator = [1.0, -pole]
    rest = lfilter_zi(numerator, denominator) * series[0]
    return lfilter(numerator, denominator, series, zi=rest)[0]


def _responses(reference: Vector, pole: float) -> Matrix:
    """Laguerre functions of a pole applied to a signal (Wahlberg 1991), and a constant."""
    columns = [_filtered(reference, [float(np.sqrt(1.0 - pole**2)), 0.0], pole)]
    for _ in range(ORDER - 1):
        columns.append(_filtered(columns[-1], [-pole, 1.0], pole))
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
