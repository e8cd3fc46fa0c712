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
    """Rate over attitude, for working axes that span space: a turn about the error axis.

    The turn brakes within the wheels' torque, is slow enough that they can turn their momentum with
    the body, and takes up no more momentum than they have left. B. Wie, "Space Vehicle Dynamics and
    Control", section 7.3 (eigenaxis rotations under limits).

    The target is taken to be at rest. Behind one that turns at a constant rate W the body stays by
    W (1 / k + 1 / k_t), with the gains k of `WheelRateLoop` and k_t of this law: 5.25 s times W
    with the default gains. `WheelArrayControl` derives it.

    Attributes:
        wheels: the loop that will follow the rate; gives inertia and limits.
        target: (4,) attitude to reach.
        total_momentum: (3,) H in inertial axes, N·m·s.
        turn_gain: 1/s.
        largest_rate: rad/s.
    """

    wheels: WheelRateLoop
    target: Quaternion
    total_momentum: Vector3
    turn_gain: Annotated[Scalar, positive("turn gain", "1/s")] = 0.25
    largest_rate: Annotated[Scalar, positive("largest rate", "rad/s")] = 0.1

    def __call__(
        self, attitude: Quaternion, held: Scalar, momentum: PerWheel, way: Way
    ) -> tuple[Vector3, Way]:
        """The rate to follow.

        Args:
            attitude: (4,) quaternion, scalar first.
            held: unused.
            momentum: (wheels,) that would bring the body to rest here, N·m·s.
            way: unused, returned as it is.

        Returns:
            The body rate, rad/s, and `way`.
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
