"""Epoch of a run and its time scales: UTC, TAI, TT and UT1.

Times of a run are SI seconds after the epoch, also across a leap second. Leap seconds are those of
the library erfa. UT1 runs at the rate of TAI: UT1 - UTC is given for the epoch, and its drift of
about a millisecond a day is left out.
"""

import datetime
import re
import warnings
from typing import NamedTuple, Self

import numpy as np
from jaxtyping import Float

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.libraries import library

DAY = 86400.0
"""Seconds of a day."""
TT_MINUS_TAI = 32.184
"""TT - TAI, s, by definition."""
LARGEST_UT1_UTC = 0.9
"""Largest UT1 - UTC in size, s: leap seconds keep it within."""
UNIX_EPOCH = 2440587.5
"""Julian day of 1970-01-01."""
FIRST_YEAR = 1972
"""First year of UTC with leap seconds."""

_TIME = re.compile(
    r"(\d{4})-(?:(\d{2})-(\d{2})|(\d{3}))T(\d{2}):(\d{2}):(\d{2}(?:\.\d*)?)", re.ASCII
)

Times = Float[np.ndarray, " rows"]
"""Times of a run, s after its epoch."""


class Julian(NamedTuple):
    """Julian day in two parts, whose sum is the day, so that no digits are lost.

    Attributes:
        day: First part, days.
        fraction: Second part, days; one number or (rows,).
    """

    day: float
    fraction: float | Times


def read_utc(text: str, where: str) -> Julian:
    """Julian day, UTC, of a time such as 2026-11-22T10:00:00 or 2026-326T10:00:00.

    Args:
        text: Date, as month and day or as day of the year, and time, without a time zone.
        where: Place for the error message.

    Raises:
        InputError: The text is no such time, or leap seconds are not known for it.
    """
    erfa = library("erfa")
    expected = "a time UTC such as 2026-11-22T10:00:00"
    match = _TIME.fullmatch(text)
    if match is None:
        raise InputError(f"{where}: found {text!r}, expected {expected}")
    year, month, day, day_of_year, hour, minute, second = match.groups()
    if int(year) < FIRST_YEAR:
        raise InputError(f"{where}: found {text!r}, expected the year {FIRST_YEAR} or later")
    if day_of_year is None:
        date = int(year), int(month), int(day)
    else:
        start = datetime.date(int(year), 1, 1).toordinal()
        ordinal_date = datetime.date.fromordinal(start + int(day_of_year) - 1)
        if ordinal_date.year != int(year):
            raise InputError(f"{where}: found {text!r}, expected {expected}")
        date = ordinal_date.year, ordinal_date.month, ordinal_date.day
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", erfa.ErfaWarning)
            return Julian(*erfa.dtf2d("UTC", *date, int(hour), int(minute), float(second)))
    except (erfa.ErfaWarning, erfa.ErfaError) as error:
        if "dubious year" in str(error):
            expected = "a year for which the leap seconds are known (a later pyerfa knows more)"
        raise InputError(f"{where}: found {text!r}, expected {expected}") from None


class Epoch(NamedTuple):
    """Time 0 of a run.

    Attributes:
        utc: Julian day, UTC.
        tai: Julian day, TAI.
        ut1: Julian day, UT1.
    """

    utc: Julian
    tai: Julian
    ut1: Julian

    @classmethod
    def of(cls, text: str, ut1_utc: float = 0.0) -> Self:
        """Read an epoch.

        Args:
            text: UTC with a Z, such as "2026-11-22T10:00:00Z".
            ut1_utc: UT1 - UTC at the epoch, s, as published by the IERS; 0 turns the Earth wrongly
                by up to 0.9 s, 14 arcseconds a second.

        Raises:
            InputError: The text is no time in UTC from `FIRST_YEAR` on for which leap seconds are
                known, or UT1 - UTC is larger than `LARGEST_UT1_UTC`.
        """
        if not text.endswith("Z"):
            raise InputError(
                f"epoch: found {text!r}, expected a time UTC with a Z, such as 2026-11-22T10:00:00Z"
            )
        utc = read_utc(text[:-1], "epoch")
        if not abs(ut1_utc) <= LARGEST_UT1_UTC:
            raise InputError(
                f"UT1 - UTC: found {ut1_utc:g} s, expected {LARGEST_UT1_UTC:g} s or less in size"
            )
        erfa = library("erfa")
        return cls(utc, Julian(*erfa.utctai(*utc)), Julian(*erfa.utcut1(*utc, ut1_utc)))

    def tt(self, times: Times) -> Julian:
        """Julian days, TT, at times, s."""
        return Julian(self.tai.day, self.tai.fraction + (times + TT_MINUS_TAI) / DAY)

    def ut1_at(self, times: Times) -> Julian:
        """Julian days, UT1, at times, s."""
        return Julian(self.ut1.day, self.ut1.fraction + times / DAY)

    def calendar(self, times: Times) -> np.ndarray:
        """UTC at times, s, as `datetime64` to the microsecond, without a leap second in the run.

        Returns:
            (rows,).
        """
        days = np.floor(self.utc.day - UNIX_EPOCH)
        seconds = (self.utc.day - UNIX_EPOCH - days + self.utc.fraction) * DAY + times
        start = np.datetime64(0, "us") + np.timedelta64(int(days), "D")
        return start + np.round(seconds * 1e6).astype("timedelta64[us]")

    def seconds_to(self, utc: Julian) -> float:
        """Time from the epoch to a time UTC, s, to the nanosecond."""
        erfa = library("erfa")
        # elements may be from years before leap seconds; they are refused as too far from the run
        with warnings.catch_warnings(action="ignore", category=erfa.ErfaWarning):
            tai = Julian(*erfa.utctai(*utc))
        days = tai.day - self.tai.day + (tai.fraction - self.tai.fraction)
        return round(float(days * DAY), 9)
