"""Sunlight behind the Earth: visible share of the Sun's disc.

Sun and Earth are seen as discs whose radii are their apparent angular radii, and the part of the
Sun's disc behind that of the Earth is the overlap of two circles in a plane. O. Montenbruck,
E. Gill, "Satellite Orbits", section 3.4.2. The Earth is a sphere with its equatorial radius,
without atmosphere. The circle in the plane is an approximation of the limb of the Earth, which
changes the share by less than 3e-4 in the penumbra of a low orbit.
"""

import numpy as np

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS

SUN_RADIUS = 6.957e8
"""Radius of the Sun, m (IAU 2015, resolution B3)."""


def sunlight(position: Vector3, sun: Vector3) -> Scalar:
    """Visible share of the Sun's disc, 0 (umbra) to 1 (full sunlight).

    The share and its first derivatives are continuous; the derivatives are finite everywhere.

    Args:
        position: Position of the spacecraft from the centre of the Earth, (3,), m.
        sun: Position of the Sun from the centre of the Earth, in the same axes, (3,), m.
    """
    to_sun = sun - position
    return visible_share(
        _apparent_radius(SUN_RADIUS, to_sun),
        _apparent_radius(EARTH_RADIUS, position),
        _angle(to_sun, -position),
    )


def visible_share(own: Scalar, other: Scalar, distance: Scalar) -> Scalar:
    """Share of a disc that is not covered by another disc.

    Args:
        own: Radius of the disc.
        other: Radius of the disc in front, in the same unit.
        distance: Distance of the centres, in the same unit.
    """
    is_apart = distance >= own + other
    inside = distance <= jnp.abs(own - other)
    # where the circles do not intersect, unused finite values
    none = is_apart | inside
    a, b, c = (jnp.where(none, 1.0, value) for value in (own, other, distance))
    # Triangle of the centres and an intersection: four times its area, by Heron's formula. The
    # differences are those of the comparisons above, so that no factor is rounded to 0.
    area = jnp.sqrt((a + b + c) * ((a + b) - c) * (c - (b - a)) * (c - (a - b)))
    # half angles of the arcs; arctan2 has finite derivatives where arccos has none
    first = jnp.arctan2(area, (c - b) * (c + b) + a**2)
    second = jnp.arctan2(area, (c - a) * (c + a) + b**2)
    lens = (a**2 * first + b**2 * second - 0.5 * area) / (np.pi * a**2)
    smaller = jnp.where(other < own, other, own) / own
    return 1.0 - jnp.where(is_apart, 0.0, jnp.where(inside, smaller**2, lens))


def _apparent_radius(radius: float, centre: Vector3) -> Scalar:
    """Angular radius of a sphere, rad; of its surface, 90 degrees."""
    margin = centre @ centre - radius**2
    outside = margin > 0.0
    return jnp.where(
        outside, jnp.arctan2(radius, jnp.sqrt(jnp.where(outside, margin, 1.0))), 0.5 * np.pi
    )


def _angle(first: Vector3, second: Vector3) -> Scalar:
    """Angle between two vectors, rad, with finite derivatives for parallel vectors too."""
    normal = jnp.cross(first, second)
    squared = normal @ normal
    across = jnp.where(squared > 0.0, jnp.sqrt(jnp.where(squared > 0.0, squared, 1.0)), 0.0)
    return jnp.arctan2(across, first @ second)
