"""Observations of the change detection: numbers of a window, relative and nearly Gaussian.

The first four are the parameters of the window table, divided by a reference. A window determines
some combinations of them; what the estimator knew beforehand is taken out. The others tell faults
apart that leave the estimates alone. They are near a level of their own for a healthy wheel; the
last ones have no stated variance.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.wheel_data import REFERENCE_TEMPERATURE
from gyrostat.monitoring.windows import REGRESSED

EXTRA = ("speed_scale", "burst", "breakaway", "standstill")
"""Channels beside the estimates, each with a factor of its variance that is learnt."""
CHANNELS = (*REGRESSED, *EXTRA)
STATED = 5
"""Number of the first channels that are relative and have a stated variance in each window."""
PRIOR_SIGMA = np.array([2.0, 0.3, 0.1, 0.1])
"""Standard deviation of each channel of `EXTRA`, over the stated one, before it is learnt."""
CROSSINGS = 12
"""Crossings of a window in which the largest torque at rest is near the breakaway torque."""
LEAST = 1e-2
"""Information of a direction, relative, below which a window says nothing of it."""


@dataclass(frozen=True)
class Reference:
    """Values that the estimates are divided by, and what the estimator knew beforehand.

    Attributes:
        coulomb: Coulomb torque, N·m; offset and breakaway torque are divided by it too.
        viscous: Viscous coefficient, N·m·s/rad.
        motor_constant: N·m/A.
        offset: Offset torque that is expected, N·m.
        sigma: Standard deviations of viscous, motor_constant and offset that the estimator used
            beforehand, SI; infinite where it used none.
    """

    coulomb: float
    viscous: float
    motor_constant: float
    offset: float = 0.0
    sigma: tuple[float, float, float] = (np.inf, np.inf, np.inf)

    def scales(self) -> Vector:
        """Divisor of each of the four estimates, (4,)."""
        return np.array([self.coulomb, self.viscous, self.motor_constant, self.coulomb])

    def prior(self) -> tuple[Vector, Vector]:
        """Mean and precision that the estimator used beforehand, relative, each (4,)."""
        mean = np.array([1.0, 1.0, 1.0, self.offset / self.coulomb])
        sigma = np.array([np.inf, *self.sigma]) / self.scales()
        return mean, 1.0 / sigma**2


@dataclass(frozen=True, eq=False)
class Observation:
    """Observation of one wheel in one window: value = direction @ levels + noise.

    Attributes:
        value: Values, (M,).
        direction: Part of each channel in each value, (M, 8).
        variance: Stated variances, (M,); 1 without one. A factor is learnt.
        extras: Places in `EXTRA` of the last E values.
        temperature: Difference of the mean temperature from 20 °C, K; 0 if it is unknown.
    """

    value: Vector
    direction: Matrix
    variance: Vector
    extras: tuple[int, ...]
    temperature: float = 0.0

    @staticmethod
    def of(
        estimates: Vector,
        information: Matrix,
        extras: Vector,
        temperature: float = 0.0,
        scale_sigma: float = np.nan,
    ) -> "Observation":
        """Observation of relative values.

        Args:
            estimates: Information times estimates, (4,).
            information: Inverse covariance of the estimates, may be singular, (4, 4).
            extras: Values of `EXTRA`, (4,); NaN where the window has none.
            temperature: Difference of the mean temperature from 20 °C, K.
            scale_sigma: Standard deviation of `speed_scale`; NaN without it.
        """
        inverse, axes = np.linalg.eigh(0.5 * (information + information.T))
        used = inverse > LEAST
        inverse, axes = inverse[used], axes[:, used]
        stated = np.array([scale_sigma**2, 1.0, 1.0, 1.0])
        present = np.flatnonzero(np.isfinite(extras + stated))
        direction = np.zeros((inverse.size + present.size, len(CHANNELS)))
        direction[: inverse.size, :4] = axes.T
        direction[inverse.size + np.arange(present.size), 4 + present] = 1.0
        return Observation(
            np.concatenate([axes.T @ estimates / inverse, extras[present]]),
            direction,
            np.concatenate([1.0 / inverse, stated[present]]),
            tuple(int(k) for k in present),
            temperature,
        )


def observation(row: Mapping[str, Any], reference: Reference) -> Observation:
    """Observation of a row of the window table, without what was known beforehand.

    Estimates contain what was known beforehand, as far as the window used it. It is taken out:
    the information of the window alone is the inverse covariance less the prior's.

    Args:
        row: Row of the window table: column -> value.
        reference: Values that the estimates are divided by, and what was known beforehand.
    """
    scales = reference.scales()
    values = np.array([float(row[name]) for name in REGRESSED]) / scales
    covariance = _covariance(row, scales)
    information = np.zeros((4, 4))
    estimates = np.zeros(4)
    if row["valid"] and np.all(np.isfinite(values)) and np.all(np.isfinite(covariance)):
        mean, precision = reference.prior()
        # a window that contradicts it, or is warmer, used less of it
        known = np.array([np.inf, *(float(row[f"{name}_known"]) for name in REGRESSED[1:])])
        used = np.isfinite(known)
        precision[used] = (scales[used] / known[used]) ** 2
        inverse = np.linalg.inv(covariance)
        information = inverse - np.diag(precision)
        estimates = inverse @ values - precision * mean
    temperature = float(row["temperature_mean"]) - REFERENCE_TEMPERATURE
    return Observation.of(
        estimates,
        information,
        _extras(row, reference),
        temperature if np.isfinite(temperature) else 0.0,
        float(row["speed_scale_sigma"]),
    )


def _covariance(row: Mapping[str, Any], scales: Vector) -> Matrix:
    """Covariance of the estimates as estimates of the levels, relative, (4, 4)."""
    covariance = np.zeros((4, 4))
    for j, name in enumerate(REGRESSED):
        covariance[j, j] = float(row[f"{name}_sigma"]) ** 2
        for k in range(j + 1, 4):
            covariance[j, k] = covariance[k, j] = float(row[f"cov_{name}_{REGRESSED[k]}"])
    # the mean of the realised Coulomb torque differs from its level
    share = 2.0 * float(row["noise_time"]) / (float(row["end"]) - float(row["start"]))
    noise = float(row["noise_sigma"]) ** 2 * min(share, 1.0)
    covariance[0, 0] += noise if np.isfinite(noise) else 0.0
    return covariance / np.outer(scales, scales)


def _extras(row: Mapping[str, Any], reference: Reference) -> Vector:
    standstill = float(row["standstill_share"])
    return np.array(
        [
            float(row["speed_scale"]),
            _log(row["residual_excess"]),
            _log(row["standstill_torque"] / reference.coulomb)
            if row["crossings"] >= CROSSINGS
            else np.nan,
            np.sqrt(standstill) if standstill >= 0.0 else np.nan,
        ]
    )


def _log(value: Any) -> float:
    return float(np.log(value)) if float(value) > 0.0 else np.nan
