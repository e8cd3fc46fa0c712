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
"""Weight of the set point in the proportional part. With this weight the speed follows the set
point as a first-order lag, and the torque during a ramp grows without overshoot."""


class SpeedLoopState(NamedTuple):
    """State of a spacecraft with wheel speed loops.

    Attributes:
        attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
        momentum: Total momentum in inertial axes, (3,), N·m·s.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s; exactly zero at rest.
        set_point: Set points of the speed loops, (wheels,), rad/s.
        integral: Integrals of the speed errors, (wheels,), rad.
        torque_demand: Largest torque demand in the last interval by absolute value, before the
            motor limit, (wheels,), N·m.
    """

    attitude: Annotated[Quaternion, "1"]
    momentum: Annotated[Vector3, "N·m·s"]
    wheel_speed: Annotated[PerWheel, "rad/s"]
    set_point: Annotated[PerWheel, "rad/s"]
    integral: Annotated[PerWheel, "rad"]
    torque_demand: Annotated[PerWheel, "N·m"]


class SpeedLoopSpacecraft(Checked):
    """Spacecraft with sampled wheel speed loops and prescribed total momentum H(t).

    The equations are those of `Gyrostat`, H(t) = R (J w + sum a_i h_i), dh_i/dt = m_i - F_i, with
    m_i from the speed loop. They are simplified for long dispersed runs: friction is Coulomb
    friction only, and the total momentum is given over time, as under slow disturbance torques. In
    each tick of the loop the motor torques are constant, so that each wheel speed is linear in time
    except for the effect of the body rate. Zero crossings, sticking and breakaway are solved in
    closed form, the rest by the midpoint rule. A change of friction acts on the other wheels, via
    the body, from the next tick. The momentum equals H(t) to the last bit.

    The loop interpolates the set point r linearly between commands. At each tick
    m = w_n^2 J_w integral(r - W) + 2 w_n J_w (r/2 - W), limited to the torque limit, with
    anti-windup by conditional integration. It measures the speed W without error.

    Attributes:
        spacecraft: Body and wheels; friction is `ViscousCoulomb` without viscous part.
        momentum: Total momentum in inertial axes, time -> (3,), N·m·s.
        natural_frequency: Natural frequency w_n of the speed loops, rad/s.
        ticks: Number of ticks of the speed loops in an interval.
    """

    spacecraft: Spacecraft
    momentum: Callable[[Scalar], Vector3]
    natural_frequency: Annotated[Scalar, positive("speed loop natural frequency", "rad/s")] = 2.0
    ticks: int = eqx.field(static=True, default=2)

    def check_own(self) -> None:
        """Validate friction and ticks.

        Raises:
            InputError: The friction is not Coulomb friction, or there is less than one tick.
        """
        friction = self.spacecraft.wheels.friction
        if not isinstance(friction, ViscousCoulomb) or np.any(np.asarray(friction.viscous) != 0.0):
            raise InputError(
                f"wheel friction: found {type(friction).__name__}, expected ViscousCoulomb with no "
                "viscous part: use Gyrostat for others"
            )
        if self.ticks < 1:
            raise InputError(
                f"speed loop: found {self.ticks} ticks in a period, expected 1 or more"
            )

    def check_own_period(self, period: float) -> None:
        """Validate the control period, s: the sampled speed loop must be stable.

        Raises:
            InputError: x = w_n times the length of a tick is 0.8 or more. The characteristic
                polynomial z^2 - (2 - 2 x - x^2) z + 1 - 2 x has a root of magnitude 1 at x = 0.828.
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
        """Create the state at time zero; the loops keep the wheels at their speeds.

        Args:
            attitude: Unit quaternion, (4,), scalar first.
            wheel_speed: Wheel speeds, (wheels,), or one value for all, rad/s. The body rate follows
                from the momentum.

        Raises:
            InputError: The quaternion is not of unit length.
        """
        quaternion, momentum, speed, *_ = started(self, attitude, wheel_speed)
        # steady state of the integral with a set-point weight below 1
        integral = 2.0 * (1.0 - SET_POINT_WEIGHT) * speed / self.natural_frequency
        return SpeedLoopState(quaternion, momentum, speed, speed, integral, jnp.zeros_like(speed))

    def rate(self, state: SpeedLoopState) -> Vector3:
        """Body rate in body axes, (3,), rad/s."""
        return Gyrostat(self.spacecraft).rate(state)

    def __call__(
        self, state: SpeedLoopState, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[SpeedLoopState, Bool[Array, ""]]:
        """Integrate over an interval.

        Args:
            state: State at the start.
            command: Command with `speed`, (wheels,), rad/s: the set points at the end.
            time: Time at the start, s.
            duration: Length of the interval, s.

        Returns:
            The state at the end, and True.
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
        """Motor torques of a tick, (wheels,), N·m, and the state with updated integral."""
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
        # linear speeds; at zero the wheel sticks or accelerates against the breakaway torque
        body_reaction = axes.T @ (inverse @ (axes @ (torque - friction) - drift))
        mobility = jnp.sum(axes * (inverse @ axes), axis=0)
        free = torque / wheels.inertia + body_reaction + mobility * friction
        brake = (1.0 / wheels.inertia + mobility) * coulomb
        speed = state.wheel_speed
        sliding = free - before * brake
        passes = before * (speed + length * sliding) <= 0.0
        at_zero = jnp.where(passes, -speed / jnp.where(sliding == 0.0, 1.0, sliding), length)
        acceleration = jnp.sign(free) * jnp.maximum(jnp.abs(free) - brake, 0.0)
        speed = jnp.where(passes, acceleration * (length - at_zero), speed + length * sliding)
        return state._replace(
            attitude=normalised(product(state.attitude, from_rotation_vector(length * rate))),
            momentum=self.momentum(time + length),
            wheel_speed=speed,
        )

    def steady_command(self, state: SpeedLoopState, command: Any) -> Any:
        """Command at which the wheels keep their speeds, before the first command arrives.

        Args:
            state: State.
            command: Command with `speed`, (wheels,), rad/s, whose other fields are returned.
        """
        return command._replace(speed=state.set_point)

    def diverged(self, state: SpeedLoopState) -> Bool[Array, ""]:
        """Whether the body turns faster than `FASTEST`."""
        return too_fast(self.rate(state))

    def record(self, state: SpeedLoopState, command: Any) -> RateRecord:
        """Rate at the start of a control period."""
        return RateRecord(self.rate(state))
