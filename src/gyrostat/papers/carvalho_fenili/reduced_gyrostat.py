"""Gyrostat with ideal wheels: exact in momentum, free of singularities and fast."""

from typing import Annotated, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, three
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import check_unit, normalised, rate_of_quaternion, to_body
from gyrostat.spacecraft.gyrostat_state import RateRecord, WheelTorqueCommand, too_fast
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.spacecraft_sensor import SpacecraftMeasurement


class ReducedState(NamedTuple):
    """State of a spacecraft with ideal wheels.

    Attributes:
        attitude: Attitude quaternion of the body in inertial space, (4,), scalar first.
        rotor_momentum: Inertial momentum of each rotor about its axis, (wheels,), N·m·s.
    """

    attitude: Annotated[Quaternion, "1"]
    rotor_momentum: Annotated[PerWheel, "N·m·s"]


class ReducedGyrostat(Checked):
    """R' = R [w]x, w = J^-1 (R' H - A h), h_i' = u_i, with the total momentum H given.

    Wheels have no friction; a failed wheel keeps its momentum. There is no external torque, so that
    H is a parameter. P. C. Hughes, "Spacecraft Attitude Dynamics", section 3.4, with the body rate
    eliminated.

    Attributes:
        spacecraft: Body with its wheels.
        working: Whether the motor of each wheel gives torque, (wheels,).
        total_momentum: Total momentum in inertial axes, (3,), N·m·s.
    """

    spacecraft: Spacecraft
    working: Bool[Array, " wheels"]
    total_momentum: Annotated[Vector3, three("total momentum")]

    def check_state(self, state: ReducedState) -> None:
        """Validate a state; see `Gyrostat.check_state`."""
        for name, value, size in zip(
            state._fields, state, (4, self.spacecraft.wheels.count), strict=True
        ):
            if np.shape(value)[-1:] != (size,):
                raise InputError(f"{name}: found shape {np.shape(value)}, expected ({size},)")
        check_unit(state.attitude)

    def rate(self, state: ReducedState) -> Vector3:
        """Body rate in body axes, rad/s."""
        return self._rate(state.attitude, state.rotor_momentum)

    def _rate(self, attitude, momentum) -> Vector3:
        inverse = inverse_definite(jnp.asarray(self.spacecraft.inertia))
        rotors = jnp.asarray(self.spacecraft.wheels.axes) @ momentum
        return inverse @ (to_body(attitude, self.total_momentum) - rotors)

    def relative_momentum(self, state: ReducedState) -> PerWheel:
        """Rotor inertia times speed relative to the body, N·m·s."""
        wheels = self.spacecraft.wheels
        return state.rotor_momentum - wheels.inertia * (
            jnp.asarray(wheels.axes).T @ self.rate(state)
        )

    def __call__(
        self, state: ReducedState, command: WheelTorqueCommand, time: Scalar, duration: Scalar
    ) -> tuple[ReducedState, Bool[Array, ""]]:
        """Advance by an interval of constant command, with one Runge-Kutta step of order 4.

        Args:
            state: State at the start of the interval.
            command: Motor torques; limited to the capability of the wheels.
            time: Unused.
            duration: Duration of the interval, s.

        Returns:
            State at the end of the interval, and True.
        """
        del time
        wheels = self.spacecraft.wheels
        torque = wheels.within_torque_limit(command.torque)
        torque = wheels.within_momentum_limit(torque, self.relative_momentum(state), duration)
        torque = jnp.where(self.working, torque, 0.0)

        def slope(attitude, elapsed):
            rate = self._rate(attitude, state.rotor_momentum + torque * elapsed)
            return rate_of_quaternion(attitude, rate)

        def stage(carry, node):
            previous, total = carry
            length, weight = node
            derivative = slope(state.attitude + length * previous, length)
            return (derivative, total + weight * derivative), None

        nodes = duration * jnp.array([[0.0, 1 / 6], [0.5, 1 / 3], [0.5, 1 / 3], [1.0, 1 / 6]])
        start = (jnp.zeros(4), jnp.zeros(4))
        (_, change), _ = jax.lax.scan(stage, start, nodes)
        attitude = normalised(state.attitude + change)
        return ReducedState(attitude, state.rotor_momentum + torque * duration), jnp.array(True)

    def diverged(self, state: ReducedState) -> Bool[Array, ""]:
        """Whether the body rate exceeds `FASTEST`."""
        return too_fast(self.rate(state))

    def record(self, state: ReducedState, command: WheelTorqueCommand) -> RateRecord:
        """Body rate at the start of a control period."""
        del command
        return RateRecord(self.rate(state))


class ReducedSensor(eqx.Module):
    """Error-free sensor of a reduced gyrostat.

    Attributes:
        gyrostat: Plant that is measured.
    """

    gyrostat: ReducedGyrostat

    def start(self, state: ReducedState, period: Scalar) -> None:
        """The sensor has no memory."""

    def __call__(
        self, memory: None, state: ReducedState, key: PRNGKeyArray
    ) -> tuple[None, SpacecraftMeasurement]:
        """Measure the state; the key is unused."""
        del memory, key
        momentum = self.gyrostat.relative_momentum(state)
        return None, SpacecraftMeasurement(
            attitude=state.attitude,
            rate=self.gyrostat.rate(state),
            wheel_speed=momentum / self.gyrostat.spacecraft.wheels.inertia,
            wheel_measured=jnp.ones(momentum.shape, dtype=bool),
        )
