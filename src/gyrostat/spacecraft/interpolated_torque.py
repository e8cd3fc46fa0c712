"""External torques over one interval, interpolated so that each is evaluated twice only."""

from typing import Any

import equinox as eqx

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector, product, rate_of_quaternion
from gyrostat.spacecraft.spacecraft import Spacecraft


class InterpolatedTorque(eqx.Module):
    """External torque of a body as a quadratic function of time within one interval.

    The quadratic has the value and slope of the torque at the start and its value at the end, with
    the attitude there extrapolated by rate and acceleration. The error within an interval of length
    t is of third order: (w t)³ / 40 of the torque at the rate w, such as 2e-8 at 2 deg/s in 0.25 s.

    Attributes:
        spacecraft: Body and wheels.
        body: Plant with the torques `exact_torque` over attitude and time, not interpolated.
        started: Time at the start, s.
        start: Torque at the start, (3,), N·m.
        slope: Its time derivative, (3,), N·m/s.
        bend: Coefficient of the square of time, (3,), N·m/s².
    """

    spacecraft: Spacecraft
    body: Any
    started: Scalar
    start: Vector3
    slope: Vector3
    bend: Vector3

    @classmethod
    def over(
        cls,
        body: Any,
        attitude: Quaternion,
        rate: Vector3,
        acceleration: Vector3,
        time: Scalar,
        duration: Scalar,
    ) -> "InterpolatedTorque":
        """Interpolate the torque `slow_torque` of a plant over an interval.

        Args:
            body: Plant.
            attitude: Attitude at the start, (4,).
            rate: Body rate at the start, (3,), rad/s.
            acceleration: Its derivative without external torque, body axes, (3,), rad/s².
            time: Time at the start, s.
            duration: Length of the interval, s.
        """
        along = (rate_of_quaternion(attitude, rate), jnp.ones_like(time))
        start, slope = jax.jvp(body.slow_torque, (attitude, time), along)
        turn = duration * (rate + 0.5 * duration * acceleration)
        end = body.slow_torque(product(attitude, from_rotation_vector(turn)), time + duration)
        length = jnp.where(duration > 0.0, duration, 1.0)
        bend = (end - start - duration * slope) / length**2
        return cls(body.spacecraft, body, time, start, slope, bend)

    def torque(self, attitude: Quaternion, time: Scalar) -> Vector3:
        """External torque in body axes, (3,), N·m, at a time, s."""
        since = time - self.started
        return self.body.exact_torque(attitude, time) + (
            self.start + since * (self.slope + since * self.bend)
        )
