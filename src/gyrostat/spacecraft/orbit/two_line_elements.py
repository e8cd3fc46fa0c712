"""Orbit from two-line elements (TLE) by the library sgp4.

D. A. Vallado, P. Crawford, R. Hujsak, T. S. Kelso, "Revisiting Spacetrack Report #3" (AIAA
2006-6753). An orbit from a TLE is good to about 1 km at its epoch and 1 to 3 km a day more.
"""

import re
import warnings
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.elements import Trajectory
from gyrostat.spacecraft.orbit.frames import States, to_gcrs
from gyrostat.spacecraft.orbit.libraries import library
from gyrostat.spacecraft.orbit.time_scales import DAY, Epoch, Julian, Times

MOST_DAYS = 30.0
"""Largest time between the run and the epoch of the elements, days."""
LENGTH = 69
"""Characters of a line."""
_DECIMAL = r" *[+-]?[0-9]*\.?[0-9]+ *"
_EXPONENT = r" *[+-]?\.?[0-9]+[+-][0-9]"
_FIELDS = {
    1: (
        ("epoch", 18, 32, r"[0-9 ][0-9] *[0-9]+\.[0-9]* *"),
        ("first derivative of the mean motion", 33, 43, _DECIMAL),
        ("second derivative of the mean motion", 44, 52, _EXPONENT),
        ("drag term", 53, 61, _EXPONENT),
    ),
    2: (
        ("inclination", 8, 16, _DECIMAL),
        ("right ascension of the node", 17, 25, _DECIMAL),
        ("eccentricity", 26, 33, " *[0-9]+"),
        ("argument of perigee", 34, 42, _DECIMAL),
        ("mean anomaly", 43, 51, _DECIMAL),
        ("mean motion", 52, 63, _DECIMAL),
    ),
}
"""Number of the line -> name, first and last column and pattern of each number that SGP4 uses."""
_INCLINATION = slice(8, 16)
_NUMBERS = ("epochdays", "bstar", "inclo", "nodeo", "ecco", "argpo", "mo", "no_kozai")


@final
@dataclass(frozen=True)
class TwoLineElements:
    """Orbit from two-line elements.

    Attributes:
        line1: First line.
        line2: Second line.
        where: Place for error messages, such as the name of the file.
    """

    line1: str
    line2: str
    where: str = "two-line elements"

    def __post_init__(self):
        """Validate the lines.

        Raises:
            InputError: A line has a wrong length, number or checksum, a field is no number, or the
                lines are those of two objects.
        """
        for number, line in enumerate((self.line1, self.line2), 1):
            if len(line) != LENGTH or not line.startswith(f"{number} "):
                raise InputError(
                    f"{self.where}, line {number}: found {line!r}, expected {LENGTH} characters "
                    f"that begin with {number}"
                )
            _check_fields(f"{self.where}, line {number}", line, _FIELDS[number])
            found, expected = line[-1], str(checksum(line))
            if found != expected:
                raise InputError(
                    f"{self.where}, line {number}: found the checksum {found}, expected {expected}"
                )
        inclination = float(self.line2[_INCLINATION])
        if not 0.0 <= inclination <= 180.0:
            raise InputError(
                f"{self.where}, line 2: found the inclination {inclination:g} deg, expected 0 to "
                "180 deg"
            )
        if self.line1[2:7] != self.line2[2:7]:
            raise InputError(
                f"{self.where}: found the objects {self.line1[2:7]} and {self.line2[2:7]}, "
                "expected two lines of one object"
            )

    @classmethod
    def read(cls, text: str, where: str = "two-line elements") -> "TwoLineElements":
        """Read two lines, or three with a name before them.

        Args:
            text: Lines; blank ones are left out.
            where: Place for error messages, such as the name of the file.

        Raises:
            InputError: The lines are not the elements of one object.
        """
        lines = [line.rstrip() for line in text.splitlines() if line.strip()]
        if len(lines) not in (2, 3):
            raise InputError(
                f"{where}: found {len(lines)} lines, expected two, or three with a name"
            )
        return cls(*lines[-2:], where=where)

    @property
    def period(self) -> float:
        """Period of the mean motion, s."""
        return float(2.0 * np.pi / self._satellite().no_kozai * 60.0)

    @property
    def epoch(self) -> str:
        """Epoch of the elements, UTC."""
        satellite, erfa = self._satellite(), library("erfa")
        with warnings.catch_warnings(action="ignore", category=erfa.ErfaWarning):
            parts = erfa.d2dtf("UTC", 6, satellite.jdsatepoch, satellite.jdsatepochF)
        year, month, day, clock = parts
        return "{:04d}-{:02d}-{:02d}T{:02d}:{:02d}:{:02d}.{:06d}Z".format(
            *map(int, (year, month, day, *clock.tolist()))
        )

    def trajectory(self, epoch: Epoch, end: float) -> Trajectory:
        """Orbit from the epoch on, GCRS.

        Args:
            epoch: Epoch of the run.
            end: Last time, s.

        Raises:
            InputError: A number is unreadable, the run is more than `MOST_DAYS` from the epoch of
                the elements, or SGP4 reports an error.
        """
        satellite = self._satellite()
        age = -epoch.seconds_to(Julian(satellite.jdsatepoch, satellite.jdsatepochF))
        farthest = max(abs(age), abs(age + end)) / DAY
        if not farthest <= MOST_DAYS:
            raise InputError(
                f"{self.where}: found a run up to {farthest:.1f} days from the epoch of the "
                f"elements, expected {MOST_DAYS:g} days or less"
            )

        def states(times: Times) -> States:
            return self._states(satellite, epoch, times, age)

        note = f"the epochs of the run and of the elements are {abs(age) / DAY:.2f} days apart"
        return Trajectory(states, (note,))

    def _satellite(self) -> Any:
        """Elements as the library reads them."""
        try:
            satellite = library("sgp4.api").Satrec.twoline2rv(self.line1, self.line2)
        except (ValueError, IndexError) as error:
            raise InputError(
                f"{self.where}: found {str(error) or 'no numbers'}, expected two-line elements"
            ) from None
        self._check_error(satellite.error, None)
        numbers = [getattr(satellite, name) for name in _NUMBERS]
        sound = np.all(np.isfinite(numbers)) and satellite.no_kozai > 0.0
        if not sound or not 1.0 <= satellite.epochdays < 367.0:
            raise InputError(
                f"{self.where}: found an epoch or an element that is no number, no day or no "
                "motion, expected two-line elements"
            )
        return satellite

    def _states(self, satellite: Any, epoch: Epoch, times: Times, age: float) -> States:
        """States by SGP4 at times, s; the elements are older than the epoch by `age`, s."""
        times = np.asarray(times, dtype=float)
        days = satellite.jdsatepochF + (age + times) / DAY
        codes, position, velocity = satellite.sgp4_array(
            np.full(len(times), satellite.jdsatepoch), days
        )
        if np.any(codes):
            row = int(np.argmax(codes != 0))
            self._check_error(int(codes[row]), float(times[row]))
        if not np.all(np.isfinite(position)):
            raise InputError(f"{self.where}: found no finite position by SGP4, expected an orbit")
        return to_gcrs(States(1e3 * position, 1e3 * velocity), "TEME", epoch, times)

    def _check_error(self, code: int, time: float | None) -> None:
        """Raise the error of an error code of SGP4 other than 0."""
        if code:
            reason = library("sgp4.api").SGP4_ERRORS.get(code, f"error {code}")
            when = "" if time is None else f" at {time:g} s"
            raise InputError(f"{self.where}: found {reason!r}{when} by SGP4, expected an orbit")


def _check_fields(where: str, line: str, fields: Iterable[tuple[str, int, int, str]]) -> None:
    """Validate the characters and the fields of a line.

    Args:
        where: Place for error messages.
        line: Line.
        fields: Name, first and last column from 0, and pattern of each number.

    Raises:
        InputError: A character is not ASCII, or a field is no number, such as one with a blank
            inside.
    """
    non_ascii = [character for character in line if not character.isascii()]
    if non_ascii:
        raise InputError(f"{where}: found {non_ascii[0]!r}, expected ASCII characters")
    for name, start, end, pattern in fields:
        if not re.fullmatch(pattern, line[start:end]):
            raise InputError(
                f"{where}, columns {start + 1} to {end}: found the {name} {line[start:end]!r}, "
                "expected a number without a blank inside"
            )


def checksum(line: str) -> int:
    """Checksum of a line: the sum of its digits, each minus sign as 1, modulo 10."""
    return sum(1 if c == "-" else int(c) for c in line[:-1] if c == "-" or c.isdecimal()) % 10
