"""Where Sun, Earth and Moon are in body axes over a run."""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import angle_between, to_body
from gyrostat.core.types import Vector
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.torques.eclipse import sunlight


class BodySky(NamedTuple):
    """Sun, Earth and Moon in body axes at some times, NumPy arrays.

    Attributes:
        sun: Unit vector to the Sun, (rows, 3).
        earth: Unit vector to the centre of the Earth, (rows, 3).
        moon: Unit vector to the Moon, (rows, 3).
        radius: Apparent radius of the Earth, (rows,), rad.
        sunlight: Visible share of the Sun's disc, (rows,).
        moonlit: Whether the Moon is not behind the Earth, (rows,).
        rate: Body rate, (rows,), rad/s.
    """

    sun: Float[np.ndarray, "rows 3"]
    earth: Float[np.ndarray, "rows 3"]
    moon: Float[np.ndarray, "rows 3"]
    radius: Vector
    sunlight: Vector
    moonlit: Bool[np.ndarray, " rows"]
    rate: Vector

    def at(self, rows: Any) -> "BodySky":
        """The same at some of the times."""
        return BodySky(*(values[rows] for values in self))

    def thinned(self, most: int) -> "BodySky":
        """The same at no more than some number of times, evenly spread."""
        return self.at(np.unique(np.linspace(0, len(self.rate) - 1, most).astype(int)))


def body_sky(
    orbit: OrbitEnvironment,
    time: Vector,
    attitude: Float[np.ndarray, "rows 4"],
    rate: Float[np.ndarray, "rows 3"],
) -> BodySky:
    """Sun, Earth and Moon in body axes.

    Args:
        orbit: Orbit with the Moon.
        time: Times, (rows,), s.
        attitude: Attitude at these times, scalar first.
        rate: Body rate at these times, rad/s.
    """

    @jax.jit
    @jax.vmap
    def seen(time: Any, attitude: Any, rate: Any) -> tuple[Any, ...]:
        position, sun = orbit.position(time), orbit.sun(time)
        to_sun, to_earth, to_moon = (
            to_body(attitude, line / jnp.sqrt(line @ line))
            for line in (sun - position, -position, orbit.moon(time) - position)
        )
        radius = jnp.arcsin(EARTH_RADIUS / jnp.sqrt(position @ position))
        moonlit = angle_between(to_moon, to_earth) > radius
        share = sunlight(position, sun)
        return to_sun, to_earth, to_moon, radius, share, moonlit, jnp.sqrt(rate @ rate)

    return BodySky(*map(np.asarray, seen(jnp.asarray(time), attitude, rate)))
