"""The wheels of a spacecraft as dry contacts between rotors and body."""

from typing import Any, NamedTuple

from jaxtyping import Array, Bool, Float

from gyrostat._jax import jnp
from gyrostat.body.rotations import Quaternion, Vector, rate_of_quaternion, to_body, to_inertial
from gyrostat.friction import Scalar
from gyrostat.wheel import Contacts, Motion, PerWheel

TURN_STEP = 0.02
"""rad: largest turn of body or total momentum in one Runge-Kutta step; its error is below 1e-12."""
FIXED = 1e12
"""N·m: what holds a seized rotor."""


class Carrier(NamedTuple):
    """Attitude of the body, and total momentum in inertial axes, N·m·s."""

    attitude: Quaternion
    momentum: Vector


class WheelsOnBody(Contacts):
    """The wheels of a spacecraft over one interval; see `Gyrostat`.

    Attributes:
        friction: of the wheels.
        body: has `spacecraft`, and `torque`: external, in body axes, over attitude and time, N·m.
        torque: (wheels,) of the motors, N·m.
        seized: (wheels,) which rotors are fixed to the body.
        added_viscous: (wheels,) drag beside the friction, N·m·s/rad.
        started: time of the start of the interval, s.
        mobility: see `Contacts`.
        inverse: (3, 3) of the body's inertia without that of the rotors about their axes,
            1/(kg·m²).
        inverse_locked: (3, 3) of the inertia with all rotors locked, 1/(kg·m²).
    """

    friction: Any
    body: Any
    torque: PerWheel
    seized: Bool[Array, " wheels"]
    added_viscous: PerWheel
    started: Scalar
    mobility: Float[Array, "wheels wheels"]
    inverse: Float[Array, "3 3"]
    inverse_locked: Float[Array, "3 3"]

    def rate_of_body(self, motion: Motion) -> tuple[Vector, Vector]:
        """Body rate, and total momentum in body axes."""
        wheels = self.body.spacecraft.wheels
        momentum = to_body(motion.carrier.attitude, motion.carrier.momentum)
        rotors = jnp.asarray(wheels.axes) @ (wheels.inertia * motion.speed)
        return self.inverse_locked @ (momentum - rotors), momentum

    def drive(self, motion: Motion, time: Scalar) -> tuple[PerWheel, PerWheel]:
        """See `Contacts.drive`."""
        rate, momentum = self.rate_of_body(motion)
        # J dw/dt = N - A (m - F): what the wheels feel of N is the body turning under them
        torque = self.body.torque(motion.carrier.attitude, self.started + time) - jnp.cross(
            rate, momentum
        )
        drift = -jnp.asarray(self.body.spacecraft.wheels.axes).T @ (self.inverse @ torque)
        return self.torque - self.added_viscous * motion.speed, drift

    def carrier_rate(self, motion: Motion, friction: PerWheel, time: Scalar) -> Carrier:
        """See `Contacts.carrier_rate`."""
        attitude = motion.carrier.attitude
        rate, _ = self.rate_of_body(motion)
        torque = to_inertial(
            attitude, self.body.torque(motion.carrier.attitude, self.started + time)
        )
        return Carrier(rate_of_quaternion(attitude, rate), torque)

    def breakaway_torque(self, direction: PerWheel) -> PerWheel:
        """See `Contacts.breakaway_torque`."""
        return jnp.where(self.seized, FIXED, self.friction.breakaway_torque(direction))

    def longest_segment(self, motion: Motion, rate: Motion, time: Scalar) -> Scalar:
        """See `Contacts.longest_segment`."""
        wheels = self.body.spacecraft.wheels
        turning, momentum = self.rate_of_body(motion)
        nutation = self.inverse @ momentum
        fastest = jnp.sqrt(jnp.maximum(turning @ turning, nutation @ nutation))
        drag = jnp.max(self.added_viscous * jnp.diagonal(self.mobility))
        gained = to_body(motion.carrier.attitude, rate.carrier.momentum)
        gained -= jnp.cross(turning, momentum)
        gained -= jnp.asarray(wheels.axes) @ (wheels.inertia * rate.speed)
        change = self.inverse_locked @ gained
        # root of fastest t + |change| t²/2 = TURN_STEP: a body at rest may be set turning
        frequency = jnp.maximum(fastest, drag) / TURN_STEP
        frequency += jnp.sqrt(frequency**2 + 2.0 * jnp.sqrt(change @ change) / TURN_STEP)
        return 2.0 / jnp.maximum(frequency, 1e-9)
