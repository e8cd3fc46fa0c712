"""Motion of the line of sight over wheel speed, and the speeds to avoid.

The phases of harmonics, of the kinds of load and of wheels are not known: their mean squares add.
Within one kind of load, the two loads across the axis are 90° apart, as a whirl has them.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat.core.directions import across
from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration import exposure as windows
from gyrostat.microvibration.model import KINDS, LOADS, TWO_PI, WheelDisturbance
from gyrostat.microvibration.transfer_file import Transfer
from gyrostat.telemetry.signals import runs

NOISE_SPEEDS = 40
"""Speeds at which the motion by noise is integrated; it is smooth between them."""
WEIGHTS = {
    "shift": windows.shift_weight,
    "smear": windows.smear_weight,
    "jitter": windows.jitter_weight,
}


@dataclass(frozen=True, eq=False)
class MountedWheel:
    """Wheel on a structure.

    Attributes:
        name: Name.
        disturbance: Its loads.
        axis: Spin axis in body axes, a unit vector, (3,).
        position: Position from the point of the transfer's loads, body axes, (3,), m.
    """

    name: str
    disturbance: WheelDisturbance
    axis: Vector
    position: Vector

    def to_body(self) -> Matrix:
        """Loads at the point of the transfer over loads in the axes of the wheel, (6, 6)."""
        first = across(self.axis)
        turn = np.array([first, np.cross(self.axis, first), self.axis]).T
        x, y, z = self.position
        arm = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        return np.block([[turn, np.zeros((3, 3))], [arm @ turn, turn]])


@dataclass(frozen=True, eq=False)
class WheelMotion(Described):
    """Motion of the line of sight by one wheel.

    Attributes:
        name: Name of the wheel.
        frequency: Frequencies of the tones, (tones, S), rad/s.
        amplitude: Amplitudes of the tones about x and y, (tones, 2, S), rad.
        noise: Measure -> mean square of the motion by noise, (2, S), rad².
        outside: Whether a tone lies outside the frequencies of the transfer, (tones, S).
    """

    name: str
    frequency: Matrix
    amplitude: Any
    noise: dict[str, Matrix]
    outside: Any

    def mean_square(self, measure: str, exposure: float) -> Matrix:
        """Mean square of shift, smear or jitter about x and y, (2, S), rad²."""
        weight = WEIGHTS[measure](self.frequency, exposure)
        tones = 0.5 * np.sum(self.amplitude**2 * weight[:, None], axis=0)
        return tones + self.noise[measure]


@dataclass(frozen=True, eq=False)
class LineOfSight(Pictured):
    """Motion of the line of sight over the speed of each wheel.

    Attributes:
        speed: Wheel speeds, (S,), rad/s.
        exposure: Duration of an exposure, s.
        limit: Largest rms of smear and jitter of all wheels together, both axes, rad; or None.
        wheels: Motion by each wheel.
        reverse: Motion by each wheel when it turns the other way, which a structure may answer
            otherwise; empty: not computed.
        most: Greatest speed that a wheel can have, rad/s; None: not known.
    """

    speed: Vector
    exposure: float
    limit: float | None
    wheels: tuple[WheelMotion, ...]
    reverse: tuple[WheelMotion, ...] = ()
    most: float | None = None

    def mean_squares(self, *measures: str) -> Any:
        """Mean square about both axes of measures together, by sense, (senses, wheels, S), rad².

        Args:
            measures: Some of shift, smear and jitter; smear and jitter by default.
        """
        names = measures or ("smear", "jitter")
        return np.array(
            [
                [
                    np.sum([wheel.mean_square(name, self.exposure) for name in names], axis=(0, 1))
                    for wheel in wheels
                ]
                for wheels in (self.wheels, self.reverse)
                if wheels
            ]
        )

    def rms(self, *measures: str) -> Matrix:
        """Root mean square about both axes of measures together, (wheels, S), rad.

        It is that of the sense of rotation in which it is larger; see `mean_squares`.
        """
        return np.sqrt(np.max(self.mean_squares(*measures), axis=0))

    def worst(self) -> Vector:
        """Speed of each wheel with the largest smear and jitter, (wheels,), rad/s.

        It is negative where the larger one belongs to the other sense of rotation.
        """
        squares = self.mean_squares()
        columns = np.argmax(np.max(squares, axis=0), axis=1)
        senses = [np.argmax(squares[:, wheel, k]) for wheel, k in enumerate(columns)]
        return self.speed[columns] * np.where(np.array(senses) == 0, 1.0, -1.0)

    def in_run(self, speed: Matrix) -> Vector:
        """Mean square of smear and jitter about both axes, of all wheels together, (N,), rad².

        Below the speeds computed it is that of the lowest one; above them it is NaN.

        Args:
            speed: Speeds of the wheels at each time, of either sign, (N, wheels), rad/s.
        """
        squares = self.mean_squares()
        total = np.zeros(len(speed))
        for k, each in enumerate(np.asarray(speed).T):
            for rows, sense in ((squares[0], each >= 0.0), (squares[-1], each < 0.0)):
                part = np.interp(np.abs(each), self.speed, rows[k], right=np.nan)
                total = total + np.where(sense, part, 0.0)
        return total

    def bands(self) -> list[tuple[float, float]]:
        """Ranges of speeds at which a wheel may exceed its share of the limit, rad/s.

        The share of one of n wheels is the limit over √n: the limit holds while no wheel is in a
        band. A band ends at the next speed outside it. Below the speeds computed, the motion counts
        as that of the lowest one, so that a band there begins at 0. Above them it is not known:
        speeds up to `most` are in a band, and none is if `most` is None.
        """
        if self.limit is None:
            return []
        above = np.any(self.rms() > self.limit / np.sqrt(len(self.wheels)), axis=0)
        ranges: list[tuple[float, float]] = []
        for start, end in runs(above):
            low = 0.0 if start == 0 else float(self.speed[start - 1])
            high = float(self.speed[min(end, len(self.speed) - 1)])
            if ranges and low <= ranges[-1][1]:
                low = ranges.pop()[0]
            ranges.append((low, high))
        last = float(self.speed[-1])
        if self.most is not None and self.most > last:
            low = ranges.pop()[0] if ranges and ranges[-1][1] == last else last
            ranges.append((low, self.most))
        return ranges

    def mtf(self, detail: Vector, speeds: Vector, axis: int) -> Vector:
        """MTF of all wheels at one speed each, (details,).

        Args:
            detail: Spatial frequencies, (details,), cycles/rad.
            speeds: Speed of each wheel, its size within the speeds computed, (wheels,), rad/s;
                negative for the other sense of rotation.
            axis: Axis about which the line of sight turns: 0 or 1.
        """
        frequency, amplitude, square = [], [], 0.0
        pairs = zip(self.wheels, self.reverse or self.wheels, strict=True)
        for (wheel, reverse), speed in zip(pairs, speeds, strict=True):
            k = int(np.argmin(np.abs(self.speed - abs(speed))))
            wheel = reverse if speed < 0.0 else wheel
            frequency.append(wheel.frequency[:, k])
            amplitude.append(wheel.amplitude[:, axis, k])
            square += float(wheel.noise["smear"][axis, k] + wheel.noise["jitter"][axis, k])
        tones = np.concatenate(frequency), np.concatenate(amplitude)
        return windows.mtf(detail, *tones, float(np.sqrt(square)), self.exposure)


def line_of_sight(
    wheels: list[MountedWheel],
    transfer: Transfer,
    speed: Vector,
    exposure: float,
    limit: float | None = None,
) -> LineOfSight:
    """Compute the motion of the line of sight over wheel speed.

    Args:
        wheels: Wheels; their number is that of the transfer, or any if it has loads at one point.
        transfer: Transfer to the line of sight.
        speed: Wheel speeds, increasing, (S,), rad/s.
        exposure: Duration of an exposure, s.
        limit: See `LineOfSight`.
    """
    forward, reverse = [], []
    for k, wheel in enumerate(wheels):
        index = min(k, transfer.wheels - 1)
        frequency = _frequencies(wheel, speed)
        response = transfer.at(frequency.ravel() / TWO_PI, index).reshape(*frequency.shape, 2, 6)
        for motions, sense in ((forward, 1.0), (reverse, -1.0)):
            turned = replace(wheel, axis=sense * wheel.axis)
            noise = _noise(turned, transfer, index, speed, exposure)
            motions.append(_motion(turned, transfer, speed, response, noise))
    return LineOfSight(speed, exposure, limit, tuple(forward), tuple(reverse))


def _frequencies(wheel: MountedWheel, speed: Vector) -> Matrix:
    """Frequencies of the tones of a wheel, (tones, S), rad/s."""
    numbers = np.array([each.number for each in wheel.disturbance.harmonics])
    return numbers[:, None] * speed


def _motion(
    wheel: MountedWheel, transfer: Transfer, speed: Vector, response: Any, noise: dict[str, Matrix]
) -> WheelMotion:
    """Motion of the line of sight by one wheel; `response` is that to its tones, in body axes."""
    frequency = _frequencies(wheel, speed)
    response = response @ wheel.to_body()
    square = np.zeros((*frequency.shape, 2))
    for kind in KINDS:
        for sense in (1, -1):
            angle = _whirl(response, kind, sense)
            tone = wheel.disturbance.tone(kind, speed, sense)
            square += np.abs(tone[..., None] * angle) ** 2
    low, high = transfer.limits
    outside = (frequency < TWO_PI * low) | (frequency > TWO_PI * high)
    amplitude = np.moveaxis(np.sqrt(square), -1, 1)
    return WheelMotion(wheel.name, frequency, amplitude, noise, outside)


def _whirl(response: Any, kind: str, sense: int) -> Any:
    """Angles over a load of 1 that turns in one sense, of the last two axes (2, 6) -> (2,)."""
    first, *second = (LOADS.index(load) for load in KINDS[kind])
    if not second:
        return response[..., first] if sense > 0 else 0.0 * response[..., first]
    return response[..., first] - sense * 1j * response[..., second[0]]


def _noise(
    wheel: MountedWheel, transfer: Transfer, index: int, speed: Vector, exposure: float
) -> dict[str, Matrix]:
    """Mean squares of the motion by broadband noise, each (2, S), rad²."""
    few = np.linspace(speed[0], speed[-1], min(NOISE_SPEEDS, len(speed)))
    grid = transfer.grid()
    # a rigid body drifts without bound at low frequencies, as a shift and not within an exposure
    grid = grid[grid >= 0.02 / exposure]
    result = {name: np.zeros((2, len(few))) for name in WEIGHTS}
    disturbance = wheel.disturbance
    if len(grid) > 1 and disturbance.noise:
        w = TWO_PI * grid
        response = transfer.at(grid, index) @ wheel.to_body()
        weights = {name: weight(w, exposure) for name, weight in WEIGHTS.items()}
        for kind, noise in disturbance.noise.items():
            for sense in (1, -1):
                angle = np.abs(_whirl(response, kind, sense)) ** 2
                mode = disturbance.modes.get(kind)
                ones = np.ones((len(few), len(w)))
                gain = ones if mode is None else mode.power_gain(sense * w, few[:, None] * ones)
                share = 0.5 if len(KINDS[kind]) == 2 else 1.0
                density = share * noise.at(few)[:, None] * gain
                for name, weight in weights.items():
                    each = density[:, None] * angle.T * weight
                    result[name] += np.trapezoid(each, grid, axis=2).T
    return {
        name: np.array([np.interp(speed, few, row) for row in values])
        for name, values in result.items()
    }
