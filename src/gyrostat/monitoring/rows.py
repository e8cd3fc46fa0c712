"""Rows of the regression of a wheel from the blocks of a window.

Instruments come from speed samples next to those of the regressors, so that rounding errors of both
are independent, and only from momentum that the body feels, without what friction does to it
(`instruments`).
"""

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks
from gyrostat.monitoring.drive_samples import lag_noise, sample_noise, step_variance, stepping
from gyrostat.monitoring.instruments import Motion, instruments
from gyrostat.monitoring.moments import IDLE, Prior
from gyrostat.monitoring.regression import Rows
from gyrostat.monitoring.wheel_data import (
    REFERENCE_TEMPERATURE,
    USUAL_SIGMA,
    KnownWheel,
    KnownWheels,
)

SMOOTHED = 15
"""Number of blocks of a local quadratic of the temperature."""
WARMING = 0.5
"""Range of the temperature above which viscous friction may depend on it, K."""


def acceleration_torque(blocks: Blocks, known: KnownWheels, wheel: int) -> Vector:
    """Mean torque J (dw/dt + a . dW/dt) that accelerates a rotor in each block, (B,), N·m."""
    change = blocks.change[:, wheel]
    if known.axes is not None:
        turn = blocks.turn @ known.axes[:, wheel]
        change = change + np.where(np.isfinite(turn), turn, 0.0)
    return known.wheels[wheel].inertia * change / blocks.length


def nominal_torques(blocks: Blocks, known: KnownWheels, wheel: int) -> tuple[Vector, Vector]:
    """Nominal friction and acceleration torque in the sense of the speed, each (B,), N·m."""
    rotor = known.wheels[wheel]
    friction = rotor.coulomb + rotor.viscous * np.abs(blocks.speed[:, wheel])
    sign = np.sign(blocks.direction[:, wheel])
    return friction, sign * acceleration_torque(blocks, known, wheel)


def turns_one_way(blocks: Blocks, wheel: int, slowest: float) -> NDArray[np.bool_]:
    """Blocks in which the wheel turns one way, faster than a speed in rad/s, (B,)."""
    one_way = np.abs(blocks.direction[:, wheel]) > 1.0 - 1e-9
    return one_way & (blocks.slowest[:, wheel] > slowest)


def usable(blocks: Blocks, wheel: int, slowest: float) -> NDArray[np.bool_]:
    """Blocks in which the wheel turns one way, fast enough, with all values present, (B,)."""
    present = np.isfinite(blocks.drive[:, wheel]) & np.isfinite(blocks.other_change[:, wheel])
    return turns_one_way(blocks, wheel, slowest) & present


def regression_rows(
    blocks: Blocks,
    known: KnownWheels,
    wheel: int,
    window: tuple[float, float],
    length: float,
    *,
    power: bool,
    step: float,
) -> Rows:
    """Rows of a wheel.

    Args:
        blocks: Blocks of the window that are `usable`.
        known: The wheels.
        wheel: Place of the wheel.
        window: Start and end of the window, s.
        length: Usual length of a block, s.
        power: Whether the drive comes from the electrical power.
        step: `resolution` of the drive.
    """
    rotor = known.wheels[wheel]
    sign = np.sign(blocks.direction[:, wheel])
    torque = acceleration_torque(blocks, known, wheel)
    share = known.exchanged()[wheel]
    others = np.where(np.isfinite(blocks.other_change), blocks.other_change, 0.0)
    felt = rotor.inertia * (others @ share) / blocks.length
    speed = blocks.speed[:, wheel]
    exchanged = np.where(np.isfinite(blocks.speed), blocks.speed, 0.0) @ share
    noise = max(float(np.median(blocks.speed_noise[:, wheel])), known.speed_resolution / 12.0**0.5)
    motion = Motion(
        felt=felt,
        speed=exchanged,
        sign=sign,
        explained=rotor.inertia * others[:, wheel] / blocks.length + rotor.viscous * speed,
        drive=blocks.drive[:, wheel],
        gaps=blocks.gaps,
        noise=2.0**0.5 * rotor.inertia * noise / length,
    )
    felt, exchanged, jump = instruments(motion, rotor.motor_constant)
    exchanged = exchanged + np.mean(speed - exchanged)
    one = np.ones(speed.size)
    lag = sign * blocks.drive_change[:, wheel] / blocks.length
    steps = stepping(blocks, wheel, step)
    lags = [np.where(steps, 0.0, lag), np.where(steps, lag, 0.0)]
    regressors = [torque * sign, one, np.abs(speed), sign, *lags]
    # a jump of the friction changes the current
    lags = [np.where(jump, 0.0, each) for each in lags]
    instrument = [felt * sign, one, exchanged * sign, sign, *lags]
    warm = warmth(blocks, wheel)
    if warm is not None or power:
        warm = np.zeros(speed.size) if warm is None else warm
        regressors.append(np.abs(speed) * warm)
        instrument.append(exchanged * sign * warm)
    if power:
        measured = blocks.drive[:, wheel] * sign
        regressors += _electrical(torque * sign, np.abs(speed), measured, rotor)
        instrument += _electrical(felt * sign, exchanged * sign, measured, rotor)
    sampled = sample_noise(blocks, wheel, step)
    other = motion.noise / rotor.motor_constant
    noise = np.where(steps, 0.0, sign * lag_noise(blocks, sampled))
    return Rows(
        blocks.start + 0.5 * blocks.length,
        length / blocks.length * step_variance(blocks, wheel, steps, sampled, other),
        blocks.drive[:, wheel] * sign,
        np.column_stack(regressors),
        np.column_stack(instrument),
        np.column_stack([noise, np.where(jump, 0.0, noise)]),
        *window,
    )


def _electrical(torque: Vector, speed: Vector, measured: Vector, rotor: KnownWheel) -> list[Vector]:
    """Torques for which 1 W of idle power and 1 Ohm above the stated ones pass, each (B,).

    The true current i, that of nominal friction, and the one from the power i + e obey
    K |w| e + R ((i + e)² - i²) = p, hence e = p / (K |w| + R (2 i + e)).

    Args:
        torque: Acceleration torque in the sense of the speed, (B,), N·m.
        speed: Without sign, (B,), rad/s.
        measured: Current from the power in this sense, (B,), A. Its single values contain the
            friction noise: a median stands for e.
        rotor: The wheel.
    """
    motor = rotor.motor_constant
    speed = np.maximum(speed, rotor.slowest)
    current = (torque + rotor.coulomb + rotor.viscous * speed) / motor
    voltage = motor * speed
    error = np.median((measured - current) * voltage) / voltage
    both = np.maximum(2.0 * current + error, 0.0)
    idle = motor / (voltage + (rotor.resistance or 0.0) * both)
    return [idle, current**2 * idle]


def warmth(blocks: Blocks, wheel: int) -> Vector | None:
    """Temperature over its mean, (B,), K; None where it is not known or hardly changes.

    Local quadratics smooth the steps of a rounded temperature (Savitzky and Golay, Analytical
    Chemistry 36, 1964). A plain average flattens the extremes of an orbit and lags at the ends of
    the window; viscous friction times that error returns with each orbit, unlike friction noise.
    """
    from scipy.signal import savgol_filter

    temperature = blocks.temperature[:, wheel]
    if temperature.size < SMOOTHED or not np.all(np.isfinite(temperature)):
        return None
    if np.ptp(temperature) <= WARMING:
        return None
    time = blocks.start + 0.5 * blocks.length
    count = 1 + round(np.ptp(time) / np.median(blocks.length))
    even = np.linspace(time[0], time[-1], max(count, SMOOTHED))
    smooth = np.asarray(savgol_filter(np.interp(even, time, temperature), SMOOTHED, 2))
    smooth = np.interp(time, even, smooth)
    return smooth - np.mean(smooth)


def prior_of(wheel: KnownWheel, count: int, interval: float, temperature: float) -> Prior:
    """What is known of the parameters of a wheel, in the order of `moments`.

    Args:
        wheel: The wheel.
        count: Number of parameters: 6; 7 with the effect of the temperature; 9 if the drive comes
            from the electrical power, with the errors of idle power and resistance.
        interval: Usual time between samples, s.
        temperature: Mean temperature, °C; NaN if it is not known.
    """
    mean = np.array([wheel.motor_constant, wheel.coulomb, wheel.viscous, wheel.offset, *[0.0] * 5])
    # of a power, the motor constant estimated is that of its measurement
    gain = wheel.sigma_of("power_gain") * wheel.motor_constant
    warming = wheel.sigma_of("viscous") if wheel.viscous == 0.0 else abs(wheel.viscous)
    warming *= USUAL_SIGMA["warming"]
    away = 0.0 if np.isnan(temperature) else temperature - REFERENCE_TEMPERATURE
    sigma = np.array(
        [
            gain if count > IDLE else wheel.sigma_of("motor_constant"),
            np.inf,
            np.hypot(wheel.sigma_of("viscous"), warming * away),
            wheel.sigma_of("offset"),
            *[0.5 * interval * wheel.motor_constant] * 2,
            warming,
            wheel.sigma_of("idle_power"),
            wheel.sigma_of("resistance"),
        ]
    )
    slight = mean[1] / 100.0
    least = 1e-6 * np.array(
        [mean[0], mean[1], slight, mean[1], mean[0], mean[0], slight, mean[1], 1.0]
    )
    return Prior(mean[:count], 1.0 / np.maximum(sigma, np.abs(least))[:count] ** 2)
