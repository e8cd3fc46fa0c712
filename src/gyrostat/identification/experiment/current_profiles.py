"""Families of current profiles that a test bench can run, each with four numbers.

Every profile repeats one period with alternating sign. Its numbers are coordinates from 0 to 1, so
that one search serves all families.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.validation import require

COORDINATES = 4
FEWEST_SAMPLES = 20
"""Smallest number of samples in one period."""
MOST_PERIODS = 30
"""Largest number of periods in a record."""


@dataclass(frozen=True)
class Limits(Described):
    """Limits of driver, wheel and record.

    Attributes:
        duration: Length of the record, s.
        rate: Samples per second, Hz.
        current: Largest current, A.
        slew: Largest rate of change of the current, A/s; infinite without a limit.
        speed: Largest speed of the wheel, rad/s; infinite without a limit.
        initial_speed: Speed at the start, rad/s.
    """

    duration: float
    rate: float
    current: float
    slew: float = np.inf
    speed: float = np.inf
    initial_speed: float = 0.0

    def __post_init__(self) -> None:
        """Validate the limits; raises `InputError`."""
        for name in ("duration", "rate", "current"):
            require(name, getattr(self, name), positive=True)
        for name, value in (("slew", self.slew), ("max speed", self.speed)):
            if not value > 0.0:
                raise InputError(f"{name}: found {value:g}, expected more than 0")
        if not abs(self.initial_speed) <= self.speed:
            raise InputError(
                f"initial speed: found {self.initial_speed:g} rad/s, expected at most the largest "
                f"speed of {self.speed:g}"
            )
        if self.duration * self.rate < FEWEST_SAMPLES:
            raise InputError(
                f"duration: found {self.duration * self.rate:.3g} samples, expected at least "
                f"{FEWEST_SAMPLES}"
            )

    def time(self) -> Vector:
        """Sample times, (N,), s, from zero to the duration."""
        return np.arange(int(np.floor(self.duration * self.rate * (1.0 + 1e-12))) + 1) / self.rate

    def apply(self, current: Matrix, interval: float) -> Matrix:
        """Limit currents, (..., N), A, in size and rate of change; the first starts from zero.

        Args:
            current: Wanted currents, A.
            interval: Sample interval, s.
        """
        profile = np.clip(current, -self.current, self.current)
        if np.isinf(self.slew):
            return profile
        before, step = np.zeros(profile.shape[:-1]), self.slew * interval
        for k in range(profile.shape[-1]):
            profile[..., k] = before = np.clip(profile[..., k], before - step, before + step)
        return profile


@dataclass(frozen=True)
class Shape:
    """Member of a family.

    Attributes:
        family: Key of `FAMILIES`.
        coordinates: Numbers from 0 to 1, (4,); the first one gives the period.
    """

    family: str
    coordinates: Vector

    def numbers(self, limits: Limits, breakaway: float) -> dict[str, float]:
        """Name -> number of this profile: period in s, currents in A, fractions.

        Args:
            limits: Limits of the record.
            breakaway: Current at which the estimated wheel breaks away, A.
        """
        shortest = max(limits.duration / MOST_PERIODS, FEWEST_SAMPLES / limits.rate)
        ratio = min(shortest / limits.duration, 1.0)
        period = limits.duration * ratio ** float(self.coordinates[0])
        family_numbers = FAMILIES[self.family][0]
        return {"period": period, **family_numbers(self.coordinates[1:], limits, breakaway)}

    def current(self, time: Vector, limits: Limits, breakaway: float) -> Vector:
        """Current before the limits are applied, (N,), A.

        Args:
            time: Sample times, (N,), s, from zero.
            limits: Limits of the record.
            breakaway: Current at which the estimated wheel breaks away, A.
        """
        numbers = self.numbers(limits, breakaway)
        period = numbers.pop("period")
        count = np.floor(time / period + 1e-9)
        return FAMILIES[self.family][1](time / period - count, (-1.0) ** count, **numbers)


Numbers = Callable[[Vector, Limits, float], dict[str, float]]
Period = Callable[..., Vector]


def _amplitude(coordinate: float, limits: Limits, breakaway: float) -> float:
    """Amplitude between half the breakaway current and the limit, on a logarithmic scale, A."""
    least = min(0.5 * breakaway, limits.current)
    return least * (limits.current / least) ** float(coordinate)


def _ramp_numbers(u: Vector, limits: Limits, breakaway: float) -> dict[str, float]:
    first = breakaway * (0.6 + 0.5 * float(u[0]))
    last = first + breakaway * 0.02 * 50.0 ** float(u[1])
    most = limits.current
    return {"first": min(first, most), "last": min(last, most), "rest": 0.3 * float(u[2])}


def _ramp(phase: Vector, sign: Vector, first: float, last: float, rest: float) -> Vector:
    """Rest at zero current, then a ramp through the breakaway current."""
    rise = (phase - rest) / (1.0 - rest)
    return sign * np.where(rise < 0.0, 0.0, first + (last - first) * rise)


def _step_numbers(u: Vector, limits: Limits, breakaway: float) -> dict[str, float]:
    first = _amplitude(u[0], limits, breakaway)
    return {"first": first, "second": first * float(u[1]), "share": 0.1 + 0.9 * float(u[2])}


def _step(phase: Vector, sign: Vector, first: float, second: float, share: float) -> Vector:
    """Two constant currents in turn; the second may be zero."""
    return sign * np.where(phase < share, first, second)


def _sine_numbers(u: Vector, limits: Limits, breakaway: float) -> dict[str, float]:
    amplitude = _amplitude(u[0], limits, breakaway)
    return {"amplitude": amplitude, "offset": amplitude * (float(u[1]) - 0.5), "start": float(u[2])}


def _sine(phase: Vector, sign: Vector, amplitude: float, offset: float, start: float) -> Vector:
    """Whole sine with an offset that changes sign with each period."""
    return amplitude * np.sin(2.0 * np.pi * (phase + start)) + sign * offset


def _reversal_numbers(u: Vector, limits: Limits, breakaway: float) -> dict[str, float]:
    amplitude = _amplitude(u[0], limits, breakaway)
    return {"first": amplitude, "second": amplitude * float(u[1]), "share": float(u[2])}


def _reversal(phase: Vector, sign: Vector, first: float, second: float, share: float) -> Vector:
    """Linear change from one current to the opposite sense, which is then held."""
    rise = np.minimum(phase / max(share, 1e-9), 1.0)
    return sign * (first - (first + second) * rise)


FAMILIES: dict[str, tuple[Numbers, Period]] = {
    "ramps": (_ramp_numbers, _ramp),
    "steps": (_step_numbers, _step),
    "sines": (_sine_numbers, _sine),
    "reversals": (_reversal_numbers, _reversal),
}
"""Name of a family -> numbers of a member, and its current over the phase of a period (0 to 1)."""
