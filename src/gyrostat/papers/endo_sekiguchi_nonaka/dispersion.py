"""Dispersed cases: spacecraft, momenta, sensors, initial states and wheels with limits."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.papers.endo_sekiguchi_nonaka import setup
from gyrostat.spacecraft import (
    Gyrostat,
    SinusoidalMomentum,
    Spacecraft,
    SpacecraftSensor,
    SpeedLoopSpacecraft,
    SpeedLoopState,
)
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

TORQUE, TOP_MOMENTUM, COULOMB = 0.1, 30.0, 0.9e-3
"""Torque limit, N·m, momentum limit, N·m·s, and Coulomb torque, N·m, of each wheel."""
FARTHEST, NEAREST = 150.0, 1.0
"""Limits of the initial pointing error, degrees."""
LARGEST_MOMENTUM = 0.2
"""Largest total momentum, N·m·s."""
FREQUENCIES = (1e-4, 1e-3)
"""Frequencies of the momentum, Hz."""
INERTIA_ERROR, PRODUCTS, TILT = 0.05, 0.02, np.deg2rad(0.5)
"""Relative error of a moment of inertia; product of inertia over the root of its two moments;
misalignment of a wheel axis, rad."""
WHEEL_SPEEDS = (-5.0, 0.0, 5.0)
"""Initial wheel speeds, rad/s."""
TRACKER, GYRO, TACHOMETER = np.deg2rad(10.0 / 3600.0), 5e-6, 2e-3
"""Noise of a sample: tracker, rad about each axis; gyro, rad/s; tachometer, rad/s."""
BIAS = np.deg2rad(1.0 / 3600.0)
"""Gyro bias about each axis, rad/s, of either sign."""


def body(
    total: Matrix, axes: Matrix, coulomb: float, rotors: Vector | float = setup.ROTOR
) -> Spacecraft:
    """Spacecraft with two wheels that have limits.

    Args:
        total: Inertia with locked wheels, (3, 3), kg·m².
        axes: Unit axes of the wheels, (3, 2).
        coulomb: Coulomb torque of each wheel, N·m.
        rotors: Inertia of each rotor, (2,), or of both, kg·m².
    """
    inertia = np.broadcast_to(rotors, 2)
    wheels = WheelArray(
        axes=jnp.asarray(axes),
        inertia=jnp.asarray(inertia),
        torque_limit=jnp.full(2, TORQUE),
        momentum_limit=jnp.full(2, TOP_MOMENTUM),
        friction=ViscousCoulomb(viscous=jnp.zeros(2), coulomb=jnp.full(2, coulomb)),
    )
    return Spacecraft(inertia=jnp.asarray(total - axes * inertia @ axes.T), wheels=wheels)


AS_KNOWN = body(setup.NOMINAL, np.eye(3)[:, :2], 0.0)
"""Model of the spacecraft that the controllers use."""


@dataclass(frozen=True)
class Case:
    """One dispersed run.

    Attributes:
        plant: Spacecraft with its wheels.
        start: Initial state.
        sensor: Sensors with their bias.
        angle: Initial pointing error, rad.
        quickest: Shortest possible duration T = 2 sqrt(angle j / 0.1), s: full torque for half of
            the angle, braking for the other half; j = max(Jx |nx|, Jy |ny|), with the axis n of the
            pointing error in the body.
    """

    plant: SpeedLoopSpacecraft
    start: SpeedLoopState
    sensor: SpacecraftSensor
    angle: float
    quickest: float


def case_of(
    total: Matrix,
    axes: Matrix,
    given: Callable[[Scalar], Vector3],
    quaternion: Vector,
    speeds: Vector,
    bias: Vector,
    rotors: Vector | float = setup.ROTOR,
) -> Case:
    """Run of a spacecraft with the wheels and sensors of this module.

    Args:
        total: Inertia with locked wheels, (3, 3), kg·m².
        axes: Unit axes of the wheels, (3, 2).
        given: Total momentum in inertial axes, (3,), N·m·s, at a time, s.
        quaternion: Initial attitude, (4,), scalar first.
        speeds: Initial wheel speeds, (2,), rad/s.
        bias: Gyro bias, (3,), rad/s.
        rotors: Inertia of each rotor, (2,), or of both, kg·m².
    """
    plant = SpeedLoopSpacecraft(body(total, axes, COULOMB, rotors), given)
    q0, q1, q2, q3 = quaternion
    # inertial z in body axes; body z rotates towards it about z x p
    p = np.array([2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1)])
    sine = float(np.hypot(*p))
    angle = float(np.arctan2(sine, q0**2 + q3**2 - q1**2 - q2**2))
    inertia = np.max(np.diag(total)[:2] * np.abs([p[1], p[0]])) / sine
    sensor = SpacecraftSensor(
        Gyrostat(plant.spacecraft), TRACKER, GYRO, setup.ROTOR * TACHOMETER, jnp.asarray(bias)
    )
    return Case(
        plant=plant,
        start=plant.start(attitude=quaternion, wheel_speed=speeds),
        sensor=sensor,
        angle=angle,
        quickest=float(2.0 * np.sqrt(angle * inertia / TORQUE)),
    )


def draw(count: int, seed: int) -> list[Case]:
    """Draw random cases; the first ones are the same for every count.

    Args:
        count: Number of cases.
        seed: Seed of all cases.
    """
    random = np.random.default_rng(seed)
    return [_draw_case(random) for _ in range(count)]


def inertia_of(random: np.random.Generator, error: float) -> Matrix:
    """Random inertia with locked wheels, (3, 3), kg·m².

    Args:
        random: Source of random numbers.
        error: Largest relative error of a moment of inertia.
    """
    moments = np.diag(setup.NOMINAL) * (1.0 + random.uniform(-error, error, 3))
    total = np.diag(moments)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        product = random.uniform(-PRODUCTS, PRODUCTS) * np.sqrt(moments[i] * moments[j])
        total[i, j] = total[j, i] = product
    return total


def axes_of(random: np.random.Generator, tilt: float) -> Matrix:
    """Random wheel axes near body x and y, (3, 2).

    Args:
        random: Source of random numbers.
        tilt: Angle of each axis from the body axis, rad.
    """
    columns = []
    for axis in np.eye(3)[:2]:
        normal = random.normal(size=3)
        normal -= normal @ axis * axis
        columns.append(np.cos(tilt) * axis + np.sin(tilt) * (normal / np.linalg.norm(normal)))
    return np.stack(columns, axis=1)


def _draw_case(random: np.random.Generator) -> Case:
    total, axes = inertia_of(random, INERTIA_ERROR), axes_of(random, TILT)
    direction = random.normal(size=3)
    momentum = SinusoidalMomentum(
        amplitude=jnp.asarray(
            random.uniform(0.0, LARGEST_MOMENTUM) * direction / np.linalg.norm(direction)
        ),
        frequency=float(random.choice(FREQUENCIES)),
        phase=jnp.asarray(random.uniform(0.0, 2.0 * np.pi, 3)),
    )
    # a rotation about inertial z, then by the pointing error about an orthogonal axis
    angle = np.deg2rad(random.uniform(NEAREST, FARTHEST))
    roll, azimuth = random.uniform(0.0, 2.0 * np.pi, 2)
    cosine, sine = np.cos(0.5 * angle), np.sin(0.5 * angle)
    quaternion = np.array(
        [
            cosine * np.cos(0.5 * roll),
            sine * np.cos(azimuth + 0.5 * roll),
            sine * np.sin(azimuth + 0.5 * roll),
            cosine * np.sin(0.5 * roll),
        ]
    )
    speeds = random.choice(WHEEL_SPEEDS, 2)
    return case_of(total, axes, momentum, quaternion, speeds, BIAS * random.choice((-1.0, 1.0), 3))


def paper_case() -> Case:
    """The paper's own start, from rest, with these wheels and sensors."""
    return case_of(
        setup.ACTUAL,
        np.eye(3)[:, :2],
        setup.momentum(),
        setup.attitude(),
        np.zeros(2),
        np.full(3, BIAS),
    )
