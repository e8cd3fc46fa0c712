"""Recovery law for two working wheels and almost zero total momentum."""

from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.underactuated.recovery.rest_to_rest import Sweep, progress, rate_axis, turned
from gyrostat.control.underactuated.recovery.two_wheel_sweeps import TwoWheelSweeps
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import Spacecraft

SWING_TIME = 20.0
"""Time, s. An error that a lean (a small offset from the target) removes in this time needs no
sweep, which would take as long or longer."""
NO_LEVER = 1e-10
"""Size of the drift lever, 1/s, below which a lean has no effect."""


class ZeroMomentumMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        sweep: Present or last sweep.
        elapsed: Time since its start, s.
        reference: Present reference attitude of the sweep, (4,).
        arrived: Whether the target is held.
        period: Control period, s.
    """

    sweep: Sweep
    elapsed: Scalar
    reference: Quaternion
    arrived: Bool[Array, ""]
    period: Scalar


class ZeroMomentumCommand(NamedTuple):
    """Motor torques, and the state of the sweep.

    Attributes:
        torque: Torque on each rotor, (wheels,), N·m; a positive torque increases the wheel speed
            and acts on the body in the negative direction.
        started: 1 if a sweep starts at this sample, else 0.
        left: Remaining time of the present sweep, s.
    """

    torque: Annotated[Float[Array, " wheels"], "N·m"]
    started: Annotated[Scalar, "1"]
    left: Annotated[Scalar, "s"]


class ZeroMomentumRecovery(Checked):
    """Recovery by the sweeps of `rest_to_rest`, each tracked and followed by a new plan.

    Without momentum, no smooth feedback brings a body with two wheels to rest at a target, since
    the direction along z of `TwoWheelSweeps` cannot be commanded. This controller

    - plans a sweep from rest that ends at the target, including the drift during the sweep;
    - tracks it in the two directions that the wheels control. The reference takes over the body's
      own rate along z, so that tracking does not change the shape of the planned path;
    - plans again at the end of a sweep if the error along z is too large. Each sweep leaves a small
      share of the previous error, of the order of the inertia error;
    - then holds the commanded directions, and uses the drift from the remaining momentum to remove
      the rest of the error. With a small offset from the target along the lever of the drift (a
      lean), the body drifts towards the target. The lean may be large until the error along z is
      below `fine`. After that it is small, unless the error grows beyond `coarse`.

    Before the first sweep, the body is brought to rest as far as the wheels can. The measurement
    noise must be well below `fine` and `rest_rate`.

    Attributes:
        sweeps: Sweeps of the spacecraft model of the controller.
        target: Target quaternion, (4,), of an attitude with n.b = 0.
        fine: Error along z at which the target is reached, rad.
        coarse: Error along z at which the target is lost again, rad.
        lean: Largest lean while the target is held, rad.
        swing: Largest lean before the target is held, rad.
        lean_gain: Gain of the error along z, 1/s.
        frequency: Natural frequency of the tracking, which is critically damped, rad/s.
        share: Fraction of the torque and momentum limits that a sweep may use.
        rest_rate: Largest rate across z at which a sweep is planned, rad/s.
    """

    sweeps: TwoWheelSweeps
    target: Quaternion
    fine: Annotated[Scalar, positive("recovery fine")] = np.radians(0.015)
    coarse: Annotated[Scalar, positive("recovery coarse")] = np.radians(0.03)
    lean: Annotated[Scalar, size("recovery lean")] = np.radians(0.015)
    swing: Annotated[Scalar, positive("recovery swing")] = np.radians(1.5)
    lean_gain: Annotated[Scalar, size("recovery lean_gain")] = 0.06
    frequency: Annotated[Scalar, positive("recovery frequency")] = 0.5
    share: Annotated[Scalar, positive("recovery share")] = 0.92
    rest_rate: Annotated[Scalar, positive("recovery rest_rate")] = 1e-3

    @classmethod
    def plan(
        cls, spacecraft: Spacecraft, working: Any, *, target: Quaternion, **tuning: Scalar
    ) -> Self:
        """Design the controller for a spacecraft with some seized wheels.

        Args:
            spacecraft: Spacecraft model of the controller.
            working: Whether each wheel works, (wheels,), bool; the others are seized.
            target: Target quaternion, (4,), of a feasible attitude.
            **tuning: Other attributes.

        Raises:
            InputError: See `TwoWheelSweeps.of`.
        """
        quaternion = rotations.normalised(jnp.asarray(target, dtype=float))
        return cls(TwoWheelSweeps.of(spacecraft, working), quaternion, **tuning)

    def start(self, period: Scalar) -> ZeroMomentumMemory:
        """Initial memory, as after the end of a sweep."""
        zero, one = jnp.zeros(()), jnp.ones(())
        sweep, unit = Sweep(zero, zero, one, one, one), jnp.array([1.0, 0.0, 0.0, 0.0])
        period = jnp.asarray(period, dtype=float)
        return ZeroMomentumMemory(sweep, sweep.duration, unit, jnp.array(False), period)

    def __call__(
        self, memory: ZeroMomentumMemory, measurement: Any
    ) -> tuple[ZeroMomentumMemory, ZeroMomentumCommand]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (wheels,), relative to the body, rad/s.
        """
        sweeps, attitude, rate = self.sweeps, measurement.attitude, measurement.rate
        momentum = sweeps.momentum(rate, measurement.wheel_speed)
        across = sweeps.frame.T @ rate
        memory, hold_error, started = self._begin(memory, attitude, momentum, across)
        sweep, period = memory.sweep, memory.period
        angle, speed = progress(sweep, memory.elapsed)
        later_angle, later_speed = progress(sweep, memory.elapsed + period)
        target_rate = speed * rate_axis(sweep, angle)
        later_rate = later_speed * rate_axis(sweep, later_angle)
        time_left = jnp.maximum(sweep.duration - memory.elapsed, 0.0)
        error = jnp.where(time_left > 0.0, sweeps.error(attitude, memory.reference), hold_error)
        feedback = self.frequency**2 * error + 2.0 * self.frequency * (across - target_rate)
        torque = sweeps.torque((later_rate - target_rate) / period - feedback, rate, momentum)
        # the drift changes while the body turns; its value in the middle of the period is used
        drift = across[2] + 0.5 * period * (sweeps.drift @ jnp.cross(momentum, rate))
        memory = memory._replace(
            elapsed=memory.elapsed + period,
            reference=self._advance_reference(memory, angle, later_angle, drift),
        )
        return memory, ZeroMomentumCommand(torque, started.astype(float), time_left)

    def _begin(
        self, memory: ZeroMomentumMemory, attitude: Quaternion, momentum: Vector3, across: Vector3
    ) -> tuple[ZeroMomentumMemory, Vector3, Bool[Array, ""]]:
        """Begin a sweep if the last is over, the body is slow and the target is not near.

        Returns:
            Memory; error of the commanded directions if no sweep is active, zero while the body is
            still being slowed down; and whether a sweep begins.
        """
        sweeps, inertial = self.sweeps, rotations.to_inertial(attitude, momentum)
        error = sweeps.error(attitude, self.target)
        lever = sweeps.lever(self.target, inertial).at[2].set(0.0)
        size = jnp.sqrt(lever @ lever)
        is_over = memory.elapsed >= memory.sweep.duration
        off, lateral = jnp.abs(error[2]), jnp.hypot(error[0], error[1])
        tolerance = jnp.where(memory.arrived, self.coarse, self.fine)
        is_near = off < jnp.maximum(tolerance, SWING_TIME * self.swing * size)
        is_near = is_near & (lateral < 2.0 * self.swing)
        slow = jnp.hypot(across[0], across[1]) < self.rest_rate
        begin = is_over & slow & ~is_near
        arrived = is_over & is_near & (off < tolerance)
        widest = jnp.where(arrived, self.lean, self.swing)
        has = size > NO_LEVER
        amount = -self.lean_gain * error[2] / jnp.where(has, size, 1.0)
        amount = jnp.where(has, jnp.clip(amount, -widest, widest), 0.0)
        hold_error = error - amount * lever / jnp.where(has, size, 1.0)
        sweep = sweeps.planned(memory.sweep, begin, attitude, self.target, inertial, self.share)
        memory = memory._replace(
            sweep=sweep,
            elapsed=jnp.where(begin, 0.0, memory.elapsed),
            reference=jnp.where(begin, attitude, memory.reference),
            arrived=arrived,
        )
        return memory, jnp.where(is_near, hold_error, 0.0), begin

    def _advance_reference(
        self, memory: ZeroMomentumMemory, angle: Scalar, later: Scalar, drift: Scalar
    ) -> Quaternion:
        """Reference one period later: along the sweep, and about z at the body's own rate."""
        sweep = memory.sweep
        step = rotations.product(rotations.conjugate(turned(sweep, angle)), turned(sweep, later))
        twist = rotations.from_rotation_vector(jnp.array([0.0, 0.0, 0.5]) * drift * memory.period)
        step = rotations.product(rotations.product(twist, step), twist)
        return rotations.normalised(rotations.product(memory.reference, self.sweeps.in_body(step)))
