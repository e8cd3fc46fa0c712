"""Position, Sun, Moon, magnetic field and air density along an orbit, interpolated over time.

Libraries compute tables before the simulation (`gyrostat.spacecraft.orbit.tables`); in a run they
are only interpolated. Inertial axes are those of the GCRS.
"""

from dataclasses import replace
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, signed
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.limiting import within
from gyrostat.core.rotations import normalised, to_inertial
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_RADIUS

FLATTENING = 1.0 / 298.257223563
"""Flattening of the Earth (WGS 84)."""


class OrbitSamples(NamedTuple):
    """Values along an orbit at equidistant times, NumPy arrays.

    Attributes:
        position: Position from the centre of the Earth, GCRS, (rows, 3), m.
        velocity: Inertial velocity, GCRS, (rows, 3), m/s.
        sun: Position of the Sun from the centre of the Earth, GCRS, (rows, 3), m.
        field: Magnetic flux density of the Earth, in axes of the GCRS, (rows, 3), T.
        density: Air density, (rows,), kg/m³; above 0.
        earth: Attitude of the ITRF with respect to the GCRS, quaternions, scalar first, without
            changes of sign from row to row, (rows, 4).
        moon: Position of the Moon from the centre of the Earth, GCRS, (rows, 3), m; None: left out.
    """

    position: Float[np.ndarray, "rows 3"]
    velocity: Float[np.ndarray, "rows 3"]
    sun: Float[np.ndarray, "rows 3"]
    field: Float[np.ndarray, "rows 3"]
    density: Float[np.ndarray, " rows"]
    earth: Float[np.ndarray, "rows 4"]
    moon: Float[np.ndarray, "rows 3"] | None = None


CHANNELS = {
    **{"position": (0, 3), "velocity": (3, 6), "sun": (6, 9), "field": (9, 12)},
    **{"density": (12, 13), "earth": (13, 17), "moon": (17, 20)},
}
"""Value -> its first channel in the tables, and the one after its last; the Moon can be absent."""


class OrbitEnvironment(Checked):
    """Orbit and its environment as functions of time.

    Cubic splines with not-a-knot ends between equidistant rows. The density is interpolated by its
    logarithm. Beyond the first and the last row, the values of these rows hold.

    Attributes:
        splines: Values in the rows and sixths of their second derivatives over the share of the
            step, (rows, 2, channels), see `spline_of`.
        step: Time between rows, s.
        period: Orbital period, s; scale of `offset`.
        offset: Time of the tables at time 0 of the run, s. It moves the start of the run along the
            orbit, with the Earth and the Sun at that time.
        position_error: Added to the position, GCRS, (3,), m, as the error of a navigation
            solution; None for none.
    """

    splines: Float[Array, "rows 2 channels"]
    step: Annotated[Scalar, positive("step of the orbit tables", "s")]
    period: Annotated[Scalar, positive("orbital period", "s")]
    offset: Annotated[Scalar, signed("offset of the orbit tables", "s")] = 0.0
    position_error: Annotated[Vector3 | None, signed("position error", "m")] = None

    @classmethod
    def of(cls, step: float, samples: OrbitSamples, period: float) -> Self:
        """Create the environment from values at equidistant times.

        Args:
            step: Time between rows, s; the first row is at time 0.
            samples: Values, four rows or more.
            period: Orbital period, s.

        Raises:
            InputError: There are fewer than four rows, a value is not finite, or a density is not
                above 0.
        """
        density = np.asarray(samples.density, dtype=float)
        if len(density) < 4:
            raise InputError(f"orbit tables: found {len(density)} rows, expected four or more")
        if not np.all(density > 0.0):
            raise InputError(
                f"orbit tables: found the air density {np.min(density):g} kg/m³, expected above 0"
            )
        columns = [*samples[:4], np.log(density)[:, None], samples.earth]
        columns += [] if samples.moon is None else [samples.moon]
        rows = np.concatenate([np.asarray(column, dtype=float) for column in columns], axis=1)
        if not np.all(np.isfinite(rows)):
            row = int(np.argmin(np.all(np.isfinite(rows), axis=1)))
            raise InputError(
                f"orbit tables, row {row}: found a value that is not finite, expected finite ones"
            )
        return cls(spline_of(rows), step, period)

    def until(self, end: float) -> Self:
        """Environment without most of the rows after a time.

        The splines stay the same to the last bit. Splines through fewer rows would not: their end
        changes the pieces before it.

        Args:
            end: Time, s; tables that end before are returned as they are.
        """
        rows = np.asarray(self.splines)
        count = int(np.ceil((float(self.offset) + end) / float(self.step))) + 2
        return replace(self, splines=rows[:count])

    def _at(self, time: Scalar, name: str) -> Array:
        """Channels of a value at a time, s."""
        return interpolated(
            jnp.asarray(self.splines), (self.offset + time) / self.step, *CHANNELS[name]
        )

    def position(self, time: Scalar) -> Vector3:
        """Position from the centre of the Earth, GCRS, (3,), m, at a time, s."""
        position = self._at(time, "position")
        return position if self.position_error is None else position + self.position_error

    def zenith(self, time: Scalar) -> Vector3:
        """Unit vector from the centre of the Earth to the spacecraft, GCRS, (3,), at a time, s."""
        position = self.position(time)
        return position / jnp.sqrt(position @ position)

    def gradient(self, time: Scalar) -> Scalar:
        """Gravitational parameter of the Earth over the cubed distance, 1/s², at a time, s."""
        position = self.position(time)
        squared = position @ position
        return EARTH / (squared * jnp.sqrt(squared))

    def velocity(self, time: Scalar) -> Vector3:
        """Inertial velocity, GCRS, (3,), m/s, at a time, s."""
        return self._at(time, "velocity")

    def sun(self, time: Scalar) -> Vector3:
        """Position of the Sun from the centre of the Earth, GCRS, (3,), m, at a time, s."""
        return self._at(time, "sun")

    @property
    def has_moon(self) -> bool:
        """Whether the tables hold the Moon."""
        return np.shape(self.splines)[-1] >= CHANNELS["moon"][1]

    def moon(self, time: Scalar) -> Vector3:
        """Position of the Moon from the centre of the Earth, GCRS, (3,), m, at a time, s."""
        return self._at(time, "moon")

    def field(self, time: Scalar) -> Vector3:
        """Magnetic flux density of the Earth, in axes of the GCRS, (3,), T, at a time, s."""
        return self._at(time, "field")

    def density(self, time: Scalar) -> Scalar:
        """Air density, kg/m³, at a time, s."""
        return jnp.exp(self._at(time, "density")[0])

    def earth(self, time: Scalar) -> Quaternion:
        """Attitude of the ITRF with respect to the GCRS, (4,), scalar first, at a time, s."""
        return normalised(self._at(time, "earth"))

    def ground(
        self, latitude: Scalar, longitude: Scalar, altitude: Scalar, time: Scalar
    ) -> Vector3:
        """Position of a point that turns with the Earth, GCRS, (3,), m.

        Args:
            latitude: Geodetic latitude, rad (WGS 84).
            longitude: Longitude, to the east, rad.
            altitude: Height above the ellipsoid, m.
            time: Time, s.
        """
        up, across = jnp.sin(latitude), jnp.cos(latitude)
        squared = FLATTENING * (2.0 - FLATTENING)
        radius = EARTH_RADIUS / jnp.sqrt(1.0 - squared * up**2)
        level = (radius + altitude) * across
        point = jnp.stack(
            [
                level * jnp.cos(longitude),
                level * jnp.sin(longitude),
                (radius * (1.0 - squared) + altitude) * up,
            ]
        )
        return to_inertial(self.earth(time), point)


def spline_of(rows: Float[np.ndarray, "rows channels"]) -> Any:
    """Cubic spline with not-a-knot ends, for `interpolated`, (rows, 2, channels).

    Two numbers a row determine the cubic pieces, which have four coefficients each: the value, and
    a sixth of the second derivative (C. de Boor, "A Practical Guide to Splines", chapter IV).

    Args:
        rows: Values at equidistant places, four rows or more.
    """
    from scipy.interpolate import CubicSpline  # slow to import

    places = np.arange(len(rows))
    return np.stack([rows, CubicSpline(places, rows)(places, 2) / 6.0], axis=1)


def interpolated(
    spline: Float[Array, "rows 2 channels"], share: Scalar, first: int, last: int
) -> Array:
    """Channels of a cubic spline at a place; beyond its ends, those of the end.

    Args:
        spline: Result of `spline_of`.
        share: Place, in steps from the first row.
        first: First channel.
        last: Channel after the last one.
    """
    pieces = len(spline) - 1
    row = jnp.clip(jnp.floor(share).astype(int), 0, pieces - 1)
    ends = jax.lax.dynamic_slice(spline, (row, 0, first), (2, 2, last - first))
    return on_piece(ends, within(share, 0.0, pieces) - row)


def on_piece(ends: Any, share: Any) -> Any:
    """Channels on a cubic piece.

    Args:
        ends: Rows of the spline before and after the place, (2, 2, channels).
        share: Place, in steps from the row before.
    """
    (value, bend), (next_value, next_bend) = ends
    linear = next_value - value - 2.0 * bend - next_bend
    # no product that is rounded is added to another one: with FMA all compilers give the same bits
    square = (next_bend - bend) * share + bend + 2.0 * bend
    return (square * share + linear) * share + value
