"""Circular orbit in the field of an axial dipole, for tests that need no libraries."""

import numpy as np

from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_RADIUS
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment, OrbitSamples

DIPOLE = 7.8e15
"""Dipole moment of the Earth times mu_0 / 4 pi, T·m³."""
ASTRONOMICAL_UNIT = 1.495978707e11


def dipole_field(position):
    """Field of a dipole along -z, (rows, 3), T, at positions, (rows, 3), m."""
    size = np.linalg.norm(position, axis=-1, keepdims=True)
    radial, along = position / size, np.array([0.0, 0.0, -1.0])
    return DIPOLE / size**3 * (3.0 * (radial @ along)[..., None] * radial - along)


def mean_motion(altitude=500e3):
    """Mean motion, rad/s."""
    return np.sqrt(EARTH / (EARTH_RADIUS + altitude) ** 3)


def dipole_orbit(duration, step=20.0, altitude=500e3, inclination=np.pi / 2):
    """Orbit from the ascending node on the x axis, for a duration, s; the Sun is along x."""
    rate, radius = mean_motion(altitude), EARTH_RADIUS + altitude
    times = np.arange(0.0, duration + 4.0 * step, step)
    cosine, sine = np.cos(rate * times), np.sin(rate * times)
    level, up = np.cos(inclination), np.sin(inclination)
    position = radius * np.stack([cosine, level * sine, up * sine], 1)
    velocity = rate * radius * np.stack([-sine, level * cosine, up * cosine], 1)
    each = np.ones((len(times), 1))
    samples = OrbitSamples(
        position,
        velocity,
        ASTRONOMICAL_UNIT * each * np.array([1.0, 0.0, 0.0]),
        dipole_field(position),
        np.full(len(times), 1e-13),
        each * np.array([1.0, 0.0, 0.0, 0.0]),
    )
    return OrbitEnvironment.of(step, samples, 2.0 * np.pi / rate)
