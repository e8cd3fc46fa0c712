"""Orbit from positions and velocities at given times, such as those of a file."""

from dataclasses import dataclass
from typing import final

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.earth import EARTH
from gyrostat.spacecraft.orbit.elements import Trajectory
from gyrostat.spacecraft.orbit.frames import EARTH_RATE, FRAMES, States, to_gcrs
from gyrostat.spacecraft.orbit.time_scales import Epoch, Times

DEGREE, LARGEST_DEGREE = 7, 15
"""Default and largest degree of the interpolating polynomials."""
LOWEST = 6.3e6
"""Smallest distance from the centre of the Earth, m: below the surface everywhere."""
FARTHEST = 2.0
"""Largest step between rows times the local mean motion, rad: a third of a revolution."""
SHARE = 0.02
"""Share of a step's displacement that the velocities may leave unexplained, as a manoeuvre does."""
UNITS = {
    60.0: "times in minutes",
    3600.0: "times in hours",
    86400.0: "times in days",
    1e3: "velocities in km/s",
    1e-3: "positions in km, or times in ms",
}
"""Displacement over what times and velocities give -> likely cause."""


@final
@dataclass(frozen=True)
class Ephemeris:
    """Orbit from states at given times.

    Positions are interpolated by Hermite's polynomials through the positions and velocities of the
    nearest rows, in GCRS axes; velocities are their derivative.

    Attributes:
        times: Times, s, ascending, (rows,).
        states: Positions and velocities, two rows or more.
        frame: Axes, one of `frames.FRAMES`.
        degree: Degree of the polynomials, odd: twice the number of rows that they meet, less 1.
        where: Place for error messages, such as the name of the file.
        epoch: UTC with a Z, from which the times count; None for the epoch of the run.
    """

    times: Times
    states: States
    frame: str = "GCRS"
    degree: int = DEGREE
    where: str = "ephemeris"
    epoch: str | None = None

    def __post_init__(self):
        """Validate the rows.

        Raises:
            InputError: There are fewer than two rows, the times do not ascend, a value is not
                finite, or the frame or the degree is not among those expected.
        """
        if len(self.times) < 2:
            raise InputError(f"{self.where}: found {len(self.times)} rows, expected two or more")
        rows = np.column_stack([self.times, *self.states])
        if not np.all(np.isfinite(rows)):
            row = int(np.argmin(np.all(np.isfinite(rows), axis=1))) + 1
            raise InputError(f"{self.where}, row {row}: found no finite numbers, expected such")
        steps = np.diff(self.times)
        if not np.all(steps > 0.0):
            row = int(np.argmax(steps <= 0.0)) + 2
            raise InputError(
                f"{self.where}, row {row}: found the time {self.times[row - 1]:g} s after "
                f"{self.times[row - 2]:g} s, expected ascending times"
            )
        if self.frame not in FRAMES:
            raise InputError(
                f"{self.where}: found the frame {self.frame!r}, expected one of {', '.join(FRAMES)}"
            )
        if not 1 <= self.degree <= LARGEST_DEGREE:
            raise InputError(
                f"{self.where}: found the interpolation degree {self.degree}, expected 1 to "
                f"{LARGEST_DEGREE}"
            )

    @property
    def period(self) -> float:
        """Period of the ellipse of the first row, s.

        Raises:
            InputError: The first row is on no ellipse.
        """
        position, velocity = self.states.position[0], self.states.velocity[0]
        if self.frame == "ITRF":
            velocity = velocity + np.cross([0.0, 0.0, EARTH_RATE], position)
        distance, speed = float(np.linalg.norm(position)), float(np.linalg.norm(velocity))
        inverse = 2.0 / distance - speed**2 / EARTH if distance > 0.0 else 0.0
        if not inverse > 0.0:
            raise InputError(
                f"{self.where}: found the speed {speed:.5g} m/s at {distance / 1e3:.5g} km from "
                "the centre of the Earth, expected an elliptic orbit"
            )
        return float(2.0 * np.pi / np.sqrt(EARTH * inverse**3))

    def times_after(self, epoch: Epoch) -> Times:
        """Times of the rows, s after the epoch of a run."""
        if self.epoch is None:
            return self.times
        return self.times + epoch.seconds_to(Epoch.of(self.epoch).utc)

    def trajectory(self, epoch: Epoch, end: float) -> Trajectory:
        """Orbit from the epoch on, GCRS.

        Args:
            epoch: Epoch of the run.
            end: Last time, s.

        Raises:
            InputError: The rows do not cover the run, or times, positions and velocities contradict
                each other.
        """
        times = self.times_after(epoch)
        if times[0] > 0.0 or times[-1] < end:
            raise InputError(
                f"{self.where}: found states from {times[0]:.6g} s to {times[-1]:.6g} s after the "
                f"epoch, expected them from 0 s to {end:.6g} s"
            )
        rows = to_gcrs(self.states, self.frame, epoch, times)
        self._require_consistent(rows)

        def states(instants: Times) -> States:
            return hermite(times, rows, self.degree, instants)

        return Trajectory(states, (self._note(rows),))

    def _require_consistent(self, rows: States) -> None:
        """Compare the displacement of each step with the velocities at its ends.

        r1 - r0 = h (v0 + v1) / 2 - h² (a1 - a0) / 12 plus a remainder of the displacement times
        (n h)⁴ / 720, with the acceleration a of two bodies and the mean motion n (J. Stoer,
        R. Bulirsch, section 3.2). A fifth of (n h)⁴ is allowed, with n of a circular orbit at the
        lower end: a perigee between two rows has a larger n.

        Raises:
            InputError: A displacement is another one, or rows are too far apart to tell.
        """
        position, velocity, step = rows.position, rows.velocity, np.diff(self.times)[:, None]
        distance = np.linalg.norm(position, axis=1, keepdims=True)
        row = int(np.argmin(distance))
        if distance[row] < LOWEST:
            raise InputError(
                f"{self.where}, row {row + 1}: found a position {distance[row, 0] / 1e3:.5g} km "
                "from the centre of the Earth, expected one above the surface; positions are in m "
                "in a CSV file, in km in an OEM file"
            )
        acceleration = -EARTH * position / distance**3
        chord = np.diff(position, axis=0)
        path = step * (velocity[1:] + velocity[:-1]) / 2.0
        off = np.linalg.norm(chord - path + step**2 * np.diff(acceleration, axis=0) / 12.0, axis=1)
        length = np.linalg.norm(chord, axis=1)
        path_length = np.maximum(np.linalg.norm(path, axis=1), 1e-9)
        ratio = float(np.median(length / path_length))
        angle = (step * np.sqrt(EARTH / np.minimum(distance[1:], distance[:-1]) ** 3))[:, 0]
        near = [cause for factor, cause in UNITS.items() if 0.8 < ratio / factor < 1.25]
        remedy = f": {near[0]}?" if near else ""
        row = int(np.argmax(angle))
        if angle[row] > FARTHEST:
            raise InputError(
                f"{self.where}: found rows {row + 1} and {row + 2} {step[row, 0]:g} s apart, "
                f"{angle[row] / (2.0 * np.pi):.2g} of a revolution at this height, expected less "
                f"than a third{remedy}"
            )
        tolerance = (SHARE + angle**4 / 5.0) * np.maximum(path_length, length.min())
        row = int(np.argmax(off / tolerance))
        if off[row] > tolerance[row]:
            raise InputError(
                f"{self.where}: found that the position changes by {length[row] / 1e3:.4g} km from "
                f"row {row + 1} to row {row + 2}, expected {path_length[row] / 1e3:.4g} km by "
                f"times and velocities{remedy or ', which contradict the positions'}"
            )

    def _note(self, rows: States) -> str:
        """Interpolation error as a sentence, from rows that are left out."""
        count = len(self.times)
        if count < 2 * (self.degree + 1):
            return f"interpolated from {count} rows, too few to measure the error"
        coarse = States(rows.position[::2], rows.velocity[::2])
        interpolated = hermite(self.times[::2], coarse, self.degree, self.times[1:-1:2])
        off = np.linalg.norm(interpolated.position - rows.position[1:-1:2], axis=1)
        return (
            f"interpolated by polynomials of degree {self.degree}; from every second row, the "
            f"error is {np.max(off):.2g} m at the rows between"
        )


def hermite(times: Times, states: States, degree: int, wanted: Times) -> States:
    """Interpolate states by Hermite's polynomials of the nearest rows.

    J. Stoer, R. Bulirsch, "Introduction to Numerical Analysis", section 2.1.5.

    Args:
        times: Times of the rows, s, ascending, (rows,).
        states: Positions and velocities of the rows.
        degree: Degree; an even one counts as the next odd one.
        wanted: Times within those of the rows, s.
    """
    count = min(degree // 2 + 1, len(times))
    after = np.searchsorted(times, wanted, side="right")
    first = np.clip(after - (count + 1) // 2, 0, len(times) - count)
    rows = first[:, None] + np.arange(count)
    # over the length of the window, so that products of differences stay near 1
    length = (times[rows[:, -1]] - times[rows[:, 0]])[:, None] if count > 1 else np.ones((1, 1))
    nodes = (times[rows] - times[rows[:, :1]]) / length
    at = (wanted[:, None] - times[rows[:, :1]]) / length
    off_diagonal = ~np.eye(count, dtype=bool)
    between = np.where(off_diagonal, nodes[:, :, None] - nodes[:, None, :], 1.0)
    ratio = np.where(off_diagonal, (at - nodes)[:, None, :], 1.0) / between
    basis = np.prod(ratio, axis=2)
    slope = _slope(ratio, 1.0 / between, off_diagonal)
    node_slope = np.sum(np.where(off_diagonal, 1.0 / between, 0.0), axis=2)
    linear = 1.0 - 2.0 * node_slope * (at - nodes)
    of_position = linear * basis**2
    of_velocity = (at - nodes) * basis**2 * length
    slope_position = 2.0 * basis * (linear * slope - node_slope * basis) / length
    slope_velocity = basis**2 + 2.0 * (at - nodes) * basis * slope

    def total(alpha: np.ndarray, beta: np.ndarray) -> np.ndarray:
        position, velocity = states.position[rows], states.velocity[rows]
        return np.einsum("nk,nkx->nx", alpha, position) + np.einsum("nk,nkx->nx", beta, velocity)

    return States(total(of_position, of_velocity), total(slope_position, slope_velocity))


def _slope(ratio: np.ndarray, inverse: np.ndarray, off_diagonal: np.ndarray) -> np.ndarray:
    """Derivatives of Lagrange's basis polynomials, products of the factors `ratio`."""
    slope = np.zeros(ratio.shape[:2])
    for index in range(ratio.shape[2]):
        factors = np.where(np.arange(ratio.shape[2]) == index, inverse, ratio)
        slope += np.where(off_diagonal[:, index], np.prod(factors, axis=2), 0.0)
    return slope
