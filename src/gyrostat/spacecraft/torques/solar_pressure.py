"""Torque of solar radiation pressure on the facets of a spacecraft."""

from typing import Annotated

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, size
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.spacecraft.orbit.earth import ASTRONOMICAL_UNIT
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.torques.eclipse import sunlight

SOLAR_CONSTANT = 1361.0
"""Total solar irradiance at 1 au, W/m² (IAU 2015, resolution B3)."""
LIGHT_SPEED = 299792458.0
"""Speed of light, m/s."""


class SolarPressureTorque(Checked):
    """Torque of sunlight, F = -P A max(0, n·s) ((1 - a) s + 2 (a n·s + d / 3) n) on each facet.

    s is the direction of the Sun, a the specular and d the diffuse share of the light, and P the
    solar constant over the speed of light, scaled by the squared distance and by the visible share
    of the Sun's disc (`gyrostat.spacecraft.torques.eclipse`). Light reflected by the Earth, thermal
    radiation and shading of facets by each other are neglected. The force acts at the centre of the
    facet and its torque is about the centre of mass. F. L. Markley, J. L. Crassidis, "Fundamentals
    of Spacecraft Attitude Determination and Control", section 3.3.6; J. R. Wertz (ed.), "Spacecraft
    Attitude Determination and Control", section 17.2. A facet parallel to the light is a kink;
    derivatives there are those of the side on which it has no force.

    Attributes:
        orbit: Orbit with the position of the Sun.
        scale: Factor of the pressure.
    """

    orbit: OrbitEnvironment
    scale: Annotated[Scalar, size("scale of the solar radiation pressure")] = 1.0

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m; see `gyrostat.spacecraft.TorqueModel`.

        Raises:
            InputError: The spacecraft has no surfaces.
        """
        facets = spacecraft.facets("solar pressure torque")
        position, sun = self.orbit.position(time), self.orbit.sun(time)
        squared = (sun - position) @ (sun - position)
        direction = to_body(attitude, (sun - position) / jnp.sqrt(squared))
        pressure = self.scale * (SOLAR_CONSTANT / LIGHT_SPEED) * ASTRONOMICAL_UNIT**2 / squared
        pressure = pressure * sunlight(position, sun)
        normal = jnp.asarray(facets.normal)
        cosine = normal @ direction
        # not `maximum`, whose derivative at a tie is the mean of both sides
        lit = facets.area * jnp.where(cosine > 0.0, cosine, 0.0)
        along = lit * (1.0 - jnp.asarray(facets.specular))
        across = lit * 2.0 * (facets.specular * cosine + jnp.asarray(facets.diffuse) / 3.0)
        # the forces along the light are parallel: one product with the sum of the weighted arms
        centre = jnp.asarray(facets.centre)
        moment = jnp.cross(along @ centre, direction) + across @ jnp.cross(centre, normal)
        return -pressure * moment
