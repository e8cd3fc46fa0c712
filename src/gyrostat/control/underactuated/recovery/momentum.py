"""Recovery law that controls the attitude by two or more wheels and the total momentum."""

from dataclasses import replace
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Bool, Float
from numpy.typing import ArrayLike

from gyrostat.control.allocation.working_wheels import SPAN, WorkingWheels
from gyrostat.control.attitude.external_torque import ExternalTorqueMemory
from gyrostat.control.attitude.three_axis_law import ThreeAxisLaw
from gyrostat.control.attitude.wheel_rate_loop import RateLoopMemory, WheelRateLoop
from gyrostat.control.guidance.guide import AT_REST, Guide
from gyrostat.control.underactuated.momentum_angles import momentum_frame
from gyrostat.control.underactuated.recovery.momentum_estimate import MomentumEstimate
from gyrostat.control.underactuated.two_wheel_law import NO_WAY, TwoWheelLaw, Way
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, limit
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_trees import stored_tree_function
from gyrostat.spacecraft import Spacecraft, WheelTorqueCommand

LEAST_AUTHORITY = 1e-3
"""Smallest share of the momentum across the normal; below it the third axis is not controllable."""


class MomentumRecoveryMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        wheels: Memory of the rate loop.
        way: Present path to the target.
        external: Estimate of the external torque; None if it is not estimated.
        total: Estimate of the total momentum; None if it is not estimated.
    """

    wheels: RateLoopMemory
    way: Way
    external: ExternalTorqueMemory | None = None
    total: MomentumEstimate | None = None


class MomentumRecovery(Checked):
    """Recovery to rest at a feasible attitude, from any initial motion.

    The law gives a rate for each attitude. The change of this rate along the measured motion is the
    feed-forward acceleration, and the rate loop computes the torques. The momentum of the failed
    wheels along the normal is measured, since it changes while they run down. If their sensors are
    lost, the value that they will have at the target is used. The value is not computed from rate
    and inertia: if the momentum is small, an inertia error of 5 % would make the loop unstable.

    If two directions are left, the expected time is 100 s + 15 J / rho, with the largest inertia J
    and the momentum rho across the normal n at the target, N·m·s. A failed wheel that runs down
    with the time constant tau changes the feasible attitudes until its momentum h along its axis a
    is gone. To a tolerance of e rad that takes tau ln(h |n.a| / (rho e)); the longer of both times
    applies.

    Attributes:
        law: Law that gives the rate for each attitude.
        normal: Normal to the working axes, (3,); zero if they span space.
        failed_axes: Axes of failed wheels, (3, wheels); zero for working and seized wheels.
        rotor_inertia: Inertia of every rotor about its axis, (wheels,), kg·m².
        guide: Reference at the sample, see `toward`; None for a target at rest.
        torque_time: Time constant of the estimate of the external torque, which the wheels take up,
            s; None: no estimate, and an external torque causes a constant attitude error.
        momentum_time: Time constant of the estimate of the total momentum, which an external torque
            changes, s. The target follows it, and the wheels take up the estimated torque. None:
            the total momentum of the law is constant.
    """

    law: TwoWheelLaw | ThreeAxisLaw
    normal: Vector3
    failed_axes: Float[Array, "3 wheels"]
    rotor_inertia: Float[Array, " wheels"]
    guide: Guide | None = None
    torque_time: Annotated[Scalar | None, limit("torque time", "s")] = None
    momentum_time: Annotated[Scalar | None, limit("momentum time", "s")] = None

    def toward(self, guide: Guide) -> Self:
        """Law that follows a reference.

        Raises:
            InputError: The working axes do not span space.
        """
        if isinstance(self.law, TwoWheelLaw):
            raise InputError(
                "recovery with two directions of torque: found a reference, expected a fixed "
                "target: such a spacecraft cannot follow a given motion"
            )
        return replace(self, guide=guide)

    def start(self, period: Scalar) -> MomentumRecoveryMemory:
        """Initial memory."""
        way = Way(*(jnp.asarray(angle) for angle in NO_WAY))
        external = None if self.torque_time is None else ExternalTorqueMemory.start(period)
        total = None
        if self.momentum_time is not None:
            total = MomentumEstimate.start(self.law.total_momentum, period)
        return MomentumRecoveryMemory(self.law.wheels.start(period), way, external, total)

    def __call__(
        self, memory: MomentumRecoveryMemory, measurement: Any
    ) -> tuple[MomentumRecoveryMemory, WheelTorqueCommand]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, `wheel_speed`
                (wheels,), relative to the body, rad/s, and `wheel_measured` (wheels,).
        """
        law, loop, rate = self.law, self.law.wheels, measurement.rate
        failed_momentum = self._failed_momentum(measurement)
        relative = self.rotor_inertia * measurement.wheel_speed
        attitude, inertia = measurement.attitude, jnp.asarray(loop.inertia)
        total = memory.total
        if total is not None and self.momentum_time is not None:
            update = total.updated(attitude, self._measure(measurement), self.momentum_time)
            # without the speed of a failed wheel the momentum is not measured
            unknown = self._is_unknown(measurement)
            total = jax.tree.map(lambda a, b: jnp.where(unknown, a, b), total.predicted(), update)
            law = replace(law, total_momentum=total.momentum)
        body = rotations.to_body(attitude, law.total_momentum)
        motion, forward = None, None
        if self.guide is not None:
            # the law in axes of the reference, in which the target is at rest
            motion = self.guide.follow(attitude, rate, body, inertia)
            attitude, rate = motion.turn, motion.rate
            momentum = rotations.to_body(self.guide.now.attitude, law.total_momentum)
            law = replace(law, target=AT_REST, total_momentum=momentum)
        resting = relative + loop.allocation @ (inertia @ rate)
        turning = rotations.rate_of_quaternion(attitude, rate)
        target_rate, change, way = jax.jvp(
            lambda attitude: law(attitude, failed_momentum, resting, memory.way),
            (attitude,),
            (turning,),
            has_aux=True,
        )
        if motion is not None:
            target_rate, change = target_rate + motion.carried, change + motion.change
            # the rate loop turns the momentum at the measured rate
            forward = motion.torque - jnp.cross(body, motion.carried)
        if total is not None:
            disturbance = rotations.to_body(measurement.attitude, total.torque)
            forward = disturbance if forward is None else forward + disturbance
        external = memory.external
        if external is not None and self.torque_time is not None:
            absolute = relative + self.rotor_inertia * (loop.axes.T @ measurement.rate)
            measured_momentum = inertia @ measurement.rate + loop.axes @ absolute
            external = external.updated(measurement.attitude, measured_momentum, self.torque_time)
            forward = external.torque if forward is None else forward + external.torque
        wheels, command = loop(memory.wheels, measurement, body, target_rate, change, forward)
        return MomentumRecoveryMemory(wheels, way, external, total), command

    def predicted(
        self, memory: MomentumRecoveryMemory, measurement: Any, command: WheelTorqueCommand
    ) -> MomentumRecoveryMemory:
        """Memory after a period without a sample; that of the rate loop is predicted.

        Args:
            memory: Memory from the last sample.
            measurement: Unused.
            command: Safe command that is sent.
        """
        wheels = self.law.wheels.predicted(memory.wheels, measurement, command)
        external, total = memory.external, memory.total
        return memory._replace(
            wheels=wheels,
            external=None if external is None else external.missed(),
            total=None if total is None else total.predicted(),
        )

    def _is_unknown(self, measurement: Any) -> Bool[Array, ""]:
        """Whether the speed of a failed wheel is not measured."""
        failed = jnp.any(self.failed_axes != 0.0, axis=0)
        return jnp.any(failed & ~measurement.wheel_measured)

    def _measure(self, measurement: Any) -> Vector3:
        """Total momentum from body rate and tachometers, body axes, (3,), N·m·s."""
        loop, rate = self.law.wheels, measurement.rate
        axes = loop.axes + self.failed_axes
        absolute = self.rotor_inertia * (measurement.wheel_speed + axes.T @ rate)
        return jnp.asarray(loop.inertia) @ rate + axes @ absolute

    def _failed_momentum(self, measurement: Any) -> Scalar:
        axes = self.failed_axes
        absolute = self.rotor_inertia * (measurement.wheel_speed + axes.T @ measurement.rate)
        planned = rotations.to_body(self.law.target, self.law.total_momentum)
        return self.normal @ jnp.where(self._is_unknown(measurement), planned, axes @ absolute)

    @classmethod
    def plan(
        cls,
        spacecraft: Spacecraft,
        working: ArrayLike,
        *,
        total_momentum: ArrayLike,
        target: ArrayLike,
        seized: ArrayLike | None = None,
    ) -> Self:
        """Design the controller for one failure case; done once, outside the loop.

        Args:
            spacecraft: Spacecraft model of the controller, without a batch axis.
            working: Whether each wheel works, (wheels,).
            total_momentum: Total momentum in inertial axes, (3,), N·m·s.
            target: Target quaternion, scalar first, (4,); a feasible attitude.
            seized: Whether each rotor is fixed to the body, (wheels,); None for no seized rotor.

        Raises:
            InputError: The working axes span fewer than two directions; or they span two, and the
                momentum at the target has no component along them that could control the third.
        """
        wheels = spacecraft.wheels
        subset = WorkingWheels.of(spacecraft, working, seized)
        locked = np.zeros(wheels.count) if seized is None else np.asarray(seized, dtype=float)
        failed_axes = jnp.asarray(np.asarray(wheels.axes) * (~subset.works & (locked == 0.0)))
        inertia, normal = jnp.asarray(subset.rotor_inertia), jnp.asarray(subset.directions[:, 2])
        momentum = jnp.asarray(np.asarray(total_momentum, dtype=float))
        quaternion = jnp.asarray(np.asarray(target, dtype=float))
        attitude, across = _at_target(quaternion, momentum, normal)
        loop = WheelRateLoop(
            inertia=jnp.asarray(subset.inertia),
            axes=jnp.asarray(subset.axes),
            allocation=jnp.asarray(np.linalg.pinv(subset.axes, rcond=SPAN)),
            rotor_inertia=jnp.asarray(subset.rotor_inertia * subset.works),
            torque_limit=_of_each(wheels.torque_limit, wheels.count),
            momentum_limit=_of_each(wheels.momentum_limit, wheels.count),
        )
        if subset.rank == 3:
            zero = jnp.asarray(np.zeros(3))
            return cls(ThreeAxisLaw(loop, attitude, momentum), zero, failed_axes, inertia)
        if subset.rank < 2:
            raise InputError(
                f"working wheels: found axes that span {subset.rank} directions, expected 2 or 3"
            )
        if not across > LEAST_AUTHORITY * np.linalg.norm(total_momentum):
            raise InputError(
                f"total momentum: found {across:.2g} N·m·s across the normal of the working "
                "wheels at the target, expected more: it alone can turn the spacecraft about the "
                "normal"
            )
        return cls(TwoWheelLaw(loop, normal, attitude, momentum), normal, failed_axes, inertia)


@stored_tree_function
def _at_target(
    target: Quaternion, total_momentum: Vector3, normal: Vector3
) -> tuple[Quaternion, Scalar]:
    """Target of unit length, and the momentum across the normal there, N·m·s."""
    attitude = rotations.normalised(target)
    return attitude, momentum_frame(normal, rotations.to_body(attitude, total_momentum)).across


def _of_each(limits: Any, count: int) -> PerWheel:
    return jnp.asarray(np.ones(count) * np.asarray(limits))
