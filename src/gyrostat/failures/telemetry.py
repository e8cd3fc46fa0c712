"""Motion of a spacecraft from telemetry, and its momentum."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.failures.attitudes import matrix_of
from gyrostat.failures.query import unit_quaternion, vector
from gyrostat.spacecraft import Spacecraft


@dataclass(frozen=True)
class Telemetry:
    """Motion of a spacecraft at the failure; use `of` to validate it.

    Attributes:
        attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
        rate: Body rate in body axes, (3,), rad/s.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s.
    """

    attitude: Vector
    rate: Vector
    wheel_speed: Vector

    @staticmethod
    def of(
        spacecraft: Spacecraft, attitude: Vector, rate: Vector, wheel_speed: Vector
    ) -> "Telemetry":
        """Validate the motion, and normalise the quaternion.

        Args:
            spacecraft: Spacecraft.
            attitude: Quaternion of unit length within `query.UNIT_TOLERANCE`, (4,), scalar first.
            rate: Body rate, (3,), rad/s.
            wheel_speed: Wheel speeds, (wheels,), rad/s.

        Raises:
            InputError: A number is not finite, the quaternion is not of unit length, or a wheel is
                beyond its momentum limit.
        """
        speed: Any = vector(wheel_speed, spacecraft.wheels.count, "wheel speeds", "rad/s")
        spacecraft.wheels.check_speed(speed)
        unit = unit_quaternion(attitude, "attitude")
        return Telemetry(unit, vector(rate, 3, "rate", "rad/s"), speed)

    def wheel_momentum(self, spacecraft: Spacecraft) -> Vector:
        """Axial momentum of each rotor, J_i (W_i + a_i w), (wheels,), N·m·s.

        A wheel without torque keeps it when the body comes to rest.

        Args:
            spacecraft: Spacecraft.
        """
        axes, inertia = spacecraft.wheels.axes, spacecraft.wheels.inertia
        return np.asarray(inertia, dtype=float) * (self.wheel_speed + self.rate @ np.asarray(axes))

    def total_momentum(self, spacecraft: Spacecraft) -> Vector:
        """Total momentum R (J w + sum a_i h_i), inertial axes, (3,), N·m·s.

        J is the inertia without that of the rotors about their spin axes, h_i their axial momentum.

        Args:
            spacecraft: Spacecraft; flexible appendages are taken at rest.
        """
        axes, inertia = np.asarray(spacecraft.wheels.axes), np.asarray(spacecraft.inertia)
        in_body = inertia @ self.rate + axes @ self.wheel_momentum(spacecraft)
        return matrix_of(self.attitude) @ in_body
