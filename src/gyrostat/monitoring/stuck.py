"""Blocks in which a sensor holds one value although the balance of torques says that it changes."""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.rows import nominal_torques
from gyrostat.monitoring.wheel_data import KnownWheels

FEWEST = 3
"""Smallest number of blocks, one after the other, that can show a stuck sensor."""
DRIVE, SPEED = 0.3, 0.5
"""Change of the motor torque over the nominal Coulomb torque: as nominal friction and acceleration
need it while the drive holds one value, or as the drive has it while the speed holds one. Friction
noise and wrong nominal values make less."""
ROUNDED = 10.0
"""Such changes over that of one step of the resolution."""


def stuck(blocks: Blocks, known: KnownWheels, wheel: int) -> NDArray[np.bool_]:
    """Blocks with a stuck sensor of drive or speed, and those next to them, (B,).

    Args:
        blocks: Whole blocks of a window.
        known: The wheels.
        wheel: Place of the wheel.
    """
    found = np.zeros(len(blocks), bool)
    if not len(blocks):
        return found
    rotor = known.wheels[wheel]
    drive, step = blocks.drive[:, wheel], blocks.step[:, wheel]
    friction, accelerating = nominal_torques(blocks, known, wheel)
    needed = np.sign(blocks.direction[:, wheel]) * (friction + accelerating)
    finite = step[np.isfinite(step)]
    of_drive = rotor.motor_constant * float(finite.min()) if finite.size else 0.0
    of_speed = rotor.inertia * known.speed_resolution / float(np.median(blocks.length))
    constant = np.isinf(step) & np.isfinite(drive)
    limit = max(DRIVE * rotor.coulomb, ROUNDED * of_speed, 2.0 * of_drive)
    found |= _contradicted(constant, drive, needed, limit)
    still = (blocks.speed_noise[:, wheel] == 0.0) & (blocks.change[:, wheel] == 0.0)
    still &= blocks.rest[:, wheel] == 0.0  # dry friction holds a wheel at rest
    limit = max(SPEED * rotor.coulomb, ROUNDED * of_drive, 2.0 * of_speed)
    found |= _contradicted(still, blocks.speed[:, wheel], rotor.motor_constant * drive, limit)
    # a sensor sticks, and comes free, within a block
    return np.convolve(found, np.ones(3), "same") > 0.0


def _contradicted(
    constant: NDArray[np.bool_], value: Vector, other: Vector, limit: float
) -> NDArray[np.bool_]:
    """Runs of blocks with one value during which another quantity changes by more than a limit."""
    found = np.zeros(constant.size, bool)
    close = np.isclose(value[1:], value[:-1], rtol=1e-9, atol=0.0)
    same = constant[1:] & constant[:-1] & close
    # a run ends where the next block is not the same
    bounds = np.flatnonzero(np.diff(same, prepend=False, append=False))
    for first, last in bounds.reshape(-1, 2):
        run = slice(first, last + 1)
        if last + 1 - first >= FEWEST and np.ptp(other[run]) > limit:
            found[run] = True
    return found
