"""Recorded current against the planned one: which profile a record contains.

The current of a record is compared with c(t) = k p(t - T): lag T and scale k by cross-correlation,
the unexplained share is 1 - r² with r the normalised correlation. Planned current outside the
record does not count, recorded current outside the profile does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.identification.bench_tests.bench_test import PlannedRecord
from gyrostat.telemetry import Record

MOST_POINTS = 1 << 17
"""Largest number of points at which currents are correlated."""
LEAST_PART = 0.6
"""Smallest part of the mean square of a profile that a record must contain."""
MOST_UNEXPLAINED = 0.15
"""Largest part of the mean square of the current that the profile need not explain: noise, a speed
loop that holds the speed, times that differ by a few samples."""
SCALES = (0.8, 1.25)
"""Scales of a current that is the planned one: a drive sets it with a few per cent."""
TIED = 0.01
"""Relative difference of the explained mean squares of two lags that fit equally well."""
SAME = 1e-6
"""Unexplained share of two profiles that are the same."""


class Match(NamedTuple):
    """Current of a record as a multiple of a shifted profile.

    Attributes:
        lag: Time of the record at which the profile starts, s.
        scale: Recorded over planned current.
        unexplained: Part of the mean square of the current that is not this profile.
        covered: Part of the mean square of the profile inside the record.
    """

    lag: float
    scale: float
    unexplained: float
    covered: float

    @property
    def fits(self) -> bool:
        """Whether the record contains this profile."""
        low, high = SCALES
        return self.alike and low <= self.scale <= high

    @property
    def alike(self) -> bool:
        """Whether the record contains a multiple of this profile."""
        return self.unexplained <= MOST_UNEXPLAINED and self.covered >= LEAST_PART


@dataclass(frozen=True)
class _Profile:
    """Current that is held from sample to sample, zero before the first and after the last."""

    time: Vector
    current: Vector

    def at(self, time: Vector) -> Vector:
        """Current at some times, A; times at a sample up to rounding belong to it."""
        small = 1e-6 * float(self.time[1] - self.time[0])
        index = np.searchsorted(self.time, time + small, side="right") - 1
        current = np.where(index < 0, 0.0, self.current[np.maximum(index, 0)])
        return np.where(time > self.time[-1] + small, 0.0, current)


def match(record: Record, planned: PlannedRecord) -> Match:
    """Find where and how well a record contains a profile.

    Args:
        record: Record with a current that is not zero.
        planned: Profile.
    """
    profile = _Profile(planned.time, planned.current)
    interval = float(planned.time[1] - planned.time[0])
    total = record.time[-1] - record.time[0] + planned.duration
    coarse = max(interval, total / MOST_POINTS)
    measured = _Profile(record.time, record.current)
    c = measured.at(record.time[0] + np.arange(0.0, record.time[-1] - record.time[0], coarse))
    p = profile.at(np.arange(0.0, planned.duration + 0.5 * coarse, coarse))
    size = 1 << int(np.ceil(np.log2(len(c) + len(p))))
    product = np.fft.irfft(np.fft.rfft(c, size) * np.conj(np.fft.rfft(p, size)), size)
    shifts = np.arange(1 - len(p), len(c))
    power = np.concatenate([[0.0], np.cumsum(p**2)])
    inside = power[np.clip(len(c) - shifts, 0, len(p))] - power[np.clip(-shifts, 0, len(p))]
    enough = inside >= min(LEAST_PART * power[-1], float(inside.max()))
    quality = np.where(enough, product[shifts] ** 2 / np.maximum(inside, 1e-12 * power[-1]), 0.0)
    # a periodic profile fits at several lags: that with the most of it inside the record
    most = int(np.argmax(np.where(quality >= (1.0 - TIED) * quality.max(), inside, -1.0)))
    near = slice(max(most - len(p) // 100, 0), most + len(p) // 100 + 1)
    lag = record.time[0] + coarse * float(shifts[near.start + int(np.argmax(quality[near]))])
    # the start of the profile is between two samples
    fine = [_at_lag(record, profile, lag + k * coarse) for k in np.arange(-1.5, 1.6, 0.25)]
    return min(fine, key=lambda each: each.unexplained)


def _at_lag(record: Record, profile: _Profile, lag: float) -> Match:
    """Match at a lag, s."""
    planned = profile.at(record.time - lag)
    square, power = float(record.current @ record.current), float(planned @ planned)
    product = float(record.current @ planned)
    if square == 0.0 or power == 0.0:
        return Match(lag, 0.0, 1.0, 0.0)
    inside = (profile.time >= record.time[0] - lag) & (profile.time <= record.time[-1] - lag)
    every = float(profile.current @ profile.current)
    covered = float(profile.current[inside] @ profile.current[inside]) / every
    return Match(lag, product / power, 1.0 - product**2 / (square * power), covered)


def require_profile(
    record: Record, file: str, test: str, planned: PlannedRecord, others: Sequence[PlannedRecord]
) -> None:
    """Require that a record contains the current that its test asked for.

    Args:
        record: Record.
        file: Name of its file, for the message.
        test: Name of the test.
        planned: Profile of this record.
        others: Profiles of the other records of the plan.

    Raises:
        InputError: It contains another profile, a part of this one, or a multiple of it.
    """
    place = f"{file}: test {test}"
    expected = f"expected that of profiles/{planned.name}.csv"
    if not np.any(record.current):
        raise InputError(f"{place}: found no current, {expected}")
    found = match(record, planned)
    rivals = []
    for other in others:
        apart = match(_as_record(other), planned)
        if found.fits and (apart.unexplained <= SAME or not apart.alike):
            continue
        rival = match(record, other)
        # two profiles that are nearly the same are told apart by half of what they differ
        nearer = found.unexplained - rival.unexplained > 0.5 * apart.unexplained
        if rival.fits and (nearer or not found.fits):
            rivals.append((rival.unexplained, other.name))
    if rivals:
        raise InputError(f"{place}: found the current of {min(rivals)[1]}, {expected}")
    if not found.fits:
        raise InputError(f"{place}: found {_difference(found)}, {expected}")


def _as_record(planned: PlannedRecord) -> Record:
    """Record of a profile that was run exactly."""
    still = np.zeros(len(planned.time))
    return Record(planned.name, planned.time, planned.current, still, still == 0.0)


def _difference(found: Match) -> str:
    """Difference of a current from its profile, in words."""
    if found.covered < LEAST_PART:
        return f"{100.0 * found.covered:.0f} % of the current of the profile (mean square)"
    if found.unexplained > MOST_UNEXPLAINED:
        return (
            f"a current of which {100.0 * found.unexplained:.0f} % (mean square) are not the "
            "profile at any time offset"
        )
    sign = " with the opposite sign" if found.scale < 0.0 else ""
    return f"{abs(found.scale):.3g} times the current of the profile{sign}"
