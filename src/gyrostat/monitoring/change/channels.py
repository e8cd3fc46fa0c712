"""Observations of the change detection: numbers of a window, relative and nearly Gaussian.

The first four are the estimates of the window table, divided by a reference; their covariance is
that of the table. The others tell faults apart that leave the estimates alone. They are near zero
or near a level of their own for a healthy wheel; their variance is learnt.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.windows import REGRESSED

EXTRA = ("burst", "crossing", "exchange", "standstill")
"""Channels whose variance is learnt."""
CHANNELS = (*REGRESSED, *EXTRA)
PRIOR_SIGMA = np.array([0.3, 0.3, 0.3, 0.1])
"""Standard deviation that a channel of `EXTRA` has before it is learnt."""
REFERENCE_TEMPERATURE = 20.0


@dataclass(frozen=True)
class Reference:
    """Values that the estimates are divided by.

    Attributes:
        coulomb: Coulomb torque, N·m; offset and crossing torque are divided by it too.
        viscous: Viscous coefficient, N·m·s/rad.
        motor_constant: N·m/A.
    """

    coulomb: float
    viscous: float
    motor_constant: float

    def scales(self) -> Vector:
        """Divisor of each of the four estimates, (4,)."""
        return np.array([self.coulomb, self.viscous, self.motor_constant, self.coulomb])


@dataclass(frozen=True, eq=False)
class Observation:
    """Observation of one wheel in one window.

    Attributes:
        value: Values of `CHANNELS`; NaN where the window has none, (8,).
        covariance: Covariance of the four estimates, (4, 4).
        temperature: Difference of the mean temperature from 20 °C, K; 0 if it is unknown.
    """

    value: Vector
    covariance: Matrix
    temperature: float = 0.0


def observation(row: Mapping[str, Any], reference: Reference) -> Observation:
    """Observation of a row of the window table.

    Args:
        row: Column -> value.
        reference: Values that the estimates are divided by.
    """
    scales = reference.scales()
    value = np.full(len(CHANNELS), np.nan)
    covariance = np.zeros((4, 4))
    for j, name in enumerate(REGRESSED):
        sigma = float(row[f"{name}_sigma"])
        if not (row["valid"] and row[f"{name}_observable"] and np.isfinite(sigma) and sigma > 0.0):
            continue
        value[j] = float(row[name]) / scales[j]
        covariance[j, j] = (sigma / scales[j]) ** 2
    for j, k in zip(*np.triu_indices(4, 1), strict=True):
        shared = float(row[f"cov_{REGRESSED[j]}_{REGRESSED[k]}"]) / (scales[j] * scales[k])
        if np.isfinite(shared) and np.isfinite(value[j] + value[k]):
            covariance[j, k] = covariance[k, j] = shared
    # the long-run level is less certain than the mean of the realised torque
    level = float(row["coulomb_level_sigma"]) / scales[0]
    if np.isfinite(level):
        covariance[0, 0] = max(covariance[0, 0], level**2)
    value[4:] = _extras(row, reference)
    temperature = float(row["temperature_mean"]) - REFERENCE_TEMPERATURE
    return Observation(value, covariance, temperature if np.isfinite(temperature) else 0.0)


def _extras(row: Mapping[str, Any], reference: Reference) -> list[float]:
    standstill = float(row["standstill_share"])
    return [
        _log(row["residual_excess"]),
        float(row["crossing_residual"]) / reference.coulomb,
        _log(row["exchange_residual"]),
        float(np.sqrt(standstill)) if standstill >= 0.0 else np.nan,
    ]


def _log(value: Any) -> float:
    return float(np.log(value)) if float(value) > 0.0 else np.nan
