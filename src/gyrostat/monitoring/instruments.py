"""Accelerations and speeds of a wheel that its friction does not drive.

Friction noise and torque bursts change the speed until the attitude loop has answered them, which
takes as long as the loop is slow. Instruments must not contain this. They are moving averages of
the momentum that the body feels, plus the single blocks in which the wheel accelerates by more than
friction noise and the rounding of speeds make it: slews. Around a jump of the friction, as at the
ends of a torque burst, both are interpolated.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.telemetry.signals import NORMAL_MAD

AVERAGED = 21
"""Number of blocks in a moving average."""
FAR = 4.0
"""Fast torque in standard deviations of that which friction and rounding cause, above which it is
that of a slew."""
SHARE, JUMP = 0.5, 6.0
"""Change of the friction over the fast torque next to it, above which that is no slew, and over its
usual change, above which it is then a jump."""
NEIGHBOURS = 3
"""Number of blocks before and after a torque whose changes of the friction may cause it."""
AFTER = 5
"""Number of blocks after a jump in which the attitude loop may still answer it."""
MAJORITY = 0.5
"""Share of the fast torques that must be slews with a motor constant other than the stated one."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a wheel, one row a block.

    Attributes:
        felt: Accelerating torque that the body feels, (B,), N·m.
        speed: Speed that the body feels, (B,), rad/s.
        sign: Sign of the speed, (B,).
        explained: Accelerating torque of the wheel plus nominal viscous friction, (B,), N·m.
        drive: Drive, (B,), A.
        gaps: Whether blocks are missing between a block and the next one, (B - 1,).
        noise: Standard deviation of `felt` by noise and rounding of the speeds, N·m.
    """

    felt: Vector
    speed: Vector
    sign: Vector
    explained: Vector
    drive: Vector
    gaps: NDArray[np.bool_]
    noise: float


def instruments(motion: Motion, motor: float) -> tuple[Vector, Vector, NDArray[np.bool_]]:
    """Accelerating torque and speed without what friction causes, and blocks of jumps.

    Args:
        motion: Motion of the wheel.
        motor: Motor constant as known beforehand, N·m/A.

    Returns:
        Torque, (B,), N·m; speed, (B,), rad/s; whether the friction jumps in a block, or has jumped
        shortly before, (B,).
    """
    slew, jump = _slews(motion, motor)
    slow = moving_average(_without(jump, motion.felt))
    change = np.where(motion.gaps | slew[1:] | slew[:-1], np.diff(motion.speed), 0.0)
    slewed = np.concatenate([[0.0], np.cumsum(change)])
    speed = moving_average(_without(jump, motion.speed - slewed)) + slewed
    return np.where(slew, motion.felt, slow), speed, jump


def moving_average(values: Vector, width: int = AVERAGED) -> Vector:
    """Mean over a window around each value, shorter at the ends, (N,)."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    place = np.arange(values.size)
    low = np.maximum(place - width // 2, 0)
    high = np.minimum(place + width // 2 + 1, values.size)
    return (total[high] - total[low]) / (high - low)


def _slews(motion: Motion, motor: float) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Blocks of slews, and blocks of jumps of the friction, each (B,).

    A torque burst accelerates the wheel as a slew does, but the Coulomb torque changes by at least
    as much. Where it changes next to most fast torques, the motor constant with which it would not
    is tried.
    """
    explained, drive = motion.sign * motion.explained, motion.sign * motion.drive
    fast = motion.sign * (motion.felt - moving_average(motion.felt))
    slew, jump, far = _fast(fast, motor * drive - explained, motion.noise)
    if not np.any(far):
        return slew, jump
    near = far[1:] | far[:-1]
    motor = _proportion(np.diff(explained)[near], np.diff(drive)[near])
    other_slew, other_jump, far = _fast(fast, motor * drive - explained, motion.noise)
    if np.sum(other_slew) > max(np.sum(slew), MAJORITY * np.sum(far)):
        return other_slew, other_jump
    return slew, jump


def _fast(
    fast: Vector, friction: Vector, noise: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Blocks of slews, blocks of jumps, and blocks with a fast torque, each (B,).

    Args:
        fast: Accelerating torque away from its moving average, in the sense of the speed, (B,),
            N·m.
        friction: Coulomb torque, positive, (B,), N·m.
        noise: Standard deviation of the torque by noise of the speeds, N·m.
    """
    usual = NORMAL_MAD * float(np.median(np.abs(np.diff(friction)))) if friction.size > 1 else 0.0
    reach = np.max(_near(np.abs(fast)), axis=0)
    spread = np.ptp(_near(friction), axis=0)
    steady = spread < SHARE * reach
    jump = ~steady & (spread > JUMP * usual)
    jump = np.convolve(jump, np.ones(AFTER + 1))[: jump.size] > 0.0
    calm = ~jump & (np.abs(fast) <= FAR * usual)
    caused = usual
    width = 2 * NEIGHBOURS + 1
    if np.sum(calm) > 2 * width:
        # friction slows the wheel until the attitude loop has answered it
        change = np.pad(np.diff(friction, prepend=friction[0]), NEIGHBOURS)
        changes = np.lib.stride_tricks.sliding_window_view(change, width)[calm]
        gain, *_ = np.linalg.lstsq(changes.T @ changes, changes.T @ fast[calm])
        by_chance = np.std(fast[calm]) * np.sqrt(width / np.sum(calm))
        caused = min(float(np.std(changes @ gain) + by_chance), usual)
    # rounding errors of neighbouring samples are alike at a speed that hardly changes
    far = np.abs(fast) > FAR * max(caused, noise)
    return far & steady & ~jump, jump, far


def _near(values: NDArray[Any]) -> NDArray[Any]:
    """Values before, at and after each block, (3, B)."""
    wide = np.concatenate([values[:1], values, values[-1:]])
    return np.stack([wide[:-2], wide[1:-1], wide[2:]])


def _without(jump: NDArray[np.bool_], values: Vector) -> Vector:
    """Values, interpolated over jumps, (B,)."""
    place = np.arange(values.size)
    return values if np.all(jump) else np.interp(place, place[~jump], values[~jump])


def _proportion(torque: Vector, drive: Vector) -> float:
    """Factor with the least sum of absolute deviations: a weighted median of ratios."""
    torque, drive = torque[drive != 0.0], drive[drive != 0.0]
    if not drive.size:
        return 0.0
    order = np.argsort(torque / drive)
    weight = np.cumsum(np.abs(drive[order]))
    middle = order[np.searchsorted(weight, 0.5 * weight[-1])]
    return float(torque[middle] / drive[middle])
