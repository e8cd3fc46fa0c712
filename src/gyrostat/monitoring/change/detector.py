"""Detector of one wheel: windows in, alarm and class of the change out; it can be stored."""

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.core.validation import require
from gyrostat.monitoring.change.channels import CHANNELS, Observation, Reference, observation
from gyrostat.monitoring.change.evidence import (
    KINDS,
    NAMES,
    SIGNATURES,
    Changed,
    Evidence,
    changed,
    evidence,
)
from gyrostat.monitoring.change.levels import Levels, LevelSettings

YEAR = 365.25
EXCESS = 4.0
"""Mean run length over the threshold, at least, on simulated white windows: 73 +- 10 windows at 20
and 950 +- 120 at 100 (60 and 70 wheels)."""
SURE = 0.9
"""Probability that the classes of an answer have together."""
MOST = 3
"""Largest number of classes of an answer."""
_STORED = (
    "mean",
    "covariance",
    "scatter",
    "weight",
    "response",
    "information",
    "score",
    "began",
)


@dataclass(frozen=True, eq=False)
class AlarmSettings(Described):
    """Settings of alarm and classes.

    Attributes:
        false_alarms: Highest expected number of false alarms per wheel-year.
        rates: Faults per wheel-year for each class of `NAMES`, an assumption.
        window: Duration of a window, days.
    """

    false_alarms: float = 0.32
    rates: Mapping[str, float] = field(
        default_factory=lambda: {kind.name: kind.rate for kind in KINDS}
    )
    window: float = 1.0

    @property
    def threshold(self) -> float:
        """Log of the Shiryaev-Roberts statistic at which the alarm is raised.

        Without a change, the statistic less the number of windows is a martingale, so that the
        mean time to a false alarm is at least the threshold (M. Pollak, "Average run lengths of an
        optimal method of detecting a change in distribution", Annals of Statistics 15, 1987). With
        changes of unknown class, size and course it is `EXCESS` times as long or longer.
        """
        return float(np.log(YEAR / (self.false_alarms * self.window) / EXCESS))

    def per_window(self) -> Vector:
        """Rate of each class per window, (classes,)."""
        return np.array([self.rates[name] for name in NAMES]) * self.window / YEAR


def alarm_settings(false_alarms: float, rates: Mapping[str, Any]) -> AlarmSettings:
    """Settings from what a user gives.

    Args:
        false_alarms: False alarms per wheel-year.
        rates: Class -> faults per wheel-year; other classes keep their usual rates.

    Raises:
        InputError: A class is unknown, or a number is not above 0.
    """
    require("false_alarms", false_alarms, "per wheel-year", positive=True)
    stated: dict[str, float] = {}
    for name, value in rates.items():
        if name not in NAMES:
            raise InputError(
                f"fault_rates: found the class {name!r}, expected one of {', '.join(NAMES)}"
            )
        try:
            stated[name] = float(value)
        except (TypeError, ValueError):
            raise InputError(
                f"fault_rates: found {value!r} for {name}, expected a number"
            ) from None
        require(f"fault_rates: {name}", stated[name], "per wheel-year", positive=True)
    usual = AlarmSettings()
    return AlarmSettings(false_alarms, {**usual.rates, **stated})


@dataclass(frozen=True)
class Verdict(Described):
    """Verdict after a window.

    Attributes:
        statistic: Log of the Shiryaev-Roberts statistic.
        alarm: Whether it is above the threshold.
        probabilities: "none" and each class -> probability, from the evidence and the rates.
        classes: Classes that are the answer if there is a change: one, two or three that cannot be
            told apart, or none if more are possible.
        onset: Window in which the most probable class of change began, and the limits of its 90 %
            interval; None without an alarm.
    """

    statistic: float
    alarm: bool
    probabilities: Mapping[str, float]
    classes: tuple[str, ...]
    onset: tuple[int, int, int] | None


def answer(probabilities: Vector) -> tuple[str, ...]:
    """The smallest set of classes with the probability `SURE`, given a change; at most `MOST`.

    Args:
        probabilities: Of no change and each class, (1 + classes,).
    """
    changed = probabilities[1:] / max(np.sum(probabilities[1:]), 1e-300)
    order = np.argsort(changed)[::-1]
    for count in range(1, MOST + 1):
        if np.sum(changed[order[:count]]) >= SURE:
            return tuple(NAMES[k] for k in order[:count])
    return ()


@dataclass(eq=False)
class Detector:
    """Detector of one wheel.

    Attributes:
        reference: Values that the estimates are divided by.
        settings: Settings.
        onsets: Number of windows before the present in which a change may have begun.
        levels: Levels of the wheel.
    """

    reference: Reference
    settings: AlarmSettings = field(default_factory=AlarmSettings)
    onsets: int = LevelSettings().onsets
    levels: Levels = field(init=False)

    def __post_init__(self):
        self.levels = Levels(SIGNATURES, LevelSettings(onsets=self.onsets), self.reference)

    def update(self, row: Mapping[str, Any]) -> Verdict:
        """Take the next window.

        Args:
            row: Row of the window table.
        """
        return self.take(observation(row, self.reference))

    def take(self, seen: Observation) -> Verdict:
        """Take the observation of the next window."""
        self.levels.update(seen)
        return self.verdict(evidence(self.levels))

    def verdict(self, found: Evidence) -> Verdict:
        """Verdict from evidence."""
        rates = self.settings.per_window()
        statistic = found.statistic(rates)
        probabilities = found.probabilities(rates)
        alarm = statistic > self.settings.threshold
        onset = None
        if alarm:
            onset = _interval(found, int(np.argmax(probabilities[1:])))
        return Verdict(
            statistic,
            alarm,
            dict(zip(("none", *NAMES), map(float, probabilities), strict=True)),
            answer(probabilities),
            onset,
        )

    def changed(self, verdict: Verdict) -> Changed:
        """Levels and change after the last window; without an alarm, those of a healthy wheel.

        Args:
            verdict: Verdict of the last window.
        """
        if not verdict.alarm:
            return Changed(self.levels.mean, np.zeros(len(CHANNELS)), np.zeros(0))
        probable = max(NAMES, key=lambda name: verdict.probabilities[name])
        return changed(self.levels, NAMES.index(probable))

    def stored(self) -> bytes:
        """State as a NumPy archive; `restore` continues with it."""
        file = io.BytesIO()
        arrays = {name: getattr(self.levels, name) for name in _STORED}
        np.savez(file, count=self.levels.count, **arrays)
        return file.getvalue()

    def restore(self, content: bytes) -> None:
        """Continue with a state of `stored`."""
        with np.load(io.BytesIO(content)) as archive:
            self.levels.count = int(archive["count"])
            for name in _STORED:
                setattr(self.levels, name, archive[name].copy())


def _interval(found: Evidence, kind: int) -> tuple[int, int, int]:
    order = np.argsort(found.began)
    began, share = found.began[order], found.onset_probabilities(kind)[order]
    sums = np.cumsum(share)
    low, high = np.searchsorted(sums, [0.05, 0.95])
    last = began.size - 1
    peak = int(np.argmax(share))
    return int(began[peak]), int(began[min(int(low), last)]), int(began[min(int(high), last)])
