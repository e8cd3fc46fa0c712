"""Torque of a residual magnetic dipole in the Earth's field."""

from typing import Annotated

import equinox as eqx

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, three
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.wheel.array import listed


class ResidualDipole(Checked):
    """Torque of a constant magnetic dipole of the spacecraft, T = m x B.

    J. R. Wertz (ed.), "Spacecraft Attitude Determination and Control", section 17.2.

    Attributes:
        orbit: Orbit with the magnetic field.
        dipole: Magnetic dipole m in body axes, (3,), A·m².
    """

    orbit: OrbitEnvironment
    dipole: Annotated[Vector3, three("residual dipole", "A·m²")] = eqx.field(converter=listed)

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m; see `gyrostat.spacecraft.TorqueModel`."""
        del spacecraft
        return jnp.cross(jnp.asarray(self.dipole), to_body(attitude, self.orbit.field(time)))
