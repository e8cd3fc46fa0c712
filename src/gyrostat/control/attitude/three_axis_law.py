"""Body-rate command that turns a spacecraft with three-axis control to an attitude."""

from typing import Annotated

from gyrostat.control.attitude.wheel_rate_loop import WheelRateLoop
from gyrostat.control.underactuated.two_wheel_law import (
    BRAKING_SHARE,
    GYROSCOPIC_SHARE,
    Way,
    brake,
    largest_inertia,
)
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp


class ThreeAxisLaw(Checked):
    """Commanded rate as a function of attitude, for working axes that span space.

    The body turns about the axis of the attitude error. The turn can be stopped within the wheels'
    torque. It is slow enough for the wheels to turn their momentum with the body, and needs no more
    momentum than they have left. B. Wie, "Space Vehicle Dynamics and Control", section 7.3
    (eigenaxis rotations under limits).

    `MomentumRecovery` follows a reference by this law: it applies the law in axes of the reference
    and adds the torque of `gyrostat.control.guidance.Guide`, so that there is no lag. Without a
    reference, the target is assumed to be at rest. If it turns at a constant rate W, the body lags
    by W (1 / k + 1 / k_t), with the gains k of `WheelRateLoop` and k_t of this law: 5.25 s times W
    with the default gains. `WheelArrayControl` has the derivation.

    Attributes:
        wheels: Rate loop that follows the commanded rate; it has the inertia and the limits.
        target: Target quaternion, scalar first, (4,).
        total_momentum: Total momentum H in inertial axes, (3,), N·m·s.
        turn_gain: Gain k_t of a small attitude error, 1/s.
        largest_rate: Largest commanded rate, rad/s.
    """

    wheels: WheelRateLoop
    target: Quaternion
    total_momentum: Vector3
    turn_gain: Annotated[Scalar, positive("turn gain", "1/s")] = 0.25
    largest_rate: Annotated[Scalar, positive("largest rate", "rad/s")] = 0.1

    def __call__(
        self, attitude: Quaternion, held: Scalar, momentum: PerWheel, way: Way
    ) -> tuple[Vector3, Way]:
        """Commanded body rate.

        Args:
            attitude: Attitude quaternion, scalar first, (4,).
            held: Unused.
            momentum: Wheel momentum at which the body would be at rest in this attitude, (wheels,),
                N·m·s.
            way: Unused; returned unchanged.

        Returns:
            Body rate, (3,), rad/s, and `way`.
        """
        del held
        wheels = self.wheels
        error = rotations.rotation_vector(rotations.error(attitude, self.target))
        angle = jnp.sqrt(error @ error + 1e-24)
        axis = error / angle
        slowing = BRAKING_SHARE * wheels.torque_anywhere() / largest_inertia(wheels.inertia)
        rate = brake(angle, self.turn_gain, slowing)
        body = rotations.to_body(attitude, self.total_momentum)
        share = jnp.abs(wheels.allocation @ jnp.cross(body, axis))
        turning = jnp.min(wheels.torque_limit / jnp.maximum(share, 1e-9))
        # turning back along the error gives the wheels momentum along it
        room, _ = wheels.room(momentum, jnp.asarray(wheels.inertia) @ axis)
        limit = jnp.minimum(self.largest_rate, GYROSCOPIC_SHARE * turning)
        return -axis * jnp.minimum(rate, jnp.minimum(limit, jnp.maximum(room, 1e-4))), way
