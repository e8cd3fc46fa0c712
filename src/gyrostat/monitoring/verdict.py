"""Whether the estimates of a window hold, and why not."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.estimate import APART
from gyrostat.monitoring.moments import IDLE, MOTOR
from gyrostat.monitoring.regression import Estimate
from gyrostat.monitoring.rows import nominal_torques, turns_one_way
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels

FEWEST = 30
"""Smallest number of blocks of an estimate."""
LARGEST_NOISE = 0.5
"""Friction noise over Coulomb torque above which the balance of torques does not hold."""
FAR = 100.0
"""Motor torque over that of nominal friction and acceleration above which it, or below one over
which it has probably another unit."""
CLEARLY = 3.0
"""Negative Coulomb torque, in its sigma, that is no estimate of a positive one."""
SLOWLY, OPPOSED = 0.5, 0.8
"""Accelerating torque over the stated friction, below which a motor drives its wheel, and share of
such blocks with the opposite sign above which its sign is wrong."""
IMPLAUSIBLE = 2.0
"""Motor constant over the stated one, or its inverse, above which a unit is probably wrong."""
_RPM = np.pi / 30.0
# wrong unit of the speed -> motor constant over the stated one
_MISREAD = {
    ", as if speeds in rad/s were read as rpm": _RPM,
    ", as if speeds in rpm were read as rad/s": 1.0 / _RPM,
}


def lack(
    steady: int,
    blocks: Blocks,
    wheel: int,
    slowest: float,
    left_out: Mapping[str, int],
    *,
    power: bool,
) -> str:
    """Why a window has too few usable blocks, with the number of blocks that each reason holds for.

    Args:
        steady: Number of usable blocks.
        blocks: Blocks of the window that may be usable.
        wheel: Place of the wheel.
        slowest: Speed below which a block is not used, rad/s.
        left_out: Reason -> number of other blocks.
        power: Whether the drive comes from the electrical power.
    """
    drive = np.isfinite(blocks.drive[:, wheel])
    speed = np.isfinite(blocks.other_change[:, wheel])
    slow = ~turns_one_way(blocks, wheel, slowest)
    lacking = "no power above idle_power, or too slow" if power else "no current or torque"
    counts = {
        **left_out,
        "no speed": int(np.sum(~speed)),
        lacking: int(np.sum(speed & ~drive)),
        f"a speed below {slowest:.3g} rad/s or of both signs": int(np.sum(speed & drive & slow)),
    }
    told = [f"{count} with {name}" for name, count in counts.items() if count]
    braking = int(np.sum(speed & drive & ~slow)) - steady
    if braking:
        told.append(
            f"{braking} that brake or whose friction is not well above the error of idle_power and "
            "power_resolution"
        )
    total = len(blocks) + sum(left_out.values())
    needed = f"{steady} of {total} blocks are usable, at least {FEWEST} are needed"
    return f"{needed}: {', '.join(told)}" if told else needed


def unit_doubt(blocks: Blocks, known: KnownWheels, wheel: int) -> str:
    """Why the drive is probably stuck, or has another sign or unit; empty if it seems right."""
    drive = blocks.drive[:, wheel]
    if np.all(blocks.step[:, wheel] == np.inf) and np.ptp(drive) < 1e-12:
        if not np.any(drive):
            return "the current or torque is 0 in the whole window: is the wheel driven?"
        return "the current or torque has one value in the whole window: is its sensor stuck?"
    friction, accelerating = nominal_torques(blocks, known, wheel)
    coasting = np.abs(accelerating) < SLOWLY * friction
    opposed = drive[coasting] * blocks.speed[coasting, wheel] < 0.0
    if opposed.size >= FEWEST and np.mean(opposed) > OPPOSED:
        return (
            "the drive opposes the speed where nothing else brakes the wheel: has the current the "
            "sign of its torque?"
        )
    driven = known.wheels[wheel].motor_constant * np.abs(drive)
    times = float(np.median(driven) / np.median(friction + np.abs(accelerating)))
    if 1.0 / FAR < times < FAR:
        return ""
    return (
        f"the motor torque is {times:.3g} times that of the stated friction: is the unit of "
        "current or torque right, and are motor_constant, inertia, coulomb and viscous?"
    )


def verdict(value: Estimate, rotor: KnownWheel, *, first: bool, known: bool) -> dict[str, Any]:
    """Whether the estimates hold.

    Args:
        value: Estimate.
        rotor: The wheel as stated.
        first: Whether no window before was valid: a motor constant that is far from the stated one
            from the beginning on is no fault of the motor.
        known: Whether the data agree with the stated motor constant.
    """
    why, negative = "", "the Coulomb torque is negative: has the current the sign of its torque?"
    times = value.value[MOTOR] / rotor.motor_constant
    sigma = np.sqrt(value.covariance[MOTOR, MOTOR]) / rotor.motor_constant
    certain = abs(times - 1.0) > APART * sigma
    # of a power, the gain of its measurement takes the place of the motor constant
    far = first and value.value.size <= IDLE and not 1.0 / IMPLAUSIBLE < times < IMPLAUSIBLE
    if not np.all(np.isfinite(value.value)) or value.value[MOTOR] <= 0.0:
        why = "the balance of torques has no solution with a positive motor constant"
    elif far and value.mean < 0.0 and (certain or not known):
        why = negative
    elif far and certain:
        unit = next((text for text, f in _MISREAD.items() if 0.8 < times / f < 1.25), "")
        why = (
            f"the motor constant is {times:.3g} times the stated one{unit}: are the units of "
            "speed and current right, and inertia and motor_constant?"
        )
    elif far and not known:
        why = (
            "the telemetry contradicts the stated inertia, motor_constant and viscous, but "
            "does not determine them: are the units right?"
        )
    elif value.noise_sigma > LARGEST_NOISE * abs(value.mean):
        share = 100.0 * value.noise_sigma / abs(value.mean)
        why = f"the balance of torques leaves {share:.0f} % of the Coulomb torque"
    elif value.mean < -CLEARLY * np.sqrt(value.mean_variance):
        why = negative
    return {"valid": not why, "why": why}
