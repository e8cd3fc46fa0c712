"""Blocks in which a sensor holds one value although the wheel is accelerated and slowed down.

Friction may change while a wheel holds its speed, and a constant current may bring a wheel to any
speed: one change of the other quantity proves nothing, nor do torque bursts, which only brake. It
must rise and fall from one block to the next, and lie above and below its median, by a large part
of the nominal Coulomb torque each time, as in a slew.
"""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.rows import acceleration_torque, usable
from gyrostat.monitoring.wheel_data import KnownWheels

DRIVE, SPEED = 0.4, 0.6
"""Rise and fall over the nominal Coulomb torque from block to block that show a stuck drive (of the
acceleration torque) and a stuck speed (of the motor torque): torque bursts have less."""
NOISE = 10.0
"""The same over the standard deviation by noise and rounding."""


def stuck(blocks: Blocks, known: KnownWheels, wheel: int) -> NDArray[np.bool_]:
    """Blocks with a stuck sensor of current or speed, and those next to them, (B,).

    Args:
        blocks: Whole blocks of a window.
        known: The wheels.
        wheel: Place of the wheel.
    """
    rotor = known.wheels[wheel]
    drive, speed = blocks.drive[:, wheel], blocks.speed[:, wheel]
    together = ~blocks.gaps
    turning = usable(blocks, wheel, rotor.slowest)
    noise = np.maximum(blocks.speed_noise[:, wheel], known.speed_resolution)
    noise = 2.0 * rotor.inertia * noise / blocks.length
    torque = acceleration_torque(blocks, known, wheel)
    same = turning & np.isinf(blocks.step[:, wheel])
    limit = np.maximum(DRIVE * rotor.coulomb, NOISE * noise)
    found = _rises_and_falls(same, drive, together, torque, limit)
    noise = rotor.motor_constant * blocks.scatter[:, wheel] / np.sqrt(blocks.count)
    torque = rotor.motor_constant * drive
    still = (blocks.speed_noise[:, wheel] == 0.0) & (blocks.change[:, wheel] == 0.0) & turning
    limit = np.maximum(SPEED * rotor.coulomb, NOISE * noise)
    found |= _rises_and_falls(still, speed, together, torque, limit)
    # a sensor sticks, and comes free, within a block
    wide = found.copy()
    wide[1:] |= found[:-1] & together
    wide[:-1] |= found[1:] & together
    return wide


def _rises_and_falls(
    constant: NDArray[np.bool_],
    value: Vector,
    together: NDArray[np.bool_],
    torque: Vector,
    limit: Vector,
) -> NDArray[np.bool_]:
    """Runs of blocks with one value in which a torque rises and falls by more than a limit."""
    found = np.zeros(constant.size, bool)
    close = np.isclose(value[1:], value[:-1], rtol=1e-9, atol=0.0)
    same = constant[1:] & constant[:-1] & close & together
    change = np.diff(torque)
    least = np.maximum(limit[1:], limit[:-1])
    bounds = np.flatnonzero(np.diff(same, prepend=False, append=False))
    for first, last in bounds.reshape(-1, 2):
        run, changes = slice(first, last + 1), slice(first, last)
        off = torque[run] - np.nanmedian(torque[run])
        about = np.any(off > limit[run]) and np.any(off < -limit[run])
        steps = change[changes]
        if about and np.any(steps > least[changes]) and np.any(steps < -least[changes]):
            found[run] = True
    return found
