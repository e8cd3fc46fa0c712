"""Three wheels with dry friction that point a body: one run of three_wheels.py as a function."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from gyrostat.core import rotations
from gyrostat.core.jax64 import jnp
from gyrostat.simulation import control_loop
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.spacecraft.gyrostat_state import GyrostatState, WheelTorqueCommand
from gyrostat.wheel import WheelArray, read_wheel_sheet
from gyrostat.wheel.friction import Stribeck

PERIOD, SETTLED = 0.01, 100.0
"""s: of control, and from when on the largest error counts."""
SHEET = read_wheel_sheet("sunspace-0.65").values
LOCKED = np.array([[18.0, 0.3, -0.2], [0.3, 16.0, 0.1], [-0.2, 0.1, 15.0]])
CRAFT = {
    "inertia": LOCKED.tolist(),  # with the rotors locked
    "rotor": SHEET["inertia"],
    **{name: SHEET[name] for name in ("viscous", "coulomb", "static", "stribeck_speed")},
    "torque": [1e-4, -5e-5, 2e-5],
    "proportional": 0.72,
    "derivative": 3.6,
}


class Drawn(NamedTuple):
    """The parameters of one run.

    Attributes:
        attitude: (4,) at first, quaternion, scalar first; (1, 0, 0, 0) is wanted.
        rate: (3,) at first, body axes, rad/s.
        wheel_speed: (3,) at first, rad/s.
        friction: (3,) factors on the dry friction of each wheel; 0: not even viscous friction.
    """

    attitude: Any
    rate: Any
    wheel_speed: Any
    friction: Any


class Flown(NamedTuple):
    """The results of one run.

    Attributes:
        mean_square: of the vector part of the quaternion.
        peak_square: largest square from `SETTLED` on.
        state: at the end.
    """

    mean_square: Any
    peak_square: Any
    state: GyrostatState


class Seen(NamedTuple):
    attitude: Any
    rate: Any


class Sensor(eqx.Module):
    """Attitude and rate as they are."""

    plant: Gyrostat

    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, Seen(state.attitude, self.plant.rate(state))


class Law(eqx.Module):
    """u = K s + P w of modified Rodrigues parameters s and rate w: its reaction slows both."""

    proportional: float = CRAFT["proportional"]
    derivative: float = CRAFT["derivative"]

    def start(self, period):
        return ()

    def __call__(self, memory, seen):
        mrp = rotations.to_mrp(seen.attitude)
        return memory, WheelTorqueCommand(self.proportional * mrp + self.derivative * seen.rate)


def parts(drawn):
    """Plant, controller, sensor and first state of a run."""
    each = jnp.ones(3)
    friction = Stribeck(
        viscous=CRAFT["viscous"] * jnp.sign(drawn.friction),
        coulomb=CRAFT["coulomb"] * drawn.friction,
        static=CRAFT["static"] * drawn.friction,
        stribeck_speed=CRAFT["stribeck_speed"] * each,
    )
    wheels = WheelArray(axes=np.eye(3), inertia=CRAFT["rotor"] * np.ones(3), friction=friction)
    body = Spacecraft(LOCKED - CRAFT["rotor"] * np.eye(3), wheels)
    plant = Gyrostat(body, external_torque=np.array(CRAFT["torque"]))
    start = plant.start(attitude=drawn.attitude, rate=drawn.rate, wheel_speed=drawn.wheel_speed)
    return plant, Law(), Sensor(plant), start


def fly(drawn, key, count):
    """One run of `count` control periods: `Drawn` -> `Flown`; pure, for any engine.

    The key is of noise, of which there is none.
    """
    *items, start = parts(drawn)

    def fold(kept, row, k):
        vector = row.state.attitude[1:]
        square = vector @ vector
        peak = jnp.where(
            k * PERIOD >= SETTLED, jnp.maximum(kept.peak_square, square), kept.peak_square
        )
        return Flown(kept.mean_square + square / (count + 1), peak, row.state), None

    first = Flown(jnp.zeros(()), jnp.zeros(()), start)
    loop = control_loop(*items, start, key, PERIOD).folded(fold, first)
    (_, kept), _ = loop.scan(loop.begin(), jnp.array(0), count + 1)
    return kept


def draw(runs, seed=0):
    """Dispersed runs, first axis."""
    random = np.random.default_rng(seed)
    turn = 0.05 * random.standard_normal((runs, 3))
    attitude = np.concatenate([np.ones((runs, 1)), 0.5 * turn], axis=1)
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    rate = 3e-3 * random.standard_normal((runs, 3))
    speed = 20.0 * random.standard_normal((runs, 3))
    return Drawn(attitude, rate, speed, random.uniform(0.8, 1.2, (runs, 3)))
