"""Recovery law for working wheels that suffice together with the total momentum."""

from typing import Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control.allocation.working_wheels import SPAN, WorkingWheels
from gyrostat.control.attitude.three_axis_law import ThreeAxisLaw
from gyrostat.control.attitude.wheel_rate_loop import RateLoopMemory, WheelRateLoop
from gyrostat.control.underactuated.momentum_angles import momentum_frame
from gyrostat.control.underactuated.two_wheel_law import NO_WAY, TwoWheelLaw, Way
from gyrostat.core import rotations
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft, WheelTorqueCommand

LEAST_AUTHORITY = 1e-3
"""Of momentum across the normal over the whole: below it the third direction is out of reach."""


class MomentumRecoveryMemory(NamedTuple):
    """Between two samples.

    Attributes:
        wheels: of the rate loop.
        way: round to the target that is taken.
    """

    wheels: RateLoopMemory
    way: Way


class MomentumRecovery(Checked):
    """Brings a spacecraft to rest at a holdable attitude, whatever its motion at the start.

    The law gives a rate for each attitude, its change along the measured motion the acceleration
    to feed forward, and the rate loop the torques. What the failed wheels hold along the normal is
    measured, for it changes while they run down; where their sensors are lost it is taken as what
    they will hold at the target. It is not inferred from rate and inertia: where the momentum is
    small, an inertia that is wrong by 5 % would make that unstable.

    With two directions left the time to expect is 100 s + 15 J / rho, with the largest inertia J
    and the momentum rho across the normal n at the target, N·m·s. A failed wheel that still runs
    down with the time constant tau moves what can be held until its momentum h along its axis a is
    gone: to a tolerance of e rad that takes tau ln(h |n.a| / (rho e)), and the longer of both
    times counts.

    Attributes:
        law: rate over attitude.
        normal: (3,) to the working axes, or zero where they span space.
        failed_axes: (3, wheels), those of working and of seized wheels zero.
        rotor_inertia: (wheels,) of every rotor about its axis, kg·m².
    """

    law: TwoWheelLaw | ThreeAxisLaw
    normal: Vector3
    failed_axes: Float[Array, "3 wheels"]
    rotor_inertia: Float[Array, " wheels"]

    def start(self, period: Scalar) -> MomentumRecoveryMemory:
        """Nothing measured yet."""
        none = Way(*(jnp.asarray(angle) for angle in NO_WAY))
        return MomentumRecoveryMemory(self.law.wheels.start(period), none)

    def __call__(
        self, memory: MomentumRecoveryMemory, measurement: Any
    ) -> tuple[MomentumRecoveryMemory, WheelTorqueCommand]:
        """Command the wheels.

        Args:
            memory: from the last sample.
            measurement: has `attitude` (4,), `rate` (3,), rad/s, `wheel_speed` (wheels,)
                relative to the body, rad/s, and `wheel_measured` (wheels,).
        """
        law, loop, rate = self.law, self.law.wheels, measurement.rate
        held = self._held(measurement)
        relative = self.rotor_inertia * measurement.wheel_speed
        resting = relative + loop.allocation @ (jnp.asarray(loop.inertia) @ rate)
        turning = rotations.rate_of_quaternion(measurement.attitude, rate)
        wanted, change, way = jax.jvp(
            lambda attitude: law(attitude, held, resting, memory.way),
            (measurement.attitude,),
            (turning,),
            has_aux=True,
        )
        body = rotations.to_body(measurement.attitude, law.total_momentum)
        wheels, command = loop(memory.wheels, measurement, body, wanted, change)
        return MomentumRecoveryMemory(wheels, way), command

    def predicted(
        self, memory: MomentumRecoveryMemory, measurement: Any, command: WheelTorqueCommand
    ) -> MomentumRecoveryMemory:
        """Memory one period later without a sample: that of the rate loop.

        Args:
            memory: from the last sample.
            measurement: not used.
            command: that is sent.
        """
        wheels = self.law.wheels.predicted(memory.wheels, measurement, command)
        return memory._replace(wheels=wheels)

    def _held(self, measurement: Any) -> Scalar:
        axes = self.failed_axes
        absolute = self.rotor_inertia * (measurement.wheel_speed + axes.T @ measurement.rate)
        unknown = jnp.any(jnp.any(axes != 0.0, axis=0) & ~measurement.wheel_measured)
        planned = rotations.to_body(self.law.target, self.law.total_momentum)
        return self.normal @ jnp.where(unknown, planned, axes @ absolute)

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
        """The controller for one failure; done once, outside the loop.

        Args:
            spacecraft: as the controller knows it, one.
            working: (wheels,) whether a wheel works.
            total_momentum: (3,) in inertial axes, N·m·s.
            target: (4,) holdable attitude, scalar first.
            seized: (wheels,) whether the rotor is fixed to the body; None for none.

        Raises:
            InputError: fewer than two directions are left; or two, and the momentum has no part
                across them at the target that could move the third.
        """
        wheels = spacecraft.wheels
        left = WorkingWheels.of(spacecraft, working, seized)
        fixed = np.zeros(wheels.count) if seized is None else np.asarray(seized, dtype=float)
        failed = jnp.asarray(np.asarray(wheels.axes) * (~left.works & (fixed == 0.0)))
        own = jnp.asarray(left.rotor_inertia)
        attitude = rotations.normalised(jnp.asarray(target, dtype=float))
        momentum = jnp.asarray(total_momentum, dtype=float)
        loop = WheelRateLoop(
            inertia=jnp.asarray(left.inertia),
            axes=jnp.asarray(left.axes),
            allocation=jnp.asarray(np.linalg.pinv(left.axes, rcond=SPAN)),
            rotor_inertia=own * left.works,
            torque_limit=jnp.ones(wheels.count) * wheels.torque_limit,
            momentum_limit=jnp.ones(wheels.count) * wheels.momentum_limit,
        )
        if left.rank == 3:
            return cls(ThreeAxisLaw(loop, attitude, momentum), jnp.zeros(3), failed, own)
        if left.rank < 2:
            raise InputError(
                f"working wheels: found axes that span {left.rank} directions, expected 2 or 3"
            )
        normal = jnp.asarray(left.directions[:, 2])
        frame = momentum_frame(normal, rotations.to_body(attitude, momentum))
        if not frame.across > LEAST_AUTHORITY * jnp.linalg.norm(momentum):
            raise InputError(
                f"total momentum: found {frame.across:.2g} N·m·s across the normal of the working "
                "wheels at the target, expected more: it alone can turn the spacecraft about the "
                "normal"
            )
        law = TwoWheelLaw(loop, normal, attitude, momentum)
        return cls(law, normal, failed, own)
