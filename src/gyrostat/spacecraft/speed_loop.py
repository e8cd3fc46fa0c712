"""Spacecraft with closed wheel-speed loops, including motor limits and bearing friction."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import from_rotation_vector, normalised, product, to_body
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import RateRecord, too_fast
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.speed_driven import started
from gyrostat.wheel.friction import ViscousCoulomb

SET_POINT_WEIGHT = 0.5
"""Of the set-point in the proportional part: with it, speed follows set-point as a lag of order 1,
and the torque that a ramp asks for grows to its end without overshoot."""


class SpeedLoopState(NamedTuple):
    """State of a spacecraft with wheels in speed loops.

    Attributes:
        attitude: (4,) quaternion of the body in inertial space, scalar first.
        momentum: (3,) of everything, in inertial axes, N·m·s.
        wheel_speed: (wheels,) relative to the body, rad/s; exactly zero is at rest.
        set_point: (wheels,) of the speed loops, rad/s.
        integral: (wheels,) of their speed errors, rad.
        torque_demand: (wheels,) that with the largest size in the last interval, before the limit
            of the motor, N·m.
    """

    attitude: Annotated[Quaternion, "1"]
    momentum: Annotated[Vector3, "N·m·s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    set_point: Annotated[PerWheel, "rad/s"]
    integral: Annotated[PerWheel, "rad"]
    torque_demand: Annotated[PerWheel, "N·m"]


class SpeedLoopSpacecraft(Checked):
    """H(t) = R (J w + sum a_i h_i), dh_i/dt = m_i - F_i; m_i is that of a sampled speed loop.

    The equations of `Gyrostat`, for long dispersed runs: Coulomb friction alone, and a total
    momentum that is given over time, as slow disturbance torques make it. In each tick of the loop
    the motor torques are held, so that a wheel's speed is a straight line but for the body's
    turning: passing zero, sticking and breaking away are solved for in closed form, the rest by
    the midpoint rule. That a wheel's friction changes is felt by the others through the body,
    from the next tick on. The momentum is H(t) to the last bit.

    The loop, at each tick, with the set-point led evenly from command to command:
    m = w_n^2 J_w integral(r - W) + 2 w_n J_w (r/2 - W), limited; what drives further beyond the
    limit is not summed up. It reads the speed without error.

    Attributes:
        spacecraft: the body and its wheels; their friction is `ViscousCoulomb`, not viscous.
        momentum: (time) -> (3,) total momentum in inertial axes, N·m·s.
        natural_frequency: w_n, rad/s.
        ticks: of the speed loops in an interval.
    """

    spacecraft: Spacecraft
    momentum: Callable[[Scalar], Vector3]
    natural_frequency: Annotated[Scalar, positive("speed loop natural frequency", "rad/s")] = 2.0
    ticks: int = eqx.field(static=True, default=2)

    def check_own(self) -> None:
        """Validate friction and ticks.

        Raises:
            InputError: Other friction than Coulomb's, less than one tick.
        """
        friction = self.spacecraft.wheels.friction
        if not isinstance(friction, ViscousCoulomb) or np.any(np.asarray(friction.viscous) != 0.0):
            raise InputError(
                f"wheel friction: found {type(friction).__name__}, expected ViscousCoulomb with no "
                "viscous part: Gyrostat steps the others"
            )
        if self.ticks < 1:
            raise InputError(
                f"speed loop: found {self.ticks} ticks in a period, expected 1 or more"
            )

    def check_own_period(self, period: float) -> None:
        """Refuse a control period, s, at whose ticks the speed loop is unstable.

        Raises:
            InputError: w_n times a tick is 0.8 or more: z^2 - (2 - 2 x - x^2) z + 1 - 2 x has a
                root of size 1 at x = 0.828.
        """
        share = float(np.max(np.asarray(self.natural_frequency))) * period / self.ticks
        if share >= 0.8:
            raise InputError(
                f"speed loop: found {share:.3g} rad in a tick of {period / self.ticks:g} s, "
                "expected less than 0.8: it is unstable"
            )

    def start(
        self, *, attitude: Any = (1.0, 0.0, 0.0, 0.0), wheel_speed: Any = 0.0
    ) -> SpeedLoopState:
        """A state at time zero; the loops hold the wheels at their speed.

        Args:
            attitude: (4,) unit quaternion, scalar first.
            wheel_speed: (wheels,) or one for all, rad/s. The body rate follows from the momentum.

        Raises:
            InputError: a quaternion that is not of unit length.
        """
        quaternion, momentum, speed, *_ = started(self, attitude, wheel_speed)
        # the weight of the set-point leaves this to the integral
        integral = 2.0 * (1.0 - SET_POINT_WEIGHT) * speed / self.natural_frequency
        return SpeedLoopState(quaternion, momentum, speed, speed, integral, jnp.zeros_like(speed))

    def rate(self, state: SpeedLoopState) -> Vector3:
        """Body rate in body axes, rad/s."""
        return Gyrostat(self.spacecraft).rate(state)

    def __call__(
        self, state: SpeedLoopState, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[SpeedLoopState, Bool[Array, ""]]:
        """Carry the spacecraft over an interval.

        Args:
            state: at its start.
            command: has `speed`, (wheels,) rad/s, that the set-points reach at its end.
            time: of its start, s.
            duration: s.

        Returns:
            The state at its end, and True.
        """
        wheels = self.spacecraft.wheels
        fastest = wheels.momentum_limit / wheels.inertia
        slope = (jnp.clip(command.speed, -fastest, fastest) - state.set_point) / self.ticks
        length = duration / self.ticks

        def tick(number, state):
            return self._tick(state, slope, time + number * length, length)

        start = state._replace(torque_demand=jnp.zeros(wheels.count))
        return jax.lax.fori_loop(0, self.ticks, tick, start), jnp.array(True)

    def _loop(self, state, slope, length):
        """Motor torque of a tick, and the state with set-point and integral of it."""
        wheels = self.spacecraft.wheels
        set_point = state.set_point + slope
        error = set_point - state.wheel_speed
        stiffness = wheels.inertia * self.natural_frequency**2
        damping = 2.0 * wheels.inertia * self.natural_frequency
        integral = state.integral + error * length
        proportional = damping * (SET_POINT_WEIGHT * set_point - state.wheel_speed)
        demand = stiffness * integral + proportional
        torque = jnp.clip(demand, -wheels.torque_limit, wheels.torque_limit)
        integral = jnp.where((demand - torque) * error > 0.0, state.integral, integral)
        torque = wheels.within_momentum_limit(torque, wheels.inertia * state.wheel_speed, length)
        larger = jnp.abs(demand) > jnp.abs(state.torque_demand)
        demand = jnp.where(larger, demand, state.torque_demand)
        return torque, state._replace(set_point=set_point, integral=integral, torque_demand=demand)

    def _tick(self, state, slope, time, length):
        wheels = self.spacecraft.wheels
        axes, coulomb = jnp.asarray(wheels.axes), wheels.friction.coulomb
        inverse = inverse_definite(jnp.asarray(self.spacecraft.inertia))
        torque, state = self._loop(state, slope, length)
        rate, before = self.rate(state), jnp.sign(state.wheel_speed)
        friction = jnp.where(before == 0.0, jnp.clip(torque, -coulomb, coulomb), before * coulomb)
        # rate, attitude and change of momentum in body axes in the middle of the tick
        half = 0.5 * length
        attitude = product(state.attitude, from_rotation_vector(half * rate))
        momentum, change = jax.jvp(self.momentum, (time + half,), (jnp.ones_like(time),))
        momentum = to_body(attitude, momentum)
        rotors = wheels.inertia * (state.wheel_speed + axes.T @ rate) + half * (torque - friction)
        rate = inverse @ (momentum - axes @ rotors)
        drift = to_body(attitude, change) - jnp.cross(rate, momentum)
        # speeds as straight lines, with what is left of friction at zero
        given = axes.T @ (inverse @ (axes @ (torque - friction) - drift))
        own = jnp.sum(axes * (inverse @ axes), axis=0)
        free = torque / wheels.inertia + given + own * friction
        brake = (1.0 / wheels.inertia + own) * coulomb
        speed = state.wheel_speed
        sliding = free - before * brake
        passes = before * (speed + length * sliding) <= 0.0
        at_zero = jnp.where(passes, -speed / jnp.where(sliding == 0.0, 1.0, sliding), length)
        beyond = jnp.sign(free) * jnp.maximum(jnp.abs(free) - brake, 0.0)
        speed = jnp.where(passes, beyond * (length - at_zero), speed + length * sliding)
        return state._replace(
            attitude=normalised(product(state.attitude, from_rotation_vector(length * rate))),
            momentum=self.momentum(time + length),
            wheel_speed=speed,
        )

    def diverged(self, state: SpeedLoopState) -> Bool[Array, ""]:
        """Whether the body turns faster than `FASTEST`."""
        return too_fast(self.rate(state))

    def record(self, state: SpeedLoopState, command: Any) -> RateRecord:
        """Rate at the start of a control period."""
        return RateRecord(self.rate(state))
