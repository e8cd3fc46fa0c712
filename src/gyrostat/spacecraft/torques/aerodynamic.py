"""Torque of air drag on the facets of a spacecraft."""

from typing import Annotated

import numpy as np

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, size
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body, to_inertial
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.spacecraft import Spacecraft

EARTH_RATE = 7.292115e-5
"""Rotation rate of the Earth, rad/s (WGS 84)."""


class AerodynamicTorque(Checked):
    """Torque of air drag in free molecular flow, F = -1/2 density C A max(0, n·v) v per facet.

    v is the velocity relative to an atmosphere that rotates with the Earth. The rotation of the
    body, lift and shading of facets by each other are neglected. The force acts at the centre of
    the facet and its torque is about the centre of mass. F. L. Markley, J. L. Crassidis,
    "Fundamentals of Spacecraft Attitude Determination and Control", section 3.3.6. A facet parallel
    to the flow is a kink; derivatives there are those of the side on which it has no force.

    Attributes:
        orbit: Orbit with the air density.
        drag_coefficient: Drag coefficient C of every facet, usually 2 to 2.5.
        density_scale: Factor of the air density.
    """

    orbit: OrbitEnvironment
    drag_coefficient: Annotated[Scalar, size("drag coefficient")]
    density_scale: Annotated[Scalar, size("scale of the air density")] = 1.0

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m; see `gyrostat.spacecraft.TorqueModel`.

        Raises:
            InputError: The spacecraft has no surfaces.
        """
        facets = spacecraft.facets("aerodynamic torque")
        flow = to_body(attitude, self.relative_velocity(time))
        normal = jnp.asarray(facets.normal) @ flow
        pressure = 0.5 * self.density_scale * self.orbit.density(time) * self.drag_coefficient
        # not `maximum`, whose derivative at a tie is the mean of both sides
        flux = facets.area * jnp.where(normal > 0.0, normal, 0.0)
        return facets.torque(-pressure * flux[:, None] * flow)

    def relative_velocity(self, time: Scalar) -> Vector3:
        """Velocity relative to the atmosphere, inertial axes, (3,), m/s, at a time, s."""
        axis = to_inertial(self.orbit.earth(time), jnp.asarray(np.eye(3)[2]))
        wind = jnp.cross(EARTH_RATE * axis, self.orbit.position(time))
        return self.orbit.velocity(time) - wind
