"""A low, slightly eccentric orbit with simple surroundings, for tests of parts in an orbit."""

import numpy as np

from gyrostat.spacecraft.orbit.earth import EARTH
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment, OrbitSamples

RADIUS, ECCENTRICITY, INCLINATION = 6.8e6, 0.01, 0.9
PERIOD = 2.0 * np.pi * np.sqrt(RADIUS**3 / EARTH)
STEP = 30.0
ROWS = STEP * np.arange(200)
SUN = 1.49e11
"""Distance of the Sun, m."""


def samples(time=ROWS):
    """Kepler's orbit; a Sun that moves, a turning field and an Earth with a tilted axis."""
    mean = 2.0 * np.pi * time / PERIOD
    anomaly = mean
    for _ in range(20):
        anomaly = mean + ECCENTRICITY * np.sin(anomaly)
    minor = np.sqrt(1.0 - ECCENTRICITY**2)
    speed = 2.0 * np.pi / PERIOD / (1.0 - ECCENTRICITY * np.cos(anomaly))
    tilt = np.array([[1, 0], [0, np.cos(INCLINATION)], [0, np.sin(INCLINATION)]])
    plane = np.array([np.cos(anomaly) - ECCENTRICITY, minor * np.sin(anomaly)])
    moving = speed * np.array([-np.sin(anomaly), minor * np.cos(anomaly)])
    position, velocity = (RADIUS * (tilt @ each).T for each in (plane, moving))
    sun = SUN * np.stack([np.cos(2e-7 * time), np.sin(2e-7 * time), 0.1 + 0.0 * time], axis=1)
    field = 3e-5 * np.stack([np.cos(mean), np.sin(2 * mean), 0.5 + 0.0 * mean], axis=1)
    density = 1e-11 * np.exp(-(np.linalg.norm(position, axis=1) - RADIUS) / 6e4)
    half = 0.5 * (1.0 + 7.292115e-5 * time)
    tilted = np.array([np.cos(0.05), np.sin(0.05), 0.0, 0.0])  # about x, then turning about z
    turned = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)
    a, b = tilted[0], tilted[1]
    c, s = turned[:, 0], turned[:, 3]
    earth = np.stack([a * c, b * c, -b * s, a * s], axis=1)
    return OrbitSamples(position, velocity, sun, field, density, earth)


def environment(given=None, step=STEP):
    return OrbitEnvironment.of(step, given or samples(), PERIOD)
