"""Gyrostat with driven paddles: momentum exchange with a limited angle."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, PRNGKeyArray

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, limit, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft.gyrostat import Gyrostat
from gyrostat.spacecraft.gyrostat_state import GyrostatState
from gyrostat.spacecraft.gyrostat_wrapper import GyrostatWrapper
from gyrostat.wheel.array import listed


class PaddleGyrostat(GyrostatWrapper):
    """Gyrostat some of whose wheels are paddles on a hinge, such as a driven solar panel.

    A paddle whose centre of mass lies on the hinge line, and whose inertias across that line are
    equal, leaves the inertia of the spacecraft constant. It exchanges momentum as a wheel does:
    h = I (W + a.w) about the hinge line a, with its angular rate W relative to the body. From rest
    to rest without total momentum, the spacecraft turns about a principal axis a by -I / (I + J)
    times the angle of the paddle, with the inertia J of the rest. A flat panel has unequal inertias
    across its hinge line, by I at most; their part in the motion is of second order, the body rate
    times the angle turned, and is left out here.

    At the ends of its range a paddle meets a stop and comes to rest on the body without rebound;
    the total momentum stays. The stop acts at the end of the interval of integration.

    Attributes:
        gyrostat: Gyrostat with the paddles among its wheels: their hinge lines, inertias, motor
            torques and hinge friction. The limit of the rate is their momentum limit over inertia.
        angle_limit: Largest angle to either side, (wheels,), rad; infinite for wheels.
    """

    gyrostat: Gyrostat
    angle_limit: Annotated[PerWheel, limit("angle limit", "rad")] = eqx.field(converter=listed)

    def check_own(self) -> None:
        """Validate the number of angle limits.

        Raises:
            InputError: There is not one for each wheel.
        """
        shape, count = np.shape(self.angle_limit)[-1:], self.spacecraft.wheels.count
        if shape != (count,):
            raise InputError(f"angle limit: found shape {shape}, expected one for {count} wheels")

    def start(self, *, wheel_angle: Any = 0.0, **motion: Any) -> GyrostatState:
        """Create a state from attitude, rate, wheel speeds and angles.

        Args:
            wheel_angle: Angles of wheels and paddles, (wheels,), or one value for all, rad.
            motion: See `Gyrostat.start`.
        """
        state = self.gyrostat.start(**motion)
        angle = jnp.broadcast_to(jnp.asarray(wheel_angle, dtype=float), state.wheel_speed.shape)
        return state._replace(wheel_angle=angle)

    def check_state(self, state: GyrostatState) -> None:
        """Validate a state.

        Raises:
            InputError: See `Gyrostat.check_state`; or an angle is missing or beyond its limit.
        """
        self.gyrostat.check_state(state)
        if state.wheel_angle is None or np.any(np.abs(state.wheel_angle) > self.angle_limit):
            raise InputError(
                f"wheel_angle: found {state.wheel_angle}, expected angles within "
                f"{self.angle_limit} rad"
            )

    def __call__(
        self, state: Any, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[GyrostatState, Bool[Array, ""]]:
        """Integrate over an interval of constant command; see `Gyrostat`."""
        after, resolved = self.gyrostat(state, command, time, duration)
        # exact for constant acceleration, which a constant torque gives approximately
        mean = 0.5 * (state.wheel_speed + after.wheel_speed)
        angle = state.wheel_angle + duration * mean
        stopped = (jnp.abs(angle) >= self.angle_limit) & (angle * after.wheel_speed > 0.0)
        return (
            after._replace(
                wheel_angle=jnp.clip(angle, -self.angle_limit, self.angle_limit),
                wheel_speed=jnp.where(stopped, 0.0, after.wheel_speed),
            ),
            resolved,
        )


class PaddleAngle(Checked):
    """Measured angle of a paddle with white noise, rad, a number; for `AddedSensors`.

    Attributes:
        wheel: Index of the paddle among the wheels.
        sigma: Standard deviation, rad.
    """

    wheel: int = eqx.field(static=True)
    sigma: Annotated[Scalar, size("paddle angle sigma", "rad")] = 0.0
    unit = "rad"

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """No memory."""
        return ()

    def __call__(
        self, memory: tuple[()], state: Any, key: PRNGKeyArray
    ) -> tuple[tuple[()], Scalar]:
        """Measure the angle."""
        return memory, state.wheel_angle[self.wheel] + self.sigma * jax.random.normal(key)
