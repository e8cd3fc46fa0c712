"""Attitude control by a wheel array: from attitude and rate to wheel torques."""

from dataclasses import replace
from typing import Annotated, Any, NamedTuple, Self

import numpy as np

from gyrostat.control.allocation.allocation import MinimaxAllocation, Working, spread, within_limits
from gyrostat.control.allocation.momentum_plan import MomentumPlan
from gyrostat.control.allocation.momentum_unloading import MomentumUnloading
from gyrostat.control.allocation.null_space import NullSpaceControl
from gyrostat.control.allocation.wheel_fault_detector import WheelFaultDetector, WheelFaultMemory
from gyrostat.control.allocation.wheel_wear import WheelWear
from gyrostat.control.attitude.attitude_targets import AttitudeTargets
from gyrostat.control.attitude.external_torque import ExternalTorqueMemory
from gyrostat.control.guidance.guide import AT_REST, Guide
from gyrostat.control.underactuated.two_wheel_law import brake
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, limit, positive
from gyrostat.core.delay_line import Sent, empty_line, pushed
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel.friction import static_curve

BRAKING_SHARE = 0.5
"""Fraction of the wheels' torque that is used to stop a turn."""
TURNING_SHARE = 0.4
"""Fraction of the wheels' torque that may be used to turn the momentum with the body."""
LEAST_RATE = 1e-4
"""Smallest rate limit, rad/s, so that a turn continues even if the wheels seem saturated."""
COARSEST = 0.5
"""Product of rate gain and control period above which the sampled loop is hardly damped."""


class ArrayCommand(NamedTuple):
    """Commands to the wheels and the external actuator.

    Attributes:
        torque: Motor torques, (wheels,), N·m.
        external_torque: Torque of the external actuator in body axes, (3,), N·m.
        target: Target quaternion, (4,).
        works: Whether each wheel is taken to work, (wheels,).
    """

    torque: Annotated[PerWheel, "N·m"]
    external_torque: Annotated[Vector3, "N·m"]
    target: Annotated[Quaternion, "1"]
    works: Working


class ArrayControlMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        samples: Number of samples so far.
        given: Torques commanded to the external actuator at the last samples, the oldest first,
            (delay + 1, 3), N·m.
        unknown: Estimate of the other external torques.
        detector: Memory of the wheel fault detector.
        wear: Wear of the wheels, (wheels,).
    """

    samples: Scalar
    given: Sent
    unknown: ExternalTorqueMemory
    detector: WheelFaultMemory
    wear: PerWheel


class WheelArrayControl(Checked):
    """Attitude control by torques of the working wheels, with disturbance feed-forward.

    The motor torques u satisfy A u = T + D - w x H - J (w_d' + k (w_d - w)). T is the torque of the
    external actuator. H is the total momentum of spacecraft and wheels in body axes, and w x H
    keeps it fixed in space while the body turns. D estimates the other external torques: it is the
    change of H in inertial space minus T, after a low-pass filter. Unlike an integral of the error,
    this estimate is not disturbed by a turn.

    The wanted rate w_d brings the error to zero. For a small error it is proportional, with gain
    k_t, so that the poles are -k and -k_t. For a large error it is the rate of a rest-to-rest turn
    about the error axis. It is limited by `largest_rate`, by braking with `BRAKING_SHARE` of the
    wheels' torque, by turning the wheels' momentum with the body, and by the momentum that the
    wheels have left.

    Two further terms are added to u: the estimated drag of each wheel and the torques of the
    null-space control. The drag of failed wheels is allocated to the working ones. B. Wie, "Space
    Vehicle Dynamics and Control", section 7.3.

    With a reference (`toward`), the law controls the motion relative to it: w and w_d are the rates
    relative to the reference, and the torque of `Guide` is added, which follows the reference
    without lag. `largest_rate` then limits the rate relative to the reference.

    Lag behind a moving target without a reference. The law assumes a target at rest, so that its
    rate loop opposes the rate W of a moving target. If body and target turn at a constant W, the
    acceleration of the law is zero: w_d' + k (w_d - W) = 0 with w_d = -k_t e and w_d' = -k_t W. The
    body lags by the angle

        L = W (1 / k + 1 / k_t),

    at the samples and where no limit is active: k_t L is below `largest_rate` and within what the
    wheels can brake. With the default gains L is 12.5 s times W: 0.78 deg at the rate of a low
    orbit, 0.0621 deg/s, and 8.75 deg at 0.7 deg/s. A command delay does not change L, since a
    steady command is the same at every sample. Only w x H, which turns in body axes, is late by d +
    1/2 periods T and adds |W x (W x H)| (d + 1/2) T / (J k k_t), with H the total momentum. An
    attitude measured T_m late makes the lag smaller by W T_m. Beyond the linear range, with s(e)
    the rate of the law at an error e, L solves k (s(L) - W) = s'(L) W. If W is above `largest_rate`
    there is no solution, and the lag grows without bound.

    Attributes:
        spacecraft: Spacecraft model of the controller; every wheel with finite limits.
        targets: Target attitude over time; unused with a reference.
        turn_gain: Attitude gain k_t, 1/s.
        rate_gain: Rate gain k, 1/s.
        torque_time: Time constant of the low-pass filter of D, s; infinite: D stays zero.
        largest_rate: Largest commanded rate, rad/s.
        allocation: Allocation of torque to wheels: `MinimaxAllocation` or `PseudoInverse`.
        null_space: Null-space control, which keeps wheels from zero speed, bands and saturation;
            None if unused.
        wear: Wear of the wheels for the null-space control. Its estimate counts the drag of the
            detector and, of a compensator, the field `wheel_friction` of the measurement.
        unloading: Momentum unloading by the external actuator; None without such an actuator.
        plan: Momentum plan for null space and unloading; None: the null-space control chooses the
            wheel speeds, and the actuator unloads at all times.
        detector: Detector of drag and failures; it also has the command delay.
        guide: Reference at the sample, see `toward`; None for a target at rest.
    """

    spacecraft: Spacecraft
    targets: AttitudeTargets
    turn_gain: Annotated[Scalar, positive("turn gain", "1/s")] = 0.1
    rate_gain: Annotated[Scalar, positive("rate gain", "1/s")] = 0.4
    torque_time: Annotated[Scalar, limit("torque time", "s")] = 20.0
    largest_rate: Annotated[Scalar, positive("largest rate", "rad/s")] = 0.05
    allocation: Any = MinimaxAllocation()
    null_space: NullSpaceControl | None = None
    wear: WheelWear = WheelWear()
    unloading: MomentumUnloading | None = None
    plan: MomentumPlan | None = None
    detector: WheelFaultDetector = WheelFaultDetector()
    guide: Guide | None = None

    def toward(self, guide: Guide) -> Self:
        """Law that follows a reference."""
        return replace(self, guide=guide)

    def check_own(self) -> None:
        """Validate the limits of the wheels.

        Raises:
            InputError: A limit is infinite.
        """
        for name in ("torque_limit", "momentum_limit"):
            if not np.all(np.isfinite(np.asarray(getattr(self.spacecraft.wheels, name)))):
                raise InputError(
                    f"wheel {name}: found none, expected one for every wheel of the controller"
                )

    def check_own_period(self, period: float) -> None:
        """Check that a control period, s, is short enough for the rate gain.

        Raises:
            InputError: The period is too long.
        """
        longest = COARSEST / np.max(np.asarray(self.rate_gain))
        if period > longest:
            raise InputError(
                f"control period: found {period:g} s, expected {longest:g} s or less at this rate "
                "gain"
            )

    def start(self, period: Scalar) -> ArrayControlMemory:
        """Initial memory."""
        zero, detector = jnp.zeros(3), self.detector.start(self.spacecraft.wheels.count)
        line = empty_line(zero, self.detector.delay + 1)
        unknown, wear = ExternalTorqueMemory.start(period), self.wear.start(detector.works.size)
        return ArrayControlMemory(jnp.zeros(()), line, unknown, detector, wear)

    def __call__(
        self, memory: ArrayControlMemory, measurement: Any
    ) -> tuple[ArrayControlMemory, ArrayCommand]:
        """Compute the commands to wheels and external actuator.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, `wheel_speed`
                (wheels,), relative to the body, rad/s, and `wheel_measured` (wheels,).
        """
        wheels, period = self.spacecraft.wheels, memory.unknown.period
        axes, inertia = jnp.asarray(wheels.axes), jnp.asarray(self.spacecraft.inertia)
        limit = jnp.ones(wheels.count) * wheels.torque_limit
        rate, relative = measurement.rate, wheels.inertia * measurement.wheel_speed
        time = memory.samples * period
        absolute = relative + wheels.inertia * (axes.T @ rate)
        momentum = inertia @ rate + axes @ absolute
        detector = self.detector(
            memory.detector, absolute, measurement.wheel_measured, limit, time, period
        )
        external = self._external_torque(time, measurement.attitude, momentum)
        motion, target, feed_forward = measurement, self.targets(time), None
        if self.guide is not None:
            following = self.guide.follow(measurement.attitude, rate, momentum, inertia)
            motion = measurement._replace(attitude=following.turn, rate=following.rate)
            feed_forward = following.torque - inertia @ following.change
            target = AT_REST
        target_rate, change = self._target_rate(motion, target, momentum, detector.works)
        unknown = memory.unknown.updated(
            measurement.attitude, momentum, self.torque_time, memory.given[0]
        )
        push = change + self.rate_gain * (target_rate - motion.rate)
        # bearing torque of failed wheels acts on the body; if not measured, D includes it
        failed = ~detector.works & measurement.wheel_measured
        bearing = axes @ jnp.where(failed, detector.lost, 0.0)
        demand = (
            external + unknown.torque + bearing - jnp.cross(motion.rate, momentum) - inertia @ push
        )
        if self.guide is not None and feed_forward is not None:
            demand, target = demand + feed_forward, self.guide.now.attitude
        available = limit - jnp.abs(detector.drag)
        torque = within_limits(self.allocation(axes, available, detector.works, demand), available)
        wear = memory.wear
        if self.null_space is not None:
            wear = self.wear(
                wear,
                detector.drag + getattr(measurement, "wheel_friction", 0.0),
                measurement.wheel_speed,
                static_curve(wheels.friction),
                detector.works & measurement.wheel_measured,
                period,
            )
            room = available - jnp.abs(torque)
            planned = None if self.plan is None else self.plan.level(time)
            torque += self.null_space(axes, detector.works, relative, room, wear, planned)
        torque = wheels.within_momentum_limit(torque + detector.drag, relative, period)
        detector = self.detector.commanded(detector, torque)
        line, _ = pushed(memory.given, external)
        next_memory = ArrayControlMemory(memory.samples + 1.0, line, unknown, detector, wear)
        return next_memory, ArrayCommand(torque, external, target, detector.works)

    def predicted(
        self, memory: ArrayControlMemory, measurement: Any, command: ArrayCommand
    ) -> ArrayControlMemory:
        """Memory after a period without a sample; time advances, estimates are unchanged.

        Args:
            memory: Memory from the last sample.
            measurement: Unused.
            command: Safe command that is sent.
        """
        return memory._replace(
            samples=memory.samples + 1.0,
            given=pushed(memory.given, command.external_torque)[0],
            unknown=memory.unknown.missed(),
            detector=self.detector.missed(memory.detector, command.torque),
        )

    def _external_torque(self, time: Scalar, attitude: Quaternion, momentum: Vector3) -> Vector3:
        """Torque of the external actuator in body axes, (3,), N·m."""
        if self.unloading is None:
            return jnp.zeros(3)
        if self.plan is None:
            return self.unloading(momentum)
        return self.plan.unload(self.unloading, time, attitude, momentum)

    def _target_rate(
        self, measurement: Any, target: Quaternion, momentum: Vector3, works: Working
    ) -> tuple[Vector3, Vector3]:
        """Commanded body rate, rad/s, and its change along the motion, rad/s²."""
        wheels, rate = self.spacecraft.wheels, measurement.rate
        inertia, axes = jnp.asarray(self.spacecraft.inertia), jnp.asarray(wheels.axes)
        across = spread(axes, works)
        error = rotations.rotation_vector(rotations.error(measurement.attitude, target))
        axis = error / jnp.sqrt(error @ error + 1e-24)

        def largest(direction: Vector3, limit: PerWheel | float) -> Scalar:
            return jnp.min(limit / jnp.maximum(jnp.abs(across @ direction), 1e-12))

        slowing = BRAKING_SHARE * largest(inertia @ axis, wheels.torque_limit)
        turning = TURNING_SHARE * largest(jnp.cross(momentum, axis), wheels.torque_limit)
        resting = works * wheels.inertia * measurement.wheel_speed + across @ (inertia @ rate)
        room = jnp.maximum(wheels.momentum_limit - jnp.abs(resting), 0.0)
        fastest = jnp.minimum(turning, jnp.maximum(largest(inertia @ axis, room), LEAST_RATE))
        fastest = jnp.minimum(fastest, self.largest_rate)

        def law(attitude: Quaternion) -> Vector3:
            error = rotations.rotation_vector(rotations.error(attitude, target))
            angle = jnp.sqrt(error @ error + 1e-24)
            speed = brake(angle, self.turn_gain, slowing)
            return -error / angle * jnp.minimum(speed, fastest)

        slope = rotations.rate_of_quaternion(measurement.attitude, rate)
        return jax.jvp(law, (measurement.attitude,), (slope,))
