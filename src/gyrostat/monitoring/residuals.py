"""Statistics of what the balance of torques of a wheel leaves: bursts and stiction."""

from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.instruments import moving_average
from gyrostat.monitoring.moments import COULOMB, MOTOR, OFFSET, VISCOUS
from gyrostat.monitoring.regression import Estimate, Rows
from gyrostat.monitoring.rows import acceleration_torque, usable
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.telemetry.signals import NORMAL_MAD

_TEN_MINUTES = 10
"""Number of blocks in the means of `residual_excess`."""


def residual_columns(
    blocks: Blocks,
    steady: Blocks,
    known: KnownWheels,
    wheel: int,
    value: Estimate,
    rows: Rows,
) -> dict[str, Any]:
    """Columns of residuals.

    Args:
        blocks: All blocks of the window.
        steady: Those of the estimate.
        known: The wheels.
        wheel: Place of the wheel.
        value: Estimate of the window.
        rows: Rows of the estimate.
    """
    residual = value.value[MOTOR] * (rows.response - rows.regressors @ value.beta)
    fast = np.diff(residual)
    means = moving_average(residual, _TEN_MINUTES)
    middle, spread = float(np.median(means)), _robust(means)
    row: dict[str, Any] = {
        "residual_rms": _robust(fast / np.sqrt(2.0)),
        "residual_kurtosis": _kurtosis(fast),
        "residual_excess": float((means.max() - middle) / max(spread, 1e-300)),
        "residual_lowest": float((means.min() - middle) / max(spread, 1e-300)),
    }
    slow = blocks.part(
        ~usable(blocks, wheel, known.wheels[wheel].slowest)
        & np.isfinite(blocks.drive[:, wheel])
        & (blocks.rest[:, wheel] < 1.0)
    )
    if len(slow):
        row["crossing_residual"] = float(np.mean(_beyond(slow, known, wheel, value)))
    return row


def _beyond(blocks: Blocks, known: KnownWheels, wheel: int, value: Estimate) -> Vector:
    """Friction torque beyond Coulomb and viscous friction, in the sense of motion, (B,), N·m."""
    level = value.value
    torque = (
        level[MOTOR] * blocks.drive[:, wheel]
        - acceleration_torque(blocks, known, wheel)
        - level[OFFSET]
        - level[VISCOUS] * blocks.speed[:, wheel]
        - level[COULOMB] * blocks.direction[:, wheel]
    )
    return torque * np.sign(blocks.direction[:, wheel])


def _robust(values: Vector) -> float:
    """Standard deviation from the median of absolute deviations."""
    return float(NORMAL_MAD * np.median(np.abs(values - np.median(values))))


def _kurtosis(values: Vector) -> float:
    """Excess kurtosis."""
    away = values - values.mean()
    variance = float(np.mean(away**2))
    return float(np.mean(away**4) / variance**2 - 3.0) if variance > 0.0 else 0.0
