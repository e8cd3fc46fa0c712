"""Dispersed recoveries with two of three wheels and almost no momentum.

A case is a gyrostat with three orthogonal wheels (0.1 N·m, 3 N·m·s, rotors of 0.01 kg·m²), one of
them seized, and an inertia of 12 kg·m² (cube) or 8, 12, 16 kg·m² about random axes (tilted), in
turn. Initial and wanted attitude are random. The target is the feasible attitude nearest to the
wanted one. At the start the wheels absorb as much momentum as they can.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat.control import ZeroMomentumRecovery
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.failures.recovery import RATE
from gyrostat.papers.blocks import in_blocks
from gyrostat.papers.carvalho_fenili import setup
from gyrostat.papers.carvalho_fenili.dispersed import BLOCK, Dispersed, fly, settling_times
from gyrostat.papers.reproduction import Say
from gyrostat.spacecraft import Gyrostat, Spacecraft, SpacecraftSensor, WheelFailures

WHEELS = setup.wheels_along_axes()
PERIOD = 0.1
"""Control period, s."""


class Requirement(NamedTuple):
    """Set of cases and its requirement.

    Attributes:
        key: Name in ids.
        least: Smallest momentum, N·m·s.
        most: Largest momentum, N·m·s.
        error: Error of the inertia in the controller, relative to the largest one.
        allowed: Allowed settling time, s.
        duration: Duration of a run, s.
        tumbling: Whether the body rotates at the start, at up to 0.05 rad/s.

    """

    key: str
    least: float
    most: float
    error: float
    allowed: float
    duration: float
    tumbling: bool = False


REQUIREMENTS = (
    Requirement("zero", 0.0, 0.0, 0.0, 105.0, 150.0),
    Requirement("zero_1pct", 0.0, 0.0, 0.01, 150.0, 200.0),
    Requirement("zero_tumbling", 0.0, 0.0, 0.0, 150.0, 200.0, tumbling=True),
    Requirement("small", 0.0, 0.01, 0.0, 200.0, 800.0),
    Requirement("small_1pct", 0.0, 0.01, 0.01, 200.0, 800.0),
    Requirement("gap", 0.01, 0.1, 0.0, 200.0, 800.0),
    Requirement("gap_1pct", 0.01, 0.1, 0.01, 200.0, 800.0),
)


def _nearest_rest(goal: Rotation, momentum: Vector, normal: Vector) -> Rotation:
    """Attitude nearest to a wanted one at which the momentum has no component along the normal."""
    body = goal.inv().apply(momentum)
    across = body - normal * (normal @ body)
    axis = np.cross(across, body)
    if np.linalg.norm(axis) < 1e-15:
        return goal
    angle = np.arctan2(np.linalg.norm(axis), across @ body)
    return goal * Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle)


def draw(random: np.random.Generator, one: Requirement, *, tilted: bool) -> Dispersed:
    """Draw one case.

    Args:
        random: Random generator.
        one: Set of the case.
        tilted: Whether the inertia is tilted.
    """
    turn = Rotation.random(rng=random).as_matrix() if tilted else np.eye(3)
    inertia = turn @ np.diag((8.0, 12.0, 16.0) if tilted else (12.0,) * 3) @ turn.T
    inertia = 0.5 * (inertia + inertia.T)
    deviation = random.normal(size=(3, 3))
    deviation = (deviation + deviation.T) / np.linalg.norm(deviation + deviation.T, 2)
    model_inertia = inertia + one.error * np.linalg.norm(inertia, 2) * deviation
    failed = int(random.integers(3))
    normal, working = np.eye(3)[failed], np.arange(3) != failed
    attitude, goal = Rotation.random(2, rng=random)
    momentum = random.normal(size=3)
    momentum *= random.uniform(one.least, one.most) / np.linalg.norm(momentum)
    target = _nearest_rest(goal, momentum, normal)
    body = attitude.inv().apply(momentum)
    locked = inertia + setup.ROTOR * np.eye(3)
    drift = locked @ normal
    rate = drift * (normal @ body) / (drift @ drift)
    if one.tumbling:
        across = random.normal(size=3)
        across -= drift * (drift @ across) / (drift @ drift)
        rate = rate + across * random.uniform(0.0, 0.05) / np.linalg.norm(across)
    failures = WheelFailures.none(3).seizes(failed, 0.0)
    plant = Gyrostat(Spacecraft(jnp.asarray(inertia), WHEELS), failures)
    wheels = np.where(working, body - locked @ rate, 0.0)
    target_quaternion = jnp.asarray(target.as_quat(scalar_first=True))
    return Dispersed(
        plant=plant,
        controller=ZeroMomentumRecovery.plan(
            Spacecraft(jnp.asarray(model_inertia), WHEELS), working, target=target_quaternion
        ),
        start=plant.start(
            attitude=attitude.as_quat(scalar_first=True),
            rate=rate,
            wheel_speed=wheels / setup.ROTOR,
        ),
        target=target_quaternion,
        allowed=one.allowed,
    )


def times(one: Requirement, cases: int, say: Say) -> Vector:
    """Settling times, (cases,), s; infinite if a case does not settle.

    Settled means below 0.05 deg and 1e-4 rad/s from then on, to the end of the run.

    Args:
        one: Set of cases.
        cases: Number of cases.
        say: Called after each block.
    """
    random = np.random.default_rng(1)
    draws = [draw(random, one, tilted=k % 2 == 1) for k in range(cases)]

    def block(chunk: list[Dispersed]) -> Vector:
        flights = fly(chunk, SpacecraftSensor, duration=one.duration, period=PERIOD)
        return settling_times(flights, RATE)

    return np.concatenate(list(in_blocks(draws, BLOCK, block, say=say, name=one.key)))
