"""Detumbling by torque rods: the B-cross law."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.measured import measured
from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import Spacecraft

LEAST_FIELD = 1e-9
"""Flux density below which the dipole is reduced, T; the field of an Earth orbit is far above."""


class RodCommand(NamedTuple):
    """Commands to wheels and torque rods.

    Attributes:
        torque: Motor torques of the wheels, (wheels,), N·m.
        torque_rods: Dipole moments of three rods along the body axes, (3,), A·m².
    """

    torque: Annotated[PerWheel, "N·m"]
    torque_rods: Annotated[Vector3, "A·m²"]


class BCrossMemory(NamedTuple):
    """State of the law between two samples.

    Attributes:
        speed: Wheel speeds to hold, at the first sample, (wheels,), rad/s.
        begun: Whether there has been a sample.
    """

    speed: PerWheel
    begun: Bool[Array, ""]


def rod_dipole(momentum: Vector3, field: Vector3) -> Vector3:
    """Dipole moment over gain, h x B / |B|², whose torque is -h without its part along B.

    Args:
        momentum: Momentum h to be reduced, (3,), N·m·s; in general any vector.
        field: Flux density B, (3,), T.

    Returns:
        The dipole moment of a gain of 1 1/s, (3,), A·m².
    """
    return jnp.cross(momentum, field) / jnp.maximum(field @ field, LEAST_FIELD**2)


class BCross(Checked):
    """Dipole moment m = (k / |B|²) w x B, from measured field B and body rate w.

    The torque is -k times the part of w across B. The kinetic energy of the body therefore never
    increases, and it decreases unless the body turns about B: w.T = -k |B x w|² / |B|². This also
    holds if the rods are limited. G. Avanzini, F. Giulietti, "Magnetic detumbling of a rigid
    spacecraft", Journal of Guidance, Control, and Dynamics 35 (2012); F. L. Markley, J. L.
    Crassidis, "Fundamentals of Spacecraft Attitude Determination and Control", section 7.5.1.

    The wheels get no torque, or hold the speed of the first sample by m_i = g J_i (W_0 - W). The
    field is that of the sensor `magnetometer`. The law does not use the attitude.

    Attributes:
        spacecraft: Spacecraft model of the controller.
        gain: Gain k, N·m·s; see `design`.
        speed_gain: Gain g of the wheels' speed, 1/s; 0: no torque.
    """

    spacecraft: Spacecraft
    gain: Annotated[Scalar, positive("gain of the detumbling", "N·m·s")]
    speed_gain: Annotated[Scalar, size("speed gain of the detumbling", "1/s")] = 0.0

    @classmethod
    def design(
        cls, spacecraft: Spacecraft, rate: float, inclination: float, speed_gain: float = 0.0
    ) -> "BCross":
        """Law with the gain k = 2 n (1 + sin i) J_min of Avanzini and Giulietti.

        Args:
            spacecraft: Spacecraft model of the controller.
            rate: Mean motion n of the orbit, rad/s.
            inclination: Inclination i of the orbit to the geomagnetic equator, rad.
            speed_gain: Gain g of the wheels' speed, 1/s.
        """
        gain = 2.0 * rate * (1.0 + float(np.sin(inclination))) * least_inertia(spacecraft)
        return cls(spacecraft, gain, speed_gain)

    # earlier name
    designed = design

    def start(self, period: Scalar) -> BCrossMemory:
        """Initial memory."""
        return BCrossMemory(jnp.zeros(self.spacecraft.wheels.count), jnp.array(False))

    def __call__(self, memory: BCrossMemory, measurement: Any) -> tuple[BCrossMemory, RodCommand]:
        """Compute the dipole moments and the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `magnetometer` (3,), T, `rate` (3,), rad/s, and
                `wheel_speed` (wheels,), rad/s.

        Raises:
            InputError: The measurement has no field `magnetometer`.
        """
        field = measured(measurement, "magnetometer", "detumbling")
        wheels, speed = self.spacecraft.wheels, measurement.wheel_speed
        target_speed = jnp.where(memory.begun, memory.speed, speed)
        torque = self.speed_gain * wheels.inertia * (target_speed - speed)
        dipole = self.gain * rod_dipole(measurement.rate, field)
        command = RodCommand(wheels.within_torque_limit(torque), dipole)
        return BCrossMemory(target_speed, jnp.array(True)), command


def least_inertia(spacecraft: Spacecraft) -> float:
    """Smallest principal inertia J_min of a spacecraft with its wheels locked, kg·m²."""
    return float(np.linalg.eigvalsh(np.asarray(spacecraft.inertia_locked()))[0])
