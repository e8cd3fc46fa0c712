"""Views along an orbit, which begin and end: of a ground station, and of the Sun.

A view is a callable time, s -> a number above 0 while it lasts.
"""

from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, signed
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import direction_at, to_inertial
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.torques.eclipse import sunlight


class StationView(Checked):
    """View of the spacecraft from a ground station; without refraction.

    Attributes:
        orbit: Orbit.
        latitude: Geodetic latitude (WGS 84), rad.
        longitude: Longitude, to the east, rad.
        height: Height above the ellipsoid, m.
        least_elevation: Elevation above which it lasts, rad.
    """

    orbit: OrbitEnvironment
    latitude: Annotated[Scalar, signed("latitude of the station", "rad")]
    longitude: Annotated[Scalar, signed("longitude of the station", "rad")]
    height: Annotated[Scalar, signed("height of the station", "m")] = 0.0
    least_elevation: Annotated[Scalar, signed("least elevation", "rad")] = 0.0

    def elevation(self, time: Scalar) -> Scalar:
        """Elevation above the plane across the geodetic vertical at a time, s; rad."""
        place = (self.latitude, self.longitude, self.height)
        sight = self.orbit.position(time) - self.orbit.ground(*place, time)
        vertical = direction_at(self.longitude, self.latitude)
        up = sight @ to_inertial(self.orbit.earth(time), vertical)
        return jnp.arctan2(up, jnp.sqrt(sight @ sight - up**2))

    def __call__(self, time: Scalar) -> Scalar:
        """Elevation above the least one at a time, s; rad."""
        return self.elevation(time) - self.least_elevation


class Sunlight(Checked):
    """Sunlight on the spacecraft, which ends where half of the Sun's disc is behind the Earth.

    Attributes:
        orbit: Orbit.
    """

    orbit: OrbitEnvironment

    def __call__(self, time: Scalar) -> Scalar:
        """Visible share of the Sun's disc less a half, at a time, s."""
        return sunlight(self.orbit.position(time), self.orbit.sun(time)) - 0.5
