"""Lag of the laws behind a reference: python benchmarks/following.py [LAW ...]

The largest angle between body and target, deg, without noise, friction and external torques: at
nadir in an orbit of 500 km, and over a slew of 106 deg at 0.7 deg/s, 0.05 deg/s², 0.02 deg/s³.
"""

import dataclasses
import sys

import equinox as eqx
import numpy as np

from gyrostat.control import (
    AttitudeRegulator,
    AttitudeTargets,
    MomentumRecovery,
    WheelArrayControl,
    WheelFaultDetector,
)
from gyrostat.control.guidance import Guided, Nadir, Reference, SlewLimits, Slews, reference_at
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error_angle
from gyrostat.simulation import simulate
from gyrostat.spacecraft import CircularOrbit, Gyrostat, Spacecraft, SpacecraftSensor
from gyrostat.wheel import WheelArray, pyramid_axes

REST = np.array([1.0, 0.0, 0.0, 0.0])
CRAFT = Spacecraft(
    np.array([[0.12, 0.004, 0], [0.004, 0.10, -0.003], [0, -0.003, 0.06]]),
    WheelArray(pyramid_axes(4), np.full(4, 2e-5), np.full(4, 3e-3), np.full(4, 1.5e-2)),
)
PLANT = Gyrostat(CRAFT)
SPEEDS = np.array([200.0, -150.0, 220.0, -180.0])
LIMITS = SlewLimits(*np.radians([0.7, 0.05, 0.02]))
MOTIONS = {
    "nadir": Nadir.pointing(CircularOrbit.at_altitude(500e3, inclination=1.7, latitude=0.3)),
    "slew": Slews.to(REST, [5.0], [[0.6, 0.48, 0.0, 0.64]], LIMITS),
}


def law_of(name, start, delay):
    """A law of the package with its default gains; of the regulators, weights for this body."""
    if name == "wheel_array":
        detector = WheelFaultDetector(delay=delay)
        return WheelArrayControl(CRAFT, AttitudeTargets.hold(REST), detector=detector)
    if name == "three_axis":
        law = MomentumRecovery.plan(
            CRAFT, np.ones(4, bool), total_momentum=start.momentum, target=REST
        )
        loop = dataclasses.replace(law.law.wheels, delay=delay)
        return eqx.tree_at(lambda f: f.law.wheels, law, loop)
    regulator = AttitudeRegulator(CRAFT, jnp.asarray(REST), 1e-4, 1e-3, 1.0)
    return regulator.linear() if name == "lqr" else regulator


def largest(name, motion, period, delay):
    """Largest angle between body and target, deg; with a delay, from 75 s on."""
    first = reference_at(MOTIONS[motion], 0.0)
    start = PLANT.start(attitude=first.attitude, rate=first.rate, wheel_speed=SPEEDS)
    data = simulate(
        PLANT,
        Guided(law_of(name, start, delay), Reference.of(MOTIONS[motion]), delay),
        SpacecraftSensor(PLANT),
        start=start,
        duration=170.0,
        control_period=period,
        command_delay=delay,
    )
    angles = jax.jit(jax.vmap(error_angle))(
        jnp.asarray(data.attitude.values), jnp.asarray(data.target.values)
    )
    counted = data.time.values >= (75.0 if delay and motion == "nadir" else 0.0)
    return np.degrees(np.max(np.asarray(angles)[counted]))


if __name__ == "__main__":
    for law in sys.argv[1:] or ("wheel_array", "three_axis", "lqr", "sdre"):
        for motion in MOTIONS:
            found = [largest(law, motion, *case) for case in ((0.1, 0), (0.5, 0), (0.5, 2))]
            print(f"| {motion} | `{law}` |", *(f"{angle:.1e} |" for angle in found), flush=True)
