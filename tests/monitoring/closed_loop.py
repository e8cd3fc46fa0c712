"""Spacecraft about one axis with a wheel and an attitude loop, written anew for the tests.

The wheel turns one way. The attitude loop is sampled with the telemetry and commands the torque
that its nominal motor constant gives; the motor has another one.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.monitoring.blocks import Samples


@dataclass(frozen=True)
class Truth:
    """Wheel of a flight: parameters and the mean Coulomb torque that acted."""

    motor_constant: float
    coulomb: float
    viscous: float
    mean: float


NOMINAL = {"inertia": 1.5e-3, "motor_constant": 0.027, "coulomb": 0.9e-3, "viscous": 5e-6}
BODY = 70.0  # kg·m²
STEP = 1.0  # s


def fly(
    seed: int,
    *,
    slews: bool,
    days: float = 1.0,
    noise: float = 0.02,
    burst: float = 0.0,
    bandwidth: float = 0.1,
) -> tuple[Samples, Truth]:
    """Telemetry of a flight at 1 Hz, rounded to 0.4 rpm and 1 mA.

    In five minutes of each hour the friction is larger, by `burst` Coulomb torques. The attitude
    loop has a bandwidth in rad/s.
    """
    random = np.random.default_rng(seed)
    motor = NOMINAL["motor_constant"] * (1.0 + 0.005 * random.standard_normal())
    coulomb = NOMINAL["coulomb"] * np.exp(0.1 * random.standard_normal())
    viscous = NOMINAL["viscous"] * np.exp(0.02 * random.standard_normal())
    count = int(days * 86400 / STEP)
    keep = np.exp(-STEP / 1200.0)
    shocks = noise * coulomb * np.sqrt(1.0 - keep**2) * random.standard_normal(count)
    slow = noise * coulomb * random.standard_normal()
    torque = 2e-6 * np.sin(2.0 * np.pi * np.arange(count) / 5700.0 + 6.0 * random.random())
    wanted = np.zeros(count)
    if slews:  # there and back, each hour
        phase = np.arange(count) % 3600.0
        pulse = np.where(phase < 400.0, np.sin(2.0 * np.pi * phase / 400.0), 0.0)
        wanted = 1e-5 * (pulse - np.roll(pulse, 1500))
    stiffness, damping = BODY * bandwidth**2, BODY * 2.0 * 0.7 * bandwidth
    angle = rate = 0.0
    speed, gained = 150.0, 0.0
    inertia = NOMINAL["inertia"]
    speeds, currents, friction = np.zeros(count), np.zeros(count), np.zeros(count)
    for k in range(count):
        slow = keep * slow + shocks[k]
        friction[k] = coulomb * (1.0 + burst * (3000.0 <= STEP * k % 3600.0 < 3300.0)) + slow
        drag = friction[k] + viscous * (speed + 0.5 * gained)  # of the mean speed of the step
        feedback = stiffness * angle + damping * rate
        nominal = NOMINAL["coulomb"] + NOMINAL["viscous"] * speed
        current = (feedback - BODY * wanted[k] + nominal) / NOMINAL["motor_constant"]
        net = motor * current - drag  # on the rotor
        acceleration = (torque[k] - net) / BODY - wanted[k]
        speeds[k], currents[k] = speed, current
        rate += STEP * acceleration
        angle += STEP * rate
        gained = STEP * net / inertia
        speed += gained
    rounding = 0.4 * np.pi / 30.0
    noisy = speeds + 0.2 * rounding * random.standard_normal(count)
    measured = currents + 5e-4 * random.standard_normal(count)
    samples = Samples(
        STEP * np.arange(count),
        (np.round(noisy / rounding) * rounding)[:, None],
        (np.round(measured / 1e-3) * 1e-3)[:, None],
    )
    return samples, Truth(motor, coulomb, viscous, float(friction.mean()))
