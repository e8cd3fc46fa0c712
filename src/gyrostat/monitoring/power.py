"""Motor current from the electrical power of a wheel.

A motor with the constant K at the speed w takes from its supply

    P = P0 + K w i + R i²

with the current i, the idle power P0 of its drive, and the resistance R of winding and drive. This
gives the current of a motor that drives its wheel. Of a braking motor P says little: drives return
its energy, burn it or brake with energy of the supply. Braking is therefore recognised by the
deceleration of the wheel, over a block and over a few seconds of it.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.differences import BRAKING
from gyrostat.monitoring.rows import nominal_torques
from gyrostat.monitoring.wheel_data import KnownWheels

BRAKED = 0.5
"""Deceleration torque over the nominal friction above which the motor may brake."""
ABOVE = 2.0
"""Least power of nominal friction over the standard deviation of the idle power."""
ROUNDED = 5.0
"""Least power of nominal friction over its resolution: below it, rounding decides whether a motor
that hardly drives is taken for one that drives."""
FAR = 300.0
"""Power over that of nominal friction and acceleration above which it has probably another unit."""
NOISY = 3.5
"""Largest of the errors of the differences of two speeds of a block, over their sigma."""


def lacks_of(known: KnownWheels) -> Iterator[str]:
    """Values that the current from a power needs and that are not known."""
    for wheel in known.wheels:
        for name in ("idle_power", "resistance"):
            if getattr(wheel, name) is None:
                yield f"{name} of {wheel.name}"


def current_of_power(power: Matrix, speed: Matrix, known: KnownWheels) -> Matrix:
    """Motor current with the sign of its torque, (N, wheels), A.

    It is NaN where the power is not above the idle power, and for slow wheels, at which the current
    is hardly in the power.

    Args:
        power: Electrical power, (N, wheels), W.
        speed: Wheel speeds, (N, wheels), rad/s.
        known: The wheels.

    Raises:
        InputError: The idle power or the resistance of a wheel is not known.
    """
    lacking = next(lacks_of(known), None)
    if lacking is not None:
        raise InputError(f"{lacking}: found none, expected its value: the drive is the power")
    motor, idle, resistance, slowest = np.array(
        [(w.motor_constant, w.idle_power, w.resistance, w.slowest) for w in known.wheels], float
    ).T
    extra = power - idle
    fast = np.abs(speed) > slowest
    extra = np.where(fast & (extra > 0.0), extra, np.nan)
    voltage = motor * np.abs(speed)
    root = np.sqrt(voltage**2 + 4.0 * resistance * extra)
    return np.sign(speed) * 2.0 * extra / (voltage + root)


def shows_torque(blocks: Blocks, known: KnownWheels, wheel: int) -> NDArray[np.bool_]:
    """Blocks whose power shows the torque of the motor, as their speeds tell, (B,).

    The motor does not brake in them or their neighbours, and nominal friction takes a power well
    above the error of the idle power and the rounding.
    """
    rotor = known.wheels[wheel]
    slowest = blocks.slowest[:, wheel]
    lost = (rotor.coulomb + rotor.viscous * slowest) * slowest
    friction, accelerating = nominal_torques(blocks, known, wheel)
    braking = accelerating < -BRAKED * friction
    noises = blocks.speed_noise[:, wheel]
    noises = noises[np.isfinite(noises)]
    noise = NOISY * np.sqrt(2.0) * float(np.median(noises)) if noises.size else 0.0
    deceleration = blocks.deceleration[:, wheel] - (known.speed_resolution + noise) / BRAKING
    braking |= rotor.inertia * deceleration > BRAKED * friction
    near = braking.copy()
    near[1:] |= braking[:-1]
    near[:-1] |= braking[1:]
    least = max(ABOVE * rotor.sigma_of("idle_power"), ROUNDED * known.power_resolution)
    return ~near & (lost > least)


def doubt_of(blocks: Blocks, known: KnownWheels, wheel: int, friction: float) -> str:
    """Why estimates from the power do not hold; empty if they do.

    Args:
        blocks: Blocks whose power shows the torque of the motor.
        known: The wheels.
        wheel: Place of the wheel.
        friction: Upper limit of the friction at the median speed, as estimated, N·m.
    """
    rotor = known.wheels[wheel]
    speed = np.abs(blocks.speed[:, wheel])
    nominal, accelerating = nominal_torques(blocks, known, wheel)
    driving = nominal + np.maximum(accelerating, 0.0)

    def power(current: Vector) -> float:
        each = (rotor.motor_constant * speed + (rotor.resistance or 0.0) * current) * current
        return float(np.median(each))

    times = power(np.abs(blocks.drive[:, wheel])) / power(driving / rotor.motor_constant)
    if times > FAR:
        return f"the power is {times:.3g} times that of nominal friction: is its unit right?"
    share = friction / float(np.median(nominal))
    if share < BRAKED:
        return (
            f"friction is below {100.0 * share:.0f} % of the stated coulomb and viscous, by which "
            "braking is judged: state them anew"
        )
    return ""
