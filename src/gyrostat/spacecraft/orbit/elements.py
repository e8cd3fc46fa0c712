"""Orbits from elements, with the oblateness of the Earth (J2).

The motion is integrated with the acceleration by J2 about the axis of rotation at the epoch (the
celestial intermediate pole of the IAU 2006/2000A models, 0.15 degrees from the GCRS z axis in
2026). No other force acts: neither drag nor Sun nor Moon.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, final

import numpy as np
from jaxtyping import Float

from gyrostat.core.errors import InputError
from gyrostat.core.validation import magnitude, require
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_J2, EARTH_RADIUS
from gyrostat.spacecraft.orbit.frames import States
from gyrostat.spacecraft.orbit.libraries import library
from gyrostat.spacecraft.orbit.time_scales import Epoch, Times

TOLERANCE = 1e-12
"""Relative tolerance of the integration."""
STEPS_PER_TURN = 50
"""Least number of integration steps in a revolution: between steps, the method interpolates."""


class Trajectory(NamedTuple):
    """Orbit over the time of a run.

    Attributes:
        states: Times, s after the epoch, -> positions and velocities, GCRS.
        notes: What a user should know of its accuracy, one line each.
    """

    states: Callable[[Times], States]
    notes: tuple[str, ...] = ()


def check_inclination(inclination: float) -> None:
    """Validate the inclination of an orbit, rad.

    Raises:
        InputError: It is not finite, or outside 0 to pi.
    """
    magnitude("orbit: inclination", inclination, "rad")
    if not 0.0 <= inclination <= np.pi:
        raise InputError(
            f"orbit: found the inclination {inclination:g} rad, {np.degrees(inclination):g} deg, "
            "expected 0 to 180 deg"
        )


@final
@dataclass(frozen=True)
class KeplerElements:
    """Osculating Keplerian elements at the epoch of the run, in axes of the GCRS.

    Attributes:
        semi_major_axis: Semi-major axis, m.
        eccentricity: Eccentricity, below 1.
        inclination: Inclination, rad.
        ascending_node: Right ascension of the ascending node, rad.
        perigee: Argument of perigee, rad.
        true_anomaly: True anomaly at the epoch, rad.
        epoch: None, because the elements hold at the epoch of the run.
    """

    epoch: ClassVar[None] = None
    semi_major_axis: float
    eccentricity: float = 0.0
    inclination: float = 0.0
    ascending_node: float = 0.0
    perigee: float = 0.0
    true_anomaly: float = 0.0

    def __post_init__(self):
        """Validate the elements.

        Raises:
            InputError: An element is not finite, the orbit is no ellipse or meets the Earth, or the
                inclination is outside 0 to pi.
        """
        require("orbit: semi_major_axis", self.semi_major_axis, "m", positive=True)
        if not 0.0 <= self.eccentricity < 1.0:
            raise InputError(
                f"orbit: found the eccentricity {self.eccentricity:g}, expected 0 to below 1"
            )
        check_inclination(self.inclination)
        for name in ("ascending_node", "perigee", "true_anomaly"):
            magnitude(f"orbit: {name}", getattr(self, name), "rad")
        lowest = self.semi_major_axis * (1.0 - self.eccentricity) - EARTH_RADIUS
        if lowest <= 0.0:
            raise InputError(
                f"orbit: found a perigee at an altitude of {lowest / 1e3:.4g} km, expected one "
                "above the surface"
            )

    @property
    def period(self) -> float:
        """Period of the motion of two bodies, s."""
        return float(2.0 * np.pi * np.sqrt(self.semi_major_axis**3 / EARTH))

    def trajectory(self, epoch: Epoch, end: float) -> Trajectory:
        """Orbit from the epoch on.

        Args:
            epoch: Epoch of the run.
            end: Last time, s.

        Raises:
            InputError: The motion cannot be integrated.
        """
        axis = library("erfa").c2i06a(*epoch.tt(np.zeros(1)))[0, 2]
        longest = self.period / STEPS_PER_TURN
        return Trajectory(propagated(self.two_bodies(np.zeros(1)), axis, end, longest))

    def two_bodies(self, times: Times) -> States:
        """Positions and velocities without oblateness at times, s.

        Kepler's equation by Newton's method. R. H. Battin, "An Introduction to the Mathematics and
        Methods of Astrodynamics", sections 4.3 and 5.1.
        """
        e = self.eccentricity
        ratio = np.sqrt((1.0 - e) / (1.0 + e))
        start = 2.0 * np.arctan2(
            ratio * np.sin(0.5 * self.true_anomaly), np.cos(0.5 * self.true_anomaly)
        )
        rate = 2.0 * np.pi / self.period
        mean = start - e * np.sin(start) + rate * np.asarray(times)
        turns = 2.0 * np.pi * np.round(mean / (2.0 * np.pi))
        mean = mean - turns
        # from pi, with the sign of the mean anomaly, the iteration converges for every ellipse
        eccentric = mean if e < 0.8 else np.copysign(np.pi, mean)
        for _ in range(50):
            change = (eccentric - e * np.sin(eccentric) - mean) / (1.0 - e * np.cos(eccentric))
            eccentric = eccentric - change
            if np.max(np.abs(change)) < 1e-15:
                break
        cosine, sine, across = np.cos(eccentric), np.sin(eccentric), np.sqrt(1.0 - e * e)
        a = self.semi_major_axis
        speed = a * rate / (1.0 - e * cosine)
        plane = self._plane()
        position = np.stack([a * (cosine - e), a * across * sine], axis=1) @ plane
        velocity = np.stack([-speed * sine, speed * across * cosine], axis=1) @ plane
        return States(position, velocity)

    def _plane(self) -> Float[np.ndarray, "2 3"]:
        """Unit vectors to the perigee and 90 degrees ahead of it."""
        from scipy.spatial.transform import Rotation  # slow to import

        angles = [self.ascending_node, self.inclination, self.perigee]
        return Rotation.from_euler("ZXZ", angles).as_matrix()[:, :2].T


@final
@dataclass(frozen=True)
class CircularElements:
    """Circular orbit; with J2, an orbit that is circular at the epoch of the run.

    Attributes:
        altitude: Altitude above the equatorial radius, m.
        inclination: Inclination, rad.
        ascending_node: Right ascension of the ascending node, rad.
        latitude: Argument of latitude at the epoch, from the ascending node, rad.
        epoch: None, because the elements hold at the epoch of the run.
    """

    epoch: ClassVar[None] = None
    altitude: float
    inclination: float = 0.0
    ascending_node: float = 0.0
    latitude: float = 0.0

    def __post_init__(self):
        """Validate the elements.

        Raises:
            InputError: The altitude is not above 0, an angle is not finite, or the inclination is
                outside 0 to pi.
        """
        require("orbit: altitude", self.altitude, "m", positive=True)
        check_inclination(self.inclination)
        for name in ("ascending_node", "latitude"):
            magnitude(f"orbit: {name}", getattr(self, name), "rad")

    @property
    def elements(self) -> KeplerElements:
        """The same as Keplerian elements."""
        return KeplerElements(
            EARTH_RADIUS + self.altitude,
            inclination=self.inclination,
            ascending_node=self.ascending_node,
            true_anomaly=self.latitude,
        )

    @property
    def period(self) -> float:
        """Period of the motion of two bodies, s."""
        return self.elements.period

    def trajectory(self, epoch: Epoch, end: float) -> Trajectory:
        """Orbit from the epoch on until a time `end`, s; see `KeplerElements.trajectory`."""
        return self.elements.trajectory(epoch, end)


def propagated(
    start: States, axis: Float[np.ndarray, "3"], end: float, longest: float, j2: float = EARTH_J2
) -> Callable[[Times], States]:
    """Integrate the motion around the oblate Earth (Dormand and Prince, order 8).

    Args:
        start: State at time 0, one row, GCRS.
        axis: Unit vector of the Earth's axis, (3,), GCRS.
        end: Last time, s.
        longest: Longest step, s.
        j2: Second zonal harmonic.

    Returns:
        Function: times from 0 to `end`, s -> positions and velocities.

    Raises:
        InputError: The motion cannot be integrated.
    """
    from scipy.integrate import solve_ivp  # slow to import

    def derivative(time: float, state: np.ndarray) -> np.ndarray:
        del time
        return np.concatenate([state[3:], gravity(state[:3], axis, j2)])

    initial = np.concatenate([start.position[0], start.velocity[0]])
    scale = np.repeat([np.linalg.norm(initial[:3]), np.linalg.norm(initial[3:])], 3)
    solution = solve_ivp(
        derivative,
        (0.0, end),
        initial,
        method="DOP853",
        dense_output=True,
        rtol=TOLERANCE,
        atol=TOLERANCE * scale,
        max_step=longest,
    )
    if not solution.success:
        raise InputError(f"orbit: found no motion ({solution.message}), expected an orbit")

    def states(times: Times) -> States:
        rows = solution.sol(times).T
        return States(rows[:, :3], rows[:, 3:])

    return states


def gravity(
    position: Float[np.ndarray, "3"], axis: Float[np.ndarray, "3"], j2: float = EARTH_J2
) -> Float[np.ndarray, "3"]:
    """Acceleration by the oblate Earth.

    O. Montenbruck, E. Gill, "Satellite Orbits", section 3.2.

    Args:
        position: Position from the centre of the Earth, (3,), m.
        axis: Unit vector of the Earth's axis, (3,).
        j2: Second zonal harmonic.

    Returns:
        Acceleration, (3,), m/s².
    """
    squared = position @ position
    height = position @ axis
    factor = 1.5 * j2 * EARTH_RADIUS**2 / squared
    radial = 1.0 + factor * (1.0 - 5.0 * height**2 / squared)
    pull = EARTH / (squared * np.sqrt(squared))
    return -pull * (radial * position + 2.0 * factor * height * axis)
