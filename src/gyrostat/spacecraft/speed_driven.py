"""Spacecraft with wheel speeds as input and prescribed total momentum."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, size, three
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import normalised, rate_of_quaternion, to_body
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import GyrostatState, RateRecord, too_fast
from gyrostat.spacecraft.spacecraft import Spacecraft

UNIT_LENGTH = 1e-6
"""Largest deviation of a quaternion's length from 1 that is accepted as rounding."""


def unit_quaternion(name: str, quaternion: Any) -> Quaternion:
    """Validate and normalise a quaternion.

    Args:
        name: Name of the quantity, for the error message.
        quaternion: Quaternion, (4,), scalar first.

    Raises:
        InputError: It is not four finite numbers, or its length is not 1 within `UNIT_LENGTH`.
    """
    values = np.asarray(quaternion, dtype=float)
    if values.shape != (4,) or not np.all(np.isfinite(values)):
        raise InputError(f"{name}: found {values}, expected a quaternion of four finite numbers")
    length = float(np.linalg.norm(values))
    if abs(length - 1.0) > UNIT_LENGTH:
        raise InputError(f"{name}: found a quaternion of length {length:.9g}, expected length 1")
    return jnp.asarray(values / length)


class WheelSpeedCommand(NamedTuple):
    """Speed of each wheel.

    Attributes:
        speed: Wheel speeds relative to the body, (wheels,), rad/s.
    """

    speed: Annotated[PerWheel, "rad/s"]


class SinusoidalMomentum(Checked):
    """Sinusoidal momentum H_k(t) = offset_k + amplitude_k sin(2 pi frequency t + phase_k).

    Attributes:
        amplitude: Amplitude in inertial axes, (3,), N·m·s.
        frequency: Frequency, Hz.
        phase: Phase at time zero, (3,), rad.
        offset: Constant part in inertial axes, (3,), N·m·s.
    """

    amplitude: Annotated[Vector3, three("momentum amplitude")]
    frequency: Annotated[Scalar, size("momentum frequency", "Hz")]
    phase: Annotated[Vector3, three("momentum phase")]
    offset: Annotated[Vector3, three("momentum offset")] = eqx.field(
        default_factory=lambda: np.zeros(3)
    )

    def __call__(self, time: Scalar) -> Vector3:
        """Total momentum in inertial axes, (3,), N·m·s, at a time, s."""
        turn = 2.0 * jnp.pi * self.frequency * time
        return self.offset + jnp.asarray(self.amplitude) * jnp.sin(turn + jnp.asarray(self.phase))


def started(plant: Any, attitude: Any, wheel_speed: Any) -> GyrostatState:
    """State at time zero of a spacecraft with prescribed momentum; see `SpeedDrivenSpacecraft`."""
    count = plant.spacecraft.wheels.count
    speed = jnp.broadcast_to(jnp.asarray(wheel_speed, dtype=float), (count,))
    momentum = jnp.asarray(plant.momentum(jnp.zeros(())))
    return GyrostatState(unit_quaternion("attitude", attitude), momentum, speed)


def _finite(limit: Array) -> Array:
    return jnp.where(jnp.isinf(limit), 0.0, limit)


class SpeedDrivenSpacecraft(Checked):
    """Spacecraft with wheel speeds u as input: dR/dt = R [w]x, J_t w = R^T H(t) - sum J_i a_i u_i.

    H. Endo, K. Sekiguchi, K. Nonaka, "Model error compensator for attitude control of 2-wheel
    spacecraft with on-line FRIT based tuning", (1)-(8), for any number of wheels. The total
    momentum H varies in inertial space under slow disturbance torques. Without a torque limit, a
    wheel attains its commanded speed instantly; otherwise it accelerates as a rotor on a body at
    rest under its torque limit. The motor torque for the acceleration of the body is neglected; it
    is smaller by the ratio of the inertias. For torque-driven wheels see `Gyrostat`.

    Attributes:
        spacecraft: Body and wheels; wheel friction is not used.
        momentum: Total momentum in inertial axes, time -> (3,), N·m·s. A module with array
            parameters can be stacked in a batch.
    """

    spacecraft: Spacecraft
    momentum: Callable[[Scalar], Vector3]

    def start(
        self, *, attitude: Any = (1.0, 0.0, 0.0, 0.0), wheel_speed: Any = 0.0
    ) -> GyrostatState:
        """Create the state at time zero.

        Args:
            attitude: Unit quaternion, (4,), scalar first.
            wheel_speed: Wheel speeds, (wheels,), or one value for all, rad/s.

        Raises:
            InputError: The quaternion is not of unit length.
        """
        return started(self, attitude, wheel_speed)

    def rate(self, state: GyrostatState) -> Vector3:
        """Body rate in body axes, (3,), rad/s."""
        return Gyrostat(self.spacecraft).rate(state)

    def _speed_at(self, state: GyrostatState, command: Any, elapsed: Scalar) -> PerWheel:
        wheels = self.spacecraft.wheels
        fastest = wheels.momentum_limit / wheels.inertia
        step = jnp.clip(command.speed, -fastest, fastest) - state.wheel_speed
        limit = jnp.asarray(wheels.torque_limit)
        # avoids infinity times zero: without a limit a wheel jumps at the start
        reach = jnp.where(jnp.isinf(limit), jnp.inf, _finite(limit) * elapsed / wheels.inertia)
        return state.wheel_speed + jnp.clip(step, -reach, reach)

    def __call__(
        self, state: GyrostatState, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[GyrostatState, Bool[Array, ""]]:
        """Integrate over an interval by one Runge-Kutta step of order 4.

        Args:
            state: State at the start; its momentum is not used.
            command: Constant command with `speed`, (wheels,), rad/s.
            time: Time at the start, s.
            duration: Length of the interval, s.

        Returns:
            The state at the end, and True.
        """
        wheels = self.spacecraft.wheels
        inverse = inverse_definite(self.spacecraft.inertia_locked())
        rotors = inverse @ (jnp.asarray(wheels.axes) * wheels.inertia)

        def forcing(elapsed):
            return self.momentum(time + elapsed), rotors @ self._speed_at(state, command, elapsed)

        def slope(attitude, forced):
            momentum, turned = forced
            return rate_of_quaternion(attitude, inverse @ to_body(attitude, momentum) - turned)

        first, middle, last = (forcing(part * duration) for part in (0.0, 0.5, 1.0))
        start = state.attitude
        k1 = slope(start, first)
        k2 = slope(start + 0.5 * duration * k1, middle)
        k3 = slope(start + 0.5 * duration * k2, middle)
        k4 = slope(start + duration * k3, last)
        attitude = normalised(start + duration / 6.0 * (k1 + 2.0 * (k2 + k3) + k4))
        speed = self._speed_at(state, command, duration)
        return GyrostatState(attitude, last[0], speed), jnp.array(True)

    def steady_command(self, state: GyrostatState, command: Any) -> Any:
        """Command at which the wheels keep their speeds, before the first command arrives.

        Args:
            state: State.
            command: Command with `speed`, (wheels,), rad/s, whose other fields are returned.
        """
        return command._replace(speed=state.wheel_speed)

    def diverged(self, state: GyrostatState) -> Bool[Array, ""]:
        """Whether the body turns faster than `FASTEST`."""
        return too_fast(self.rate(state))

    def record(self, state: GyrostatState, command: Any) -> RateRecord:
        """Body rate at the start of a control period, after any instant change of wheel speed."""
        acting = self._speed_at(state, command, jnp.zeros(()))
        return RateRecord(self.rate(state._replace(wheel_speed=acting)))
