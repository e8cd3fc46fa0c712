"""Statistics of what the balance of torques leaves: bursts, stiction, faults of a tachometer."""

from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.estimate import Estimate, Rows
from gyrostat.monitoring.moments import COULOMB, MOTOR, OFFSET, VISCOUS
from gyrostat.monitoring.rows import acceleration_torque, moving_average, usable
from gyrostat.monitoring.wheel_data import KnownWheels

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
        "exchange_residual": _exchange(blocks, known, wheel),
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


def _exchange(blocks: Blocks, known: KnownWheels, wheel: int) -> float:
    """Rms torque along an axis that neither body nor wheels account for, N·m; NaN if not known."""
    if known.axes is None or known.inertia is None or not len(blocks):
        return np.nan
    share = known.rotor_inertia
    length = blocks.length[:, None]
    wheels = ((blocks.change * share) @ known.axes.T) / length
    locked = known.inertia + (known.axes * share) @ known.axes.T
    body = (blocks.turn @ locked) / length
    momentum = blocks.rate @ locked + (blocks.speed * share) @ known.axes.T
    torque = wheels + body + np.cross(blocks.rate, momentum)
    along = torque @ known.axes[:, wheel]
    along = along[np.isfinite(along)]
    return float(np.sqrt(np.mean(along**2))) if along.size else np.nan


def _robust(values: Vector) -> float:
    """Standard deviation from the median of absolute deviations."""
    return float(1.4826 * np.median(np.abs(values - np.median(values))))


def _kurtosis(values: Vector) -> float:
    """Excess kurtosis."""
    away = values - values.mean()
    variance = float(np.mean(away**2))
    return float(np.mean(away**4) / variance**2 - 3.0) if variance > 0.0 else 0.0
