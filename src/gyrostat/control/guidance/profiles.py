"""Attitude profiles: fixed attitude, nadir pointing on a circular orbit, table.

A profile is a callable time, s -> unit quaternion (4,), scalar first.
"""

from typing import Annotated, Self

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control.guidance.pointing import check_axes, frame_of_axes
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.checked import Checked, Rule
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.limiting import within
from gyrostat.spacecraft.environment import CircularOrbit

LARGEST_STEP = np.radians(60.0)
"""Largest rotation between two rows of a table, rad. The rotation of larger steps is uncertain."""

is_unit = Rule("of unit length", rotations.check_unit)


class Fixed(Checked):
    """Constant attitude.

    Attributes:
        attitude: Unit quaternion, scalar first, (4,).
    """

    attitude: Annotated[Quaternion, is_unit]

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time, s."""
        del time
        return jnp.asarray(self.attitude, dtype=float)


class Nadir(Checked):
    """Nadir pointing on a circular orbit: one body axis to the Earth, another along the velocity.

    The orbit is the one of `gyrostat.spacecraft.GravityGradient`. The frame of zenith, velocity and
    orbit normal has the 3-1-3 angles (ascending node, inclination, argument of latitude). It turns
    at the mean motion about the orbit normal.

    Attributes:
        orbit: Circular orbit.
        body: Attitude of the body relative to this frame, a quaternion, (4,); see `pointing`.
    """

    orbit: CircularOrbit
    body: Quaternion

    @classmethod
    def pointing(
        cls,
        orbit: CircularOrbit,
        to_earth: ArrayLike = (0.0, 0.0, 1.0),
        along: ArrayLike = (1.0, 0.0, 0.0),
    ) -> Self:
        """Create the profile from two body axes.

        Args:
            orbit: Circular orbit.
            to_earth: Body axis that points to the centre of the Earth, (3,), of any length.
            along: Body axis whose part across `to_earth` points along the velocity, (3,). If both
                axes are parallel, `check` refuses the profile.
        """
        down, forward = (jnp.asarray(axis, dtype=float) for axis in (to_earth, along))
        # zenith, velocity and orbit normal in body axes
        return cls(orbit, frame_of_axes(-down, forward))

    def check_own(self) -> None:
        """Validate the body axes.

        Raises:
            InputError: They are parallel.
        """
        check_axes(self.body)

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time, s."""
        orbit = self.orbit
        angles = rotations.EulerAngles(
            jnp.asarray(orbit.ascending_node, dtype=float),
            orbit.inclination,
            orbit.latitude + orbit.rate * time,
        )
        return rotations.product(rotations.from_euler(angles), jnp.asarray(self.body))


class Table(Checked):
    """Attitude from a table, interpolated by a cubic spline of the quaternion.

    The spline of the four components (not-a-knot ends) is scaled to unit length. Attitude, rate and
    acceleration are continuous. For rows at a distance h, the error is of order h⁴ for the
    attitude, h³ for the rate and h² for the acceleration. Noise of the rows is amplified in rate
    and acceleration: smooth measured attitudes first. Before the first and after the last row, the
    attitude is constant, so that the rate has a step there unless the table begins or ends at rest.

    Attributes:
        times: Times of the rows, (rows,), increasing, s.
        attitudes: Quaternions of the rows, without changes of sign, (rows, 4).
        slopes: Time derivatives of the spline in the rows, (rows, 4), 1/s.
    """

    times: Float[Array, " rows"]
    attitudes: Float[Array, "rows 4"]
    slopes: Float[Array, "rows 4"]

    @classmethod
    def of(cls, times: ArrayLike, attitudes: ArrayLike) -> Self:
        """Create the profile from a table.

        Args:
            times: Times, increasing, (rows,), s.
            attitudes: Quaternions, scalar first, (rows, 4). The sign of each is ignored.

        Raises:
            InputError: There are fewer than four rows, the times do not increase, an attitude is
                not of unit length, or two successive attitudes differ by more than `LARGEST_STEP`.
        """
        times, table = np.asarray(times, dtype=float), np.asarray(attitudes, dtype=float)
        if times.ndim != 1 or len(times) < 4 or table.shape != (len(times), 4):
            raise InputError(
                f"attitude table: found shapes {times.shape} and {table.shape}, expected (rows,) "
                "and (rows, 4) with four rows or more"
            )
        late = np.flatnonzero(~(np.diff(times) > 0.0))
        if not np.all(np.isfinite(times)) or len(late):
            row = int(late[0]) + 1 if len(late) else int(np.argmin(np.isfinite(times)))
            raise InputError(
                f"attitude table, row {row}: found the time {times[row]:g} s, expected a later one "
                "than in the row before"
            )
        rotations.check_unit(jnp.asarray(table))
        cosines = np.sum(table[1:] * table[:-1], axis=1)
        wide = np.flatnonzero(np.abs(cosines) < np.cos(0.5 * LARGEST_STEP))
        if len(wide):
            angle = np.degrees(2.0 * np.arccos(abs(cosines[wide[0]])))
            raise InputError(
                f"attitude table, row {wide[0] + 1}: found a rotation of {angle:.3g} deg from the "
                f"row before, expected {np.degrees(LARGEST_STEP):g} deg or less"
            )
        from scipy.interpolate import CubicSpline  # slow to import, and only tables need it

        signs = np.cumprod(np.append(1.0, np.where(cosines < 0.0, -1.0, 1.0)))
        table = table * signs[:, None]
        slopes = CubicSpline(times, table)(times, 1)
        return cls(jnp.asarray(times), jnp.asarray(table), jnp.asarray(slopes))

    def __call__(self, time: Scalar) -> Quaternion:
        """Attitude at a time, s."""
        times = jnp.asarray(self.times)
        time = within(time, times[0], times[-1])
        row = jnp.clip(_last_before(times, time), 0, len(self.times) - 2)
        attitudes, slopes = jnp.asarray(self.attitudes), jnp.asarray(self.slopes)
        length = times[row + 1] - times[row]
        share, step = (time - times[row]) / length, attitudes[row + 1] - attitudes[row]
        first, last = length * slopes[row], length * slopes[row + 1]
        cubic, square = first + last - 2.0 * step, 3.0 * step - 2.0 * first - last
        rise = ((cubic * share + square) * share + first) * share
        return rotations.normalised(attitudes[row] + rise)


def _last_before(times: Float[Array, " rows"], time: Scalar) -> Array:
    """Index of the last time that is not after `time`, by bisection with a fixed count."""
    rows = len(times)

    def halve(_: int, bounds: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bounds
        middle = (low + high) // 2
        is_later = times[middle] > time
        return jnp.where(is_later, low, middle), jnp.where(is_later, middle, high)

    low, high = jnp.array(0), jnp.array(rows)
    return jax.lax.fori_loop(0, int(rows).bit_length(), halve, (low, high))[0]
