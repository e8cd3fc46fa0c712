"""Coupled bearing equations of wheels on a free body."""

from typing import Any, NamedTuple, Self

from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import rate_of_quaternion, to_body, to_inertial
from gyrostat.spacecraft.flexible.coupling import MODE_STEP, ModalCoupling, ModalMotion
from gyrostat.wheel import Changes, CoupledBearings, Motion
from gyrostat.wheel.segment import TURN_STEP

FIXED = 1e12
"""Breakaway torque of a seized rotor, N·m."""


class Carrier(NamedTuple):
    """Motion of the body that carries the wheels.

    Attributes:
        attitude: Attitude quaternion, (4,), scalar first.
        momentum: Total momentum in inertial axes, (3,), N·m·s.
        modal: Motion of the modes; None for a rigid body.
    """

    attitude: Quaternion
    momentum: Vector3
    modal: ModalMotion | None = None

    @classmethod
    def of(cls, state: Any) -> Self:
        """Motion of the body from a `GyrostatState`."""
        modal = None
        if state.modal_momentum is not None:
            modal = ModalMotion(state.modal_coordinate, state.modal_momentum)
        return cls(state.attitude, state.momentum, modal)


class WheelsOnBody(CoupledBearings):
    """Coupled bearing equations of a spacecraft's wheels over one interval; see `Gyrostat`.

    Attributes:
        friction: Friction of the wheels.
        body: Plant with `spacecraft` and `torque`, the external torque in body axes over attitude
            and time, N·m.
        torque: Motor torques, (wheels,), N·m.
        seized: Whether each rotor is fixed to the body, (wheels,).
        added_viscous: Viscous drag in addition to the friction, (wheels,), N·m·s/rad.
        started: Time at the start of the interval, s.
        mobility: See `CoupledBearings`.
        inverse: Inverse of the inertia without that of the modes and of the rotors about their
            axes, (3, 3), 1/(kg·m²).
        inverse_locked: Inverse of the inertia without that of the modes, with all rotors locked,
            (3, 3), 1/(kg·m²).
        coupling: Coupling of the modes with the body; None for a rigid body.
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
    coupling: ModalCoupling | None = None

    @classmethod
    def of(cls, gyrostat: Any, friction: Any, **given: Any) -> Self:
        """Equations of the wheels of a `Gyrostat`.

        Args:
            gyrostat: The plant.
            friction: Friction of the wheels.
            given: The attributes `torque`, `seized`, `added_viscous` and `started`.
        """
        wheels = gyrostat.spacecraft.wheels
        axes = jnp.asarray(wheels.axes)
        rigid, coupling = gyrostat.without_modes()
        inverse = inverse_definite(jnp.asarray(rigid.inertia))
        rotors = jnp.diag(1.0 / (jnp.ones(wheels.count) * wheels.inertia))
        return cls(
            friction=friction,
            body=gyrostat,
            mobility=rotors + axes.T @ inverse @ axes,
            inverse=inverse,
            inverse_locked=inverse_definite(rigid.inertia_locked()),
            coupling=coupling,
            **given,
        )

    def rate_of_body(self, motion: Motion) -> tuple[Vector3, Vector3]:
        """Body rate, (3,), rad/s, and total momentum, (3,), N·m·s, both in body axes."""
        momentum = to_body(motion.carrier.attitude, motion.carrier.momentum)
        return self.inverse_locked @ (momentum - self._stored_momentum(motion)), momentum

    def _stored_momentum(self, motion: Motion) -> Vector3:
        """Momentum of rotors and modes beside that of the body, (3,), or its time derivative."""
        wheels = self.body.spacecraft.wheels
        momentum = jnp.asarray(wheels.axes) @ (wheels.inertia * motion.speed)
        if self.coupling is None:
            return momentum
        return momentum + self.coupling.body_part(motion.carrier.modal.momentum)

    def _relative_acceleration(self, torque: Vector3) -> PerWheel:
        """Acceleration of the wheels relative to the body by a torque on it, (wheels,), rad/s²."""
        return -jnp.asarray(self.body.spacecraft.wheels.axes).T @ (self.inverse @ torque)

    def drive(self, motion: Motion, time: Scalar) -> tuple[PerWheel, PerWheel]:
        """See `CoupledBearings.drive`."""
        rate, momentum = self.rate_of_body(motion)
        # J dw/dt = N - A (m - F)
        torque = self.body.torque(motion.carrier.attitude, self.started + time) - jnp.cross(
            rate, momentum
        )
        if self.coupling is not None:
            force = self.coupling.derivative(motion.carrier.modal, rate).momentum
            torque = torque - self.coupling.body_part(force)
        return self.torque - self.added_viscous * motion.speed, self._relative_acceleration(torque)

    def carrier_rate(self, motion: Motion, friction: PerWheel, time: Scalar) -> Carrier:
        """See `CoupledBearings.carrier_rate`."""
        attitude = motion.carrier.attitude
        rate, _ = self.rate_of_body(motion)
        torque = to_inertial(attitude, self.body.torque(attitude, self.started + time))
        modal = None
        if self.coupling is not None:
            modal = self.coupling.derivative(motion.carrier.modal, rate)
        return Carrier(rate_of_quaternion(attitude, rate), torque, modal)

    def breakaway_torque(self, direction: PerWheel) -> PerWheel:
        """See `CoupledBearings.breakaway_torque`."""
        return jnp.where(self.seized, FIXED, self.friction.breakaway_torque(direction))

    def changes(self, motion: Motion, rate: Motion, time: Scalar) -> Changes:
        """See `CoupledBearings.changes`."""
        turning, momentum = self.rate_of_body(motion)

        def outside(attitude, time):
            return self.body.torque(attitude, self.started + time)

        along = (rate.carrier.attitude, jnp.ones_like(time))
        torque, torque_change = jax.jvp(outside, (motion.carrier.attitude, time), along)
        gained = torque - jnp.cross(turning, momentum)
        change = self.inverse_locked @ (gained - self._stored_momentum(rate))
        torque_change = torque_change - jnp.cross(change, momentum) - jnp.cross(turning, gained)
        drag_change = -self.added_viscous * rate.speed
        nutation = self.inverse @ momentum
        drag = jnp.max(self.added_viscous * jnp.diagonal(self.mobility))
        fastest = jnp.maximum(turning @ turning, nutation @ nutation)
        if self.coupling is not None:
            modal_acceleration = self.coupling.derivative(rate.carrier.modal, change)
            torque_change = torque_change - self.coupling.body_part(modal_acceleration.momentum)
            modes = self.coupling.fastest_squared(self.inverse)
            fastest = jnp.maximum(fastest, (TURN_STEP / MODE_STEP) ** 2 * modes)
        return Changes(
            drive=drag_change,
            pull=self.mobility @ drag_change + self._relative_acceleration(torque_change),
            turn_squared=jnp.maximum(fastest, drag**2),
            turn_change_squared=change @ change,
        )
