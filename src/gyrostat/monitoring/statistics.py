"""Statistics of a window that need no estimate."""

from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.wheel_data import KnownWheels

RESTS = 3
"""Smallest number of blocks at rest from which the static friction is estimated."""


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
    """Rest of the wheel, and static friction: the torque at which it still rests.

    The largest torque of a rest before the wheel moves on is below the static friction by up to the
    change within one sample.
    """
    rotor = known.wheels[wheel]
    share = blocks.rest[:, wheel]
    torque = rotor.motor_constant * blocks.slow_drive[:, wheel]
    # at least two samples at rest, and the wheel moves on within the block
    broke = (share * blocks.count >= 2.0) & (share < 1.0) & np.isfinite(torque)
    row: dict[str, Any] = {
        "standstill_share": float(np.mean(share)) if share.size else np.nan,
        "standstill_torque": float(np.max(torque, initial=0.0)),
        "static_observable": False,
    }
    if np.sum(broke) < RESTS:
        return row | {"static_reason": "the wheel does not come to rest often enough"}
    middle = float(np.median(torque[broke]))
    spread = 1.4826 * float(np.median(np.abs(torque[broke] - middle)))
    sigma = np.hypot(1.2533 * spread / np.sqrt(np.sum(broke)), rotor.sigma_of("offset"))
    return row | {
        "static": middle,
        "static_sigma": float(sigma),
        "static_scatter": float(1.2533 * spread / np.sqrt(np.sum(broke))),
        "static_observable": bool(sigma < 0.3 * middle),
        "static_reason": "" if sigma < 0.3 * middle else "its error is too large",
    }
