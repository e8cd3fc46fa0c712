"""Orbit in closed form: a circle, a dipole field, a fixed Sun and an Earth that turns."""

import numpy as np

from gyrostat.spacecraft.environment import EARTH
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment, OrbitSamples

RADIUS = 6878e3
RATE = float(np.sqrt(EARTH / RADIUS**3))
INCLINATION = np.radians(60.0)
EARTH_RATE = 7.292115e-5
SUN = 1.495978707e11 * np.array([np.cos(0.3), np.sin(0.3) * 0.9, np.sin(0.3) * np.sqrt(0.19)])
DIPOLE = 7.8e15  # T·m³, along -z


def position(time, inclination=INCLINATION):
    angle = RATE * np.asarray(time, dtype=float)
    across = np.sin(angle)
    turned = [np.cos(angle), across * np.cos(inclination), across * np.sin(inclination)]
    return RADIUS * np.stack(turned, axis=-1)


def velocity(time, inclination=INCLINATION):
    angle = RATE * np.asarray(time, dtype=float)
    along = np.cos(angle)
    turned = [-np.sin(angle), along * np.cos(inclination), along * np.sin(inclination)]
    return RADIUS * RATE * np.stack(turned, axis=-1)


def field(time, inclination=INCLINATION):
    place = position(time, inclination)
    up = place / RADIUS
    axis = np.array([0.0, 0.0, -1.0])
    return DIPOLE / RADIUS**3 * (3.0 * (up @ axis)[..., None] * up - axis)


def density(time):
    return 1e-12 * np.exp(0.5 * np.sin(RATE * np.asarray(time, dtype=float)))


def earth(time):
    half = 0.5 * EARTH_RATE * np.asarray(time, dtype=float)
    return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)


def noon(duration=6000.0, step=20.0):
    """Tables of a polar orbit that starts between Earth and Sun, both along x."""
    return environment(duration, step, 0.5 * np.pi, np.linalg.norm(SUN) * np.eye(3)[0])


def environment(duration=6000.0, step=10.0, inclination=INCLINATION, sun=SUN, moon=None):
    """Tables of this orbit."""
    times = np.arange(0.0, duration + 4.0 * step, step)
    samples = OrbitSamples(
        position(times, inclination),
        velocity(times, inclination),
        np.tile(sun, (len(times), 1)),
        field(times, inclination),
        density(times),
        earth(times),
        None if moon is None else np.tile(moon, (len(times), 1)),
    )
    return OrbitEnvironment.of(step, samples, 2.0 * np.pi / RATE)
