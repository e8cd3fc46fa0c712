"""Statistics of a window that need no estimate."""

from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.wheel_data import KnownWheels

OFF, PEAK = 0.05, 0.5
"""Motor torque over the Coulomb torque below which a wheel that rests is switched off: the mean of
a block, and single samples, which have noise."""


def plain_columns(blocks: Blocks, wheel: int, window: tuple[float, float]) -> dict[str, Any]:
    """Samples, gaps, speed, temperature and crossings of a window."""
    present = np.isfinite(blocks.drive[:, wheel] + blocks.speed[:, wheel])
    used = float(blocks.length[present].sum()) / (window[1] - window[0])
    speed, warm = blocks.speed[:, wheel], blocks.temperature[:, wheel]
    sign = np.sign(blocks.direction[:, wheel])
    mixed = np.abs(blocks.direction[:, wheel]) < 1.0 - 1e-9
    turned = (sign[1:] * sign[:-1] < 0.0) & ~mixed[1:] & ~mixed[:-1]
    return {
        "samples": int(blocks.count[present].sum()),
        "gap_share": 1.0 - min(1.0, used),
        **_range("speed", speed),
        **_range("temperature", warm),
        "crossings": int(np.sum(mixed) + np.sum(turned)),
    }


def _range(name: str, values: Vector) -> dict[str, float]:
    present = values[np.isfinite(values)]
    if not present.size:
        return {}
    return {
        f"{name}_mean": float(present.mean()),
        f"{name}_min": float(present.min()),
        f"{name}_max": float(present.max()),
    }


def standstill_columns(blocks: Blocks, known: KnownWheels, wheel: int) -> dict[str, Any]:
    """Rest of the wheel, without the time in which it is switched off.

    The largest torque of a rest bounds the static friction from below, up to the noise of one
    sample. Between two samples the torque grows by much, so that it is no estimate.
    """
    rotor = known.wheels[wheel]
    share = blocks.rest[:, wheel]
    drive = blocks.slow_drive[:, wheel]
    mean, most = np.abs(blocks.drive[:, wheel]), rotor.coulomb / rotor.motor_constant
    off = (share >= 1.0) & (mean < OFF * most) & (drive < PEAK * most)
    torque = rotor.motor_constant * float(np.max(drive[np.isfinite(drive)], initial=0.0))
    reason = "the wheel does not come to rest"
    if torque > 0.0:
        reason = f"at least about {torque:.3g} N·m, the largest motor torque at rest"
    elif np.any(share > 0.0) and not np.any(np.isfinite(drive[share > 0.0])):
        reason = "the motor torque at rest is not known"
    return {
        "standstill_share": np.nan if off.all() else float(np.mean(share[~off])),
        "standstill_torque": torque,
        "static_observable": False,
        "static_reason": reason,
    }
