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
"""s: what leaning takes away in that time is not worth a sweep, which takes as long or longer."""
NO_LEVER = 1e-10
"""1/s: below it leaning takes nothing away."""


class ZeroMomentumMemory(NamedTuple):
    """Between two samples.

    Attributes:
        sweep: under way, or the last one.
        elapsed: since its start, s.
        reference: attitude that the sweep would have reached now.
        arrived: whether the target is held.
        period: control period, s.
    """

    sweep: Sweep
    elapsed: Scalar
    reference: Quaternion
    arrived: Bool[Array, ""]
    period: Scalar


class ZeroMomentumCommand(NamedTuple):
    """Motor torques, and what they are for.

    Attributes:
        torque: (wheels,) on each rotor, N·m; positive speeds the wheel up and pushes the body back.
        started: 1 where a sweep starts at this sample, else 0.
        left: of the sweep under way, s.
    """

    torque: Annotated[Float[Array, " wheels"], "N·m"]
    started: Annotated[Scalar, "1"]
    left: Annotated[Scalar, "s"]


class ZeroMomentumRecovery(Checked):
    """Sweeps of `rest_to_rest`, each tracked in two directions and planned again at its end.

    Without momentum no smooth feedback brings a body with two wheels to rest at a target: one
    direction, along z of `TwoWheelSweeps`, is not commanded. This controller

    - plans a sweep from rest, aimed so that it ends on target with the drift on its way;
    - tracks it in the two directions that the wheels command; the reference takes over the body's
      own rate along z, so that tracking never bends the way that was planned;
    - plans again at its end where too much error is left along z: each sweep leaves a small share
      of the error before it, of the order of what is wrong with the inertia;
    - holds the commanded directions then, and what momentum there is takes away the rest: off the
      target by a lean along the lever of the drift the body drifts towards it. The lean is wide
      until the error along z is below `fine`, and narrow from then on, unless it grows beyond
      `coarse`.

    Before a first sweep the body is brought to rest as far as the wheels can. Noise of a
    measurement has to be well below `fine` and `rest_rate`.

    Attributes:
        sweeps: what the spacecraft can do, as known to the controller.
        target: attitude to reach, one where n.b = 0.
        fine: error along z at which the target is reached, rad.
        coarse: error along z at which it is lost again, rad.
        lean: while the target is held, at most, rad.
        swing: lean before, at most, rad.
        lean_gain: of the error along z, 1/s.
        frequency: natural frequency of the tracking, critically damped, rad/s.
        share: of torque and momentum limit that a sweep may take.
        rest_rate: largest rate across z at which a sweep is planned, rad/s.
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
        """For a spacecraft of which some wheels have seized.

        Args:
            spacecraft: as known to the controller.
            working: (wheels,) bool; the others are seized.
            target: attitude to reach, one that can be held.
            **tuning: other attributes.

        Raises:
            InputError: see `TwoWheelSweeps.of`.
        """
        quaternion = rotations.normalised(jnp.asarray(target, dtype=float))
        return cls(TwoWheelSweeps.of(spacecraft, working), quaternion, **tuning)

    def start(self, period: Scalar) -> ZeroMomentumMemory:
        """As after a sweep."""
        zero, one = jnp.zeros(()), jnp.ones(())
        last, same = Sweep(zero, zero, one, one, one), jnp.array([1.0, 0.0, 0.0, 0.0])
        period = jnp.asarray(period, dtype=float)
        return ZeroMomentumMemory(last, last.duration, same, jnp.array(False), period)

    def __call__(
        self, memory: ZeroMomentumMemory, measurement: Any
    ) -> tuple[ZeroMomentumMemory, ZeroMomentumCommand]:
        """Command torques.

        Args:
            memory: from the last sample.
            measurement: has `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed` (wheels,)
                relative to the body, rad/s.
        """
        sweeps, attitude, rate = self.sweeps, measurement.attitude, measurement.rate
        momentum = sweeps.momentum(rate, measurement.wheel_speed)
        across = sweeps.frame.T @ rate
        memory, held, started = self._begun(memory, attitude, momentum, across)
        sweep, period = memory.sweep, memory.period
        angle, speed = progress(sweep, memory.elapsed)
        later_angle, later_speed = progress(sweep, memory.elapsed + period)
        wanted = speed * rate_axis(sweep, angle)
        later = later_speed * rate_axis(sweep, later_angle)
        left = jnp.maximum(sweep.duration - memory.elapsed, 0.0)
        missed = jnp.where(left > 0.0, sweeps.error(attitude, memory.reference), held)
        feedback = self.frequency**2 * missed + 2.0 * self.frequency * (across - wanted)
        torque = sweeps.torque((later - wanted) / period - feedback, rate, momentum)
        # the drift changes while the body turns: what it is in the middle of the period counts
        own = across[2] + 0.5 * period * (sweeps.drift @ jnp.cross(momentum, rate))
        memory = memory._replace(
            elapsed=memory.elapsed + period,
            reference=self._carried(memory, angle, later_angle, own),
        )
        return memory, ZeroMomentumCommand(torque, started.astype(float), left)

    def _begun(
        self, memory: ZeroMomentumMemory, attitude: Quaternion, momentum: Vector3, across: Vector3
    ) -> tuple[ZeroMomentumMemory, Vector3, Bool[Array, ""]]:
        """Begin a sweep where the last is over, the body slow and the target not near.

        Returns:
            The memory; what the commanded directions are off by where no sweep is under way, zero
            while the body is still to be slowed down; whether a sweep begins.
        """
        sweeps, inertial = self.sweeps, rotations.to_inertial(attitude, momentum)
        error = sweeps.error(attitude, self.target)
        lever = sweeps.lever(self.target, inertial).at[2].set(0.0)
        size = jnp.sqrt(lever @ lever)
        over = memory.elapsed >= memory.sweep.duration
        off, aside = jnp.abs(error[2]), jnp.hypot(error[0], error[1])
        within = jnp.where(memory.arrived, self.coarse, self.fine)
        near = off < jnp.maximum(within, SWING_TIME * self.swing * size)
        near = near & (aside < 2.0 * self.swing)
        slow = jnp.hypot(across[0], across[1]) < self.rest_rate
        begin = over & slow & ~near
        arrived = over & near & (off < within)
        widest = jnp.where(arrived, self.lean, self.swing)
        has = size > NO_LEVER
        amount = -self.lean_gain * error[2] / jnp.where(has, size, 1.0)
        amount = jnp.where(has, jnp.clip(amount, -widest, widest), 0.0)
        held = error - amount * lever / jnp.where(has, size, 1.0)
        sweep = sweeps.planned(memory.sweep, begin, attitude, self.target, inertial, self.share)
        memory = memory._replace(
            sweep=sweep,
            elapsed=jnp.where(begin, 0.0, memory.elapsed),
            reference=jnp.where(begin, attitude, memory.reference),
            arrived=arrived,
        )
        return memory, jnp.where(near, held, 0.0), begin

    def _carried(
        self, memory: ZeroMomentumMemory, angle: Scalar, later: Scalar, own: Scalar
    ) -> Quaternion:
        """The reference a period later: along the sweep, and about z with the body's own rate."""
        sweep = memory.sweep
        step = rotations.product(rotations.conjugate(turned(sweep, angle)), turned(sweep, later))
        twist = rotations.from_rotation_vector(jnp.array([0.0, 0.0, 0.5]) * own * memory.period)
        step = rotations.product(rotations.product(twist, step), twist)
        carried = rotations.product(memory.reference, self.sweeps.in_body(step))
        return rotations.normalised(carried)
