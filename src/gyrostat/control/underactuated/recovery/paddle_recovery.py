"""Three-axis control by two wheels and a driven paddle, within the range of the paddle."""

from dataclasses import replace
from typing import Annotated, Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.attitude.three_axis_law import ThreeAxisLaw
from gyrostat.control.measured import measured
from gyrostat.control.underactuated.recovery.momentum import (
    MomentumRecovery,
    MomentumRecoveryMemory,
)
from gyrostat.control.underactuated.recovery.zero_momentum import (
    ZeroMomentumMemory,
    ZeroMomentumRecovery,
)
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar
from gyrostat.core.checked import Checked, positive, positive_share
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft


class PaddleRecoveryMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        turning: Memory of three-axis control.
        sweeping: Memory of control by the wheels alone.
        by_paddle: Whether the paddle is used.
    """

    turning: MomentumRecoveryMemory
    sweeping: ZeroMomentumMemory
    by_paddle: Bool[Array, ""]


class PaddleRecoveryCommand(NamedTuple):
    """Motor torques, and the use of the paddle.

    Attributes:
        torque: Torque on each rotor and on the paddle, (wheels,), N·m; the body gets the opposite
            torque.
        by_paddle: 1 if the paddle is used, 0 if the wheels work alone.
        paddle_end: Angle of the paddle at which the turn to the target would end, rad.
    """

    torque: Annotated[PerWheel, "N·m"]
    by_paddle: Annotated[Scalar, "1"]
    paddle_end: Annotated[Scalar, "rad"]


class PaddleRecovery(Checked):
    """Recovery by two wheels and a paddle, which takes the place of sweeps within its range.

    Two wheels without total momentum reach an attitude by sweeps of the axis that they cannot turn
    about (`ZeroMomentumRecovery`), which take the longer path. A paddle gives the third axis (see
    `gyrostat.spacecraft.PaddleGyrostat`), but its angle is limited. `ThreeAxisLaw` turns the body
    about the fixed axis of the attitude error e. Without total momentum, A diag(I) W = -J w holds
    at every time, with the inertia J of the body with locked wheels and paddle. The angle of the
    paddle at the end of the turn is thus known at every sample:

        end = angle + (A^-1 J e)_paddle / I_paddle,

    with e from the target to the attitude. If it is within `share` of the limit, paddle and wheels
    turn the body; otherwise the wheels sweep, while a rate loop holds the paddle. It is decided
    again whenever no sweep is under way, so that the paddle also removes what a sweep has left.
    A paddle in use is left only if the end moves beyond the limit, as by an unexpected total
    momentum b, which moves the paddle at the rate (A^-1 b) / I.

    Attributes:
        turning: Controller that uses wheels and paddle.
        sweeping: Controller that uses the wheels alone; the paddle counts as seized.
        paddle: Index of the paddle among the wheels.
        angle_limit: Largest angle of the paddle to either side, rad.
        share: Fraction of the limit at which the use of the paddle begins.
        holding: Gain of the rate loop that holds the paddle, 1/s.
    """

    turning: MomentumRecovery
    sweeping: ZeroMomentumRecovery
    paddle: int = eqx.field(static=True)
    angle_limit: Annotated[Scalar, positive("paddle angle limit", "rad")]
    share: Annotated[Scalar, positive_share("paddle share")] = 0.9
    holding: Annotated[Scalar, positive("paddle holding gain", "1/s")] = 2.0

    @classmethod
    def plan(
        cls,
        spacecraft: Spacecraft,
        *,
        paddle: int,
        angle_limit: Scalar,
        target: Quaternion,
        turn_gain: Scalar = 0.5,
        rate_gain: Scalar = 2.0,
        drag_time: Scalar = 2.0,
    ) -> Self:
        """Design the controller.

        Args:
            spacecraft: Model of body, two wheels and paddle, without total momentum.
            paddle: Index of the paddle among the wheels.
            angle_limit: Largest angle of the paddle to either side, rad.
            target: Target quaternion, (4,), scalar first.
            turn_gain: Gain of a small attitude error with the paddle in use, 1/s.
            rate_gain: Gain of the rate loop with the paddle in use, 1/s.
            drag_time: Time constant of the drag estimate, s. The friction of a hinge stops the
                paddle near the target until this estimate has grown to it.

        Raises:
            InputError: There are not three wheels with the paddle; their axes do not span space;
                or a torque or momentum limit is missing.
        """
        count = spacecraft.wheels.count
        if count != 3 or paddle not in range(count):
            raise InputError(
                f"paddle: found {paddle} of {count} wheels, expected one of two wheels and a paddle"
            )
        turning = MomentumRecovery.plan(
            spacecraft, np.ones(3, bool), total_momentum=np.zeros(3), target=target
        )
        if not isinstance(turning.law, ThreeAxisLaw):
            raise InputError("paddle: found an axis in the plane of the wheels, expected another")
        loop = replace(turning.law.wheels, gain=rate_gain, drag_time=drag_time)
        turning = replace(turning, law=replace(turning.law, wheels=loop, turn_gain=turn_gain))
        wheels = np.arange(3) != paddle
        sweeping = ZeroMomentumRecovery.plan(spacecraft, wheels, target=target)
        return cls(turning, sweeping, paddle, angle_limit)

    def check_own_period(self, period: float) -> None:
        """Check that the rate loops are stable at a control period, s.

        Raises:
            InputError: A gain is 1 / period or more.
        """
        for name, gain in (("holding", self.holding), ("rate", self.turning.law.wheels.gain)):
            if float(np.max(np.asarray(gain))) * period >= 1.0:
                raise InputError(
                    f"paddle {name} gain: found {gain} 1/s at a control period of {period:g} s, "
                    f"expected below {1.0 / period:g} 1/s"
                )

    def start(self, period: Scalar) -> PaddleRecoveryMemory:
        """Initial memory."""
        return PaddleRecoveryMemory(
            self.turning.start(period), self.sweeping.start(period), jnp.array(False)
        )

    def paddle_end(self, attitude: Quaternion, angle: Scalar) -> Scalar:
        """Angle of the paddle at the end of a turn from an attitude, (4,), to the target, rad.

        Args:
            attitude: Attitude quaternion, scalar first, (4,).
            angle: Angle of the paddle now, rad.
        """
        loop, target = self.turning.law.wheels, self.turning.law.target
        error = rotations.rotation_vector(rotations.error(attitude, target))
        rotors = loop.axes * loop.rotor_inertia
        locked = loop.inertia + rotors @ loop.axes.T
        momentum = loop.allocation[self.paddle] @ (locked @ error)
        return angle + momentum / loop.rotor_inertia[self.paddle]

    def __call__(
        self, memory: PaddleRecoveryMemory, measurement: Any
    ) -> tuple[PaddleRecoveryMemory, PaddleRecoveryCommand]:
        """Compute the motor torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, `wheel_speed` (3,),
                rad/s, `wheel_measured` (3,), and `paddle_angle`, rad, from a further sensor.

        Raises:
            InputError: The measurement has no `paddle_angle`.
        """
        angle = measured(measurement, "paddle_angle", type(self).__name__)
        end = self.paddle_end(measurement.attitude, angle)
        sweep = memory.sweeping
        is_over = sweep.elapsed >= sweep.sweep.duration
        reach = jnp.where(memory.by_paddle, 1.0, self.share) * self.angle_limit
        by_paddle = (memory.by_paddle | is_over) & (jnp.abs(end) <= reach)
        turning, turn = self.turning(memory.turning, measurement)
        sweeping, sweep_command = self.sweeping(memory.sweeping, measurement)
        inertia = self.turning.law.wheels.rotor_inertia[self.paddle]
        hold = -self.holding * inertia * measurement.wheel_speed[self.paddle]
        limit = jnp.asarray(self.turning.law.wheels.torque_limit)[self.paddle]
        sweep_torque = sweep_command.torque.at[self.paddle].set(jnp.clip(hold, -limit, limit))
        # the controller that does not act starts anew when it does
        fresh = self.start(sweep.period)
        turning = _select(by_paddle, turning, fresh.turning)
        sweeping = _select(by_paddle, fresh.sweeping, sweeping)
        torque = jnp.where(by_paddle, turn.torque, sweep_torque)
        next_memory = PaddleRecoveryMemory(turning, sweeping, by_paddle)
        return next_memory, PaddleRecoveryCommand(torque, by_paddle.astype(float), end)


def _select(condition: Bool[Array, ""], chosen: Any, fallback: Any) -> Any:
    return jax.tree.map(lambda a, b: jnp.where(condition, a, b), chosen, fallback)
