"""Commanded motion of a flight: nadir pointing and slews, with what the orbit does to the body."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_RADIUS

NADIR_AT_NODE = np.array([0.5, -0.5, -0.5, 0.5])
"""Attitude of the nadir axes at latitude 0: flight direction, minus orbit normal, nadir."""


@dataclass(frozen=True)
class Orbit:
    """Circular orbit of a fleet.

    Attributes:
        name: Name.
        altitude: m.
        inclination: rad, for the direction of the magnetic field.
        eclipse: Share of the orbit in shadow.
        swing: Amplitude of the wheels' temperature, K.
        rods: Whether torque rods unload momentum; thrusters do otherwise.
    """

    name: str
    altitude: float
    inclination: float
    eclipse: float
    swing: float
    rods: bool

    @property
    def rate(self) -> float:
        """Mean motion, rad/s."""
        return float(np.sqrt(EARTH / (EARTH_RADIUS + self.altitude) ** 3))

    def temperature(self, time: Vector) -> Vector:
        """Temperature of the wheels, °C, (N,): eclipses through a first-order lag of 40 min."""
        turns = np.arange(1, 6)
        period = 2.0 * np.pi / self.rate
        lag = 2400.0
        value = np.full(time.shape, 20.0)
        for k in turns:
            # Fourier series of light and shadow, each harmonic through the lag
            height = 2.0 * np.sin(np.pi * k * (1.0 - self.eclipse)) / (np.pi * k)
            phase = 2.0 * np.pi * k / period
            gain = 1.0 / np.hypot(1.0, phase * lag)
            value += (
                2.0 * self.swing * height * gain * np.cos(phase * time - np.arctan(phase * lag))
            )
        return value


LOW = Orbit("500 km", 500e3, np.radians(51.6), 0.36, 6.0, True)
"""Low orbit with eclipses; torque rods unload momentum."""
HIGH = Orbit("36 000 km", 35786e3, 0.0, 0.03, 4.0, False)
"""Geostationary orbit; thrusters unload momentum."""


@dataclass(frozen=True)
class Pointing:
    """Habits of pointing.

    Attributes:
        name: Name.
        slews: Mean number of slews a day; each goes to an attitude off nadir and back.
        angle: Largest slew angle, rad.
        bias_share: Share of the vehicle's bias speed that the null-space loop holds.
    """

    name: str
    slews: float
    angle: float = 0.7
    bias_share: float = 1.0


SLEWS = Pointing("slews", 24.0)
"""A slew off nadir and back each hour."""
QUIET = Pointing("quiet", 0.0)
"""Nadir pointing alone."""
CROSSINGS = Pointing("crossings", 12.0, bias_share=0.15)
"""Slews, and wheels that are held near standstill and cross zero speed."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Commanded motion at N times.

    Attributes:
        to_inertial: Rotation matrix from body to inertial axes, (N, 3, 3).
        quaternion: The same as quaternion, (N, 4).
        rate: Body rate, body axes, (N, 3), rad/s.
        acceleration: Its time derivative, (N, 3), rad/s².
        nadir: Direction of the Earth, body axes, (N, 3).
        field: Direction of the magnetic field, body axes, (N, 3).
        slewing: Whether a slew is under way, (N,).
    """

    to_inertial: NDArray[np.float64]
    quaternion: Matrix
    rate: Matrix
    acceleration: Matrix
    nadir: Matrix
    field: Matrix
    slewing: NDArray[np.bool_]


def schedule(pointing: Pointing, duration: float, day: int, seed: int) -> Matrix:
    """Slews of a day: start (s from midnight), hold (s), angle (rad) and axis, (slews, 6)."""
    random = np.random.default_rng([seed, day, 7])
    count = random.poisson(pointing.slews) if pointing.slews > 0.0 else 0
    if count == 0:
        return np.zeros((0, 6))
    # equal slots, so that two slews never overlap; those that do not fit are left out
    longest = 2.0 * duration + 60.0
    count = min(count, int(86400.0 / (longest + 60.0)))
    slot = 86400.0 / count
    hold = np.minimum(random.exponential(600.0, count), slot - longest) + 30.0
    start = slot * np.arange(count) + random.uniform(0.0, 1.0, count) * (
        slot - 2.0 * duration - hold
    )
    axis = random.standard_normal((count, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    angle = pointing.angle * random.uniform(0.4, 1.0, count)
    return np.column_stack([start, hold, angle, axis])


def _profile(x: Vector, duration: float) -> tuple[Vector, Vector, Vector]:
    """Smooth rest-to-rest motion from 0 to 1: angle, rate and acceleration."""
    s = np.clip(x / duration, 0.0, 1.0)
    turn = 2.0 * np.pi
    return (
        s - np.sin(turn * s) / turn,
        (1.0 - np.cos(turn * s)) / duration,
        turn * np.sin(turn * s) / duration**2,
    )


def motion(orbit: Orbit, pointing: Pointing, duration: float, time: Vector, seed: int) -> Motion:
    """Commanded motion at times.

    Args:
        orbit: Orbit.
        pointing: Habits of pointing.
        duration: Duration of a slew, s.
        time: Times from the start of the flight, within one day, (N,), s.
        seed: Seed of the schedule.
    """
    day = int(time[0] // 86400.0)
    angle, rate, acceleration = (np.zeros(time.shape) for _ in range(3))
    axis = np.tile([1.0, 0.0, 0.0], (time.size, 1))
    slewing = np.zeros(time.shape, bool)
    for start, hold, size, *direction in schedule(pointing, duration, day, seed):
        begin, back = 86400.0 * day + start, 86400.0 * day + start + duration + hold
        there = slice(*np.searchsorted(time, [begin, back + duration]))
        out, home = (_profile(time[there] - at, duration) for at in (begin, back))
        angle[there], rate[there], acceleration[there] = (
            size * (a - b) for a, b in zip(out, home, strict=True)
        )
        axis[there] = direction
        slewing[there] = rate[there] != 0.0
    return _composed(orbit, time, axis, (angle, rate, acceleration), slewing)


def _composed(
    orbit: Orbit,
    time: Vector,
    axis: Matrix,
    turn: tuple[Vector, Vector, Vector],
    slewing: NDArray[np.bool_],
) -> Motion:
    angle, rate, acceleration = turn
    half = 0.5 * angle
    slew = np.column_stack([np.cos(half), axis * np.sin(half)[:, None]])
    latitude = orbit.rate * time
    cosine, sine, zero = np.cos(latitude), np.sin(latitude), np.zeros(time.shape)
    # columns: flight direction, minus the orbit normal, nadir
    nadir_axes = np.stack(
        [
            np.stack([-sine, cosine, zero], axis=1),
            np.broadcast_to([0.0, 0.0, -1.0], (time.size, 3)),
            np.stack([-cosine, -sine, zero], axis=1),
        ],
        axis=2,
    )
    turned = matrix(slew)
    orbital = np.einsum("nji,j->ni", turned, [0.0, -orbit.rate, 0.0])
    tilt = orbit.inclination if orbit.inclination else np.radians(11.0)
    lines = np.stack(
        [cosine * np.sin(tilt), np.full(time.shape, -np.cos(tilt)), 2.0 * sine * np.sin(tilt)], 1
    )
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    spin = axis * rate[:, None]
    orbiting = np.column_stack([np.cos(0.5 * latitude), zero, zero, np.sin(0.5 * latitude)])
    to_nadir = product(orbiting, np.broadcast_to(NADIR_AT_NODE, (time.size, 4)))
    return Motion(
        np.einsum("nij,njk->nik", nadir_axes, turned),
        product(to_nadir, slew),
        spin + orbital,
        axis * acceleration[:, None] - np.asarray(np.cross(spin, orbital), dtype=float),
        turned[:, 2, :],
        np.einsum("nji,nj->ni", turned, lines),
        slewing,
    )


def product(first: Matrix, second: Matrix) -> Matrix:
    """Product of quaternions, scalar first, (N, 4)."""
    a, b, c, d = first.T
    w, x, y, z = second.T
    return np.column_stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )


def matrix(quaternion: Matrix) -> NDArray[np.float64]:
    """Rotation matrices to the outer axes of quaternions, (N, 3, 3)."""
    w, x, y, z = quaternion.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)
