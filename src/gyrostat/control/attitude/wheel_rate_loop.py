"""Rate loop: from a commanded body rate to torques of wheels that carry momentum."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Bool, Float

from gyrostat.control.allocation.drag_filter import lost_torque, low_passed
from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.delay_line import Sent, empty_line, is_delay, pushed
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import WheelTorqueCommand

TUMBLING = 3.0
"""Gyroscopic torque over the wheels' torque limit, above which no rate is tracked."""
DAMPING_RATIO = 2.0
"""Gain of the damping over the gain of the tracking."""


class RateLoopMemory(NamedTuple):
    """State of the rate loop between two samples.

    Attributes:
        momentum: Absolute momentum of the rotors at the last sample, (wheels,), N·m·s.
        torque: Torques commanded at the last samples, the oldest first, (delay + 1, wheels), N·m.
        drag: Estimate of the bearing drag, (wheels,), N·m.
        begun: Whether there has been a sample.
        period: Control period, s.
    """

    momentum: PerWheel
    torque: Sent
    drag: PerWheel
    begun: Bool[Array, ""]
    period: Scalar


class WheelRateLoop(Checked):
    """Rate loop of the wheels with gyroscopic feed-forward and drag compensation.

    u = A⁺ (b x w - J w_d') + k A⁺ J (w - w_d) + drag, within the limits of the wheels. A⁺ allocates
    a torque to the working wheels, w_d is the commanded rate, and b = R' H is the total momentum in
    body axes. The term A⁺ (b x w) keeps the momentum of the wheels fixed in space while the body
    turns. If this term alone exceeds the limits by far, the body tumbles. Then u_i = k' a_i.w,
    limited, reduces the kinetic energy at any limit: d(w.J w / 2)/dt = -sum u_i a_i.w. The drag is
    the torque that the rotors lose (bearings, a degraded motor constant), after a low-pass filter.

    Attributes:
        inertia: Inertia of the body without the rotors' spin inertia, (3, 3), kg·m².
        axes: Spin axes, (3, wheels); zero for failed wheels.
        allocation: Pseudo-inverse of the axes, (wheels, 3).
        rotor_inertia: Spin inertia of the rotors, (wheels,), kg·m².
        torque_limit: Torque limits, (wheels,), N·m.
        momentum_limit: Limits of the momentum relative to the body, (wheels,), N·m·s.
        gain: Rate gain k, 1/s.
        drag_time: Time constant of the drag filter, s.
        delay: Number of control periods from a sample to the start of its command.
    """

    inertia: Float[Array, "3 3"]
    axes: Float[Array, "3 wheels"]
    allocation: Float[Array, "wheels 3"]
    rotor_inertia: PerWheel
    torque_limit: PerWheel
    momentum_limit: PerWheel
    gain: Annotated[Scalar, positive("rate gain", "1/s")] = 0.8
    drag_time: Annotated[Scalar, positive("drag time", "s")] = 10.0
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    def start(self, period: Scalar) -> RateLoopMemory:
        """Initial memory."""
        zero = jnp.zeros(self.axes.shape[-1])
        torque = empty_line(zero, self.delay + 1)
        period = jnp.asarray(period, dtype=float)
        return RateLoopMemory(zero, torque, zero, jnp.array(False), period)

    def torque_along(self, direction: Vector3) -> Scalar:
        """Largest torque of the wheels along a unit vector in their span, N·m."""
        share = jnp.abs(self.allocation @ direction)
        return jnp.min(self.torque_limit / jnp.maximum(share, 1e-9))

    def torque_anywhere(self) -> Scalar:
        """Torque that the wheels can give along every direction in their span, N·m."""
        share = jnp.sqrt(jnp.sum(self.allocation**2, axis=1))
        return jnp.min(self.torque_limit / jnp.maximum(share, 1e-9))

    def room(self, momentum: PerWheel, direction: Vector3) -> tuple[Scalar, Scalar]:
        """Momentum that the wheels can still take up along a direction and against it.

        Args:
            momentum: Present momentum of the wheels, (wheels,), N·m·s.
            direction: Direction in body axes, (3,), of any length.

        Returns:
            Largest multiples of `direction` that bring no wheel beyond its limit.
        """
        share = self.allocation @ direction
        size = jnp.maximum(jnp.abs(share), 1e-9)
        up = jnp.where(share > 0.0, self.momentum_limit - momentum, self.momentum_limit + momentum)
        down = 2.0 * self.momentum_limit - up
        return jnp.maximum(jnp.min(up / size), 0.0), jnp.maximum(jnp.min(down / size), 0.0)

    def __call__(
        self,
        memory: RateLoopMemory,
        measurement: Any,
        momentum: Vector3,
        wanted: Vector3,
        acceleration: Vector3,
        following: Vector3 | None = None,
    ) -> tuple[RateLoopMemory, WheelTorqueCommand]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `rate` (3,), rad/s, and `wheel_speed` (wheels,), relative
                to the body, rad/s.
            momentum: Total momentum in body axes, (3,), N·m·s.
            wanted: Commanded body rate, (3,), rad/s.
            acceleration: Change of the commanded rate, (3,), rad/s².
            following: Further torque that the wheels shall take up in order to follow a reference,
                (3,), N·m; None for a target at rest.
        """
        rate, period = measurement.rate, memory.period
        working = jnp.any(self.axes != 0.0, axis=0)
        relative = jnp.where(working, self.rotor_inertia * measurement.wheel_speed, 0.0)
        absolute = relative + self.rotor_inertia * (self.axes.T @ rate)
        drag = self._drag(memory, absolute)
        limit = jnp.asarray(self.torque_limit)
        gyroscopic = self.allocation @ jnp.cross(momentum, rate)
        goal = relative + self.allocation @ (self.inertia @ (rate - wanted))
        goal = jnp.clip(goal, -self.momentum_limit, self.momentum_limit)
        forward = jnp.clip(-self.allocation @ (self.inertia @ acceleration), -limit / 2, limit / 2)
        tracking = gyroscopic + forward + self.gain * (goal - relative)
        if following is not None:
            tracking += self.allocation @ following
        mean_inertia = jnp.trace(self.inertia) / 3.0
        damping = DAMPING_RATIO * self.gain * mean_inertia * (self.axes.T @ rate)
        tumbles = jnp.max(jnp.abs(gyroscopic) / limit) > TUMBLING
        torque = jnp.clip(jnp.where(tumbles, damping, tracking) + drag, -limit, limit)
        lowest = (-self.momentum_limit - relative) / period
        torque = jnp.clip(torque, lowest, (self.momentum_limit - relative) / period)
        torque = jnp.where(working, jnp.clip(torque, -limit, limit), 0.0)
        line, _ = pushed(memory.torque, torque)
        next_memory = RateLoopMemory(absolute, line, drag, jnp.array(True), period)
        return next_memory, WheelTorqueCommand(torque)

    def predicted(
        self, memory: RateLoopMemory, measurement: Any, command: WheelTorqueCommand
    ) -> RateLoopMemory:
        """Memory after a period without a sample; the drag estimate is unchanged.

        The next sample does not change the drag estimate either.

        Args:
            memory: Memory from the last sample.
            measurement: Unused.
            command: Safe command that is sent.
        """
        line, _ = pushed(memory.torque, command.torque)
        return memory._replace(torque=line, begun=jnp.array(False))

    def _drag(self, memory: RateLoopMemory, absolute: PerWheel) -> PerWheel:
        loss = lost_torque(memory, absolute, memory.period)
        drag = low_passed(memory.drag, loss, self.drag_time, memory.period, memory.begun)
        # at its limits, a wheel loses torque that is not drag
        return jnp.clip(drag, -self.torque_limit / 2, self.torque_limit / 2)
