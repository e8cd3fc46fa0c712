"""Conditions on the measured direction of the Sun, for changes of mode."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np

from gyrostat.control.attitude.sun_pointing import measured_sun
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, direction, positive
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import listed


class SunCondition(Checked):
    """Whether the Sun is seen near a body axis, or is not seen there.

    Attributes:
        axis: Body axis, (3,), of any length.
        angle: Angle from the axis within which the Sun counts as seen, rad.
        is_lost: Whether the condition is that it is not seen there.
    """

    axis: Annotated[Vector3, direction("axis of the condition")] = eqx.field(
        converter=listed, default_factory=lambda: np.array([0.0, 0.0, 1.0])
    )
    angle: Annotated[Scalar, positive("angle of the condition", "rad")] = np.pi
    is_lost: bool = eqx.field(static=True, default=False)

    def __call__(self, measurement: Any, time: Scalar) -> Scalar:
        """Compute a number above 0 while the condition holds, rad.

        Args:
            measurement: Measurement with `sun_sensor` or `coarse_sun_sensors`, see `measured_sun`.
            time: Time, s; unused.

        Raises:
            InputError: The measurement has no sensor of the Sun.
        """
        axis, sun = jnp.asarray(self.axis), measured_sun(measurement)
        across = jnp.cross(axis, sun)
        angle = jnp.arctan2(jnp.sqrt(across @ across), axis @ sun)
        # a tolerance, so that pi is any direction in which the Sun is seen
        inside = jnp.where(sun @ sun > 0.0, self.angle + 1e-9 - angle, -1.0)
        return -inside if self.is_lost else inside
