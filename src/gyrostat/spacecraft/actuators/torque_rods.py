"""Magnetic torque rods (magnetorquers)."""

from typing import Annotated

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive_share, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.wheel.array import UNIT_TOLERANCE, listed


class TorqueRods(Checked):
    """Torque T = s m x B of rods with the total dipole moment m in the Earth's field B.

    m = sum a_i m_i, with the commanded dipole moment m_i of each rod within its limit. The torque
    along B is zero. The rods have neither hysteresis nor a time constant. J. R. Wertz, "Spacecraft
    Attitude Determination and Control", section 6.7.

    The rods are on for the share s of each control period; the magnetometer measures while they are
    off. The torque acts with its mean over the period. This is accurate if the body turns little in
    a period.

    Attributes:
        orbit: Orbit with the magnetic field.
        limit: Largest dipole moment of each rod, (rods,), or one value for all, A·m².
        axes: Axes of the rods in body axes, unit length, one column for each rod, (3, rods).
        duty: Share s of each control period in which the rods are on.
    """

    orbit: OrbitEnvironment
    limit: Annotated[Float[Array, " rods"] | float, size("dipole limit", "A·m²")] = eqx.field(
        converter=listed
    )
    axes: Float[Array, "3 rods"] = eqx.field(converter=listed, default_factory=lambda: np.eye(3))
    duty: Annotated[Scalar, positive_share("duty of the torque rods")] = 1.0

    def check_own(self) -> None:
        """Validate the axes.

        Raises:
            InputError: The axes are not (3, rods) or not of unit length.
        """
        axes = np.asarray(self.axes, dtype=float)
        if axes.ndim < 2 or axes.shape[-2] != 3:
            raise InputError(f"axes of the torque rods: found shape {axes.shape}, expected (3, n)")
        lengths = np.linalg.norm(axes, axis=-2)
        if not np.all(np.abs(lengths - 1.0) < UNIT_TOLERANCE):
            raise InputError("axes of the torque rods: found another length, expected unit vectors")

    def __call__(self, value: Float[Array, " rods"], attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m.

        Args:
            value: Commanded dipole moments, (rods,), A·m².
            attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
            time: Time, s.

        Raises:
            InputError: There is not one dipole moment for each rod.
        """
        axes = jnp.asarray(self.axes)
        if jnp.shape(value) != axes.shape[1:]:
            raise InputError(
                f"torque rods: found a command of shape {jnp.shape(value)}, expected "
                f"({axes.shape[1]},), one dipole moment for each rod"
            )
        dipole = axes @ jnp.clip(value, -self.limit, self.limit)
        return self.duty * jnp.cross(dipole, to_body(attitude, self.orbit.field(time)))
