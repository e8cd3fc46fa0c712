"""Search for the best values of free numbers of a scenario."""

from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple, Self, final

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import PicturedText
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.scenario import Dispersion, Scenario
from gyrostat.search.condition import Condition, known_metric, quantity
from gyrostat.search.execute import Stored, stored_search
from gyrostat.search.flights import Columns
from gyrostat.search.moves import Answers, Moves
from gyrostat.search.tune import Tuned, fewest_flights, tune
from gyrostat.search.worst import library

FREE, MINIMISE, SUBJECT_TO = "free", "minimise", "subject_to"
"""Keys of the options of the search: free numbers, metric, and limits."""
FACTOR = 4.0
"""Bounds of a free number without bounds of its own: divided and multiplied by it."""
FIXED = (
    *("run.", "metrics.", "window.", "guard.", "requirement.", "body.", "wheel.", "start."),
    *("event.", "orbit.", "sensors.", "sensor.", "star_tracker.", "flexible.", "hinged_panel."),
    *("slosh.", "imbalance.", "environment."),
)
"""Beginnings of keys that cannot be free. Controllers and filters are designed for the nominal
spacecraft and its sensors: with other values, the tuned scenario would have another design than the
runs of the search."""


@dataclass(frozen=True)
class Tuning:
    """Search for the best gains; see `gyrostat.search.execute.Question`.

    Attributes:
        free: Key -> lower and upper bound, SI.
        given: Values of the scenario, (free,), SI.
        minimise: Metric to minimise.
        limits: Conditions that hold for 95 % of the runs.
    """

    free: Mapping[str, tuple[float, float]]
    given: tuple[float, ...]
    minimise: str
    limits: tuple[Condition, ...]

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        free: Mapping[str, str | None],
        minimise: str,
        limits: Iterable[str],
    ) -> Self:
        """Create the search from its options.

        Args:
            scenario: Scenario, without the free numbers among its dispersions.
            free: Key -> "LOW:HIGH", or None.
            minimise: Metric.
            limits: Conditions METRIC < VALUE.

        Raises:
            InputError: A key is no free number, a bound is not allowed, or there is no such metric.
        """
        known_metric(minimise, scenario, "--minimise")
        if not free:
            raise InputError("--free: found none, expected keys such as controller.rate_gain")
        bounds = {key: _bounds(scenario, key, text) for key, text in free.items()}
        conditions = tuple(Condition.parse(text, scenario, "--subject-to") for text in limits)
        values = tuple(float(scenario.values[key]) for key in free)
        for key, value in zip(bounds, values, strict=True):
            low, high = bounds[key]
            if not low <= value <= high:
                raise InputError(
                    f"--free {key}: found bounds {low:g} to {high:g}, expected the value of the "
                    f"scenario, {value:g}, within them"
                )
        return cls(bounds, values, minimise, conditions)

    def scenario(self, scenario: Scenario) -> Scenario:
        """Scenario whose last dispersions are the free numbers."""
        free = [Dispersion((key,), "uniform", (bounds,)) for key, bounds in self.free.items()]
        return replace(scenario, dispersions=(*scenario.dispersions, *free))

    def options(self) -> dict[str, Any]:
        """Options that campaign.json stores."""
        free = {key: f"{low!r}:{high!r}" for key, (low, high) in self.free.items()}
        return {FREE: free, MINIMISE: self.minimise, SUBJECT_TO: [c.text for c in self.limits]}

    @property
    def metrics(self) -> tuple[str, ...]:
        """The metric to minimise and those of the limits."""
        return (self.minimise, *(limit.metric for limit in self.limits))

    def response(self, columns: Columns) -> Matrix:
        """Metrics of runs with the opposite sign, (runs, metrics).

        Those of a limit METRIC > VALUE have their own sign.
        """
        signs = [1.0, *(-1.0 if limit.above else 1.0 for limit in self.limits)]
        metrics = [sign * columns[name] for sign, name in zip(signs, self.metrics, strict=True)]
        values = np.stack(metrics, axis=1)
        invalid = (columns["status"] != 0)[:, None] | np.isnan(values)
        return -np.where(invalid, np.inf, values)

    def excess(self, value: Vector) -> float:
        """How far the values of a candidate are beyond their limits, relative to these."""
        violations = [
            (each - (-limit.bound if limit.above else limit.bound)) / max(abs(limit.bound), 1e-12)
            for each, limit in zip(value[1:], self.limits, strict=True)
        ]
        return max(violations, default=0.0)

    def numbers(self, coordinates: Matrix) -> Matrix:
        """Free numbers of coordinates from −1 to 1, (n, free): logarithmic if positive."""
        low, high = np.array([*self.free.values()]).T
        part = 0.5 * (1.0 + coordinates)
        positive = low > 0.0
        ratio = np.where(positive, high, 1.0) / np.where(positive, low, 1.0)
        return np.where(positive, low * ratio**part, low + part * (high - low))

    def searches(self, runs: int, seed: int) -> list[Generator[Moves, Answers, Tuned]]:
        """The one search; raises `InputError`."""
        if runs < fewest_flights():
            raise InputError(
                f"--runs: found {runs}, expected at least {fewest_flights()} with tune"
            )
        library()  # before the first flight
        low, high = np.array([*self.free.values()]).T

        def share(coordinates: Matrix) -> Matrix:
            return np.clip((self.numbers(coordinates) - low) / (high - low), 0.0, 1.0)

        return [tune(self._start(), share, self.excess, runs, seed)]

    def _start(self) -> Vector:
        """Coordinates of the values of the scenario."""
        low, high = np.array([*self.free.values()]).T
        values, positive = np.array(self.given), low > 0.0
        safe = np.where(positive, [low, high, values], np.array([[1.0], [2.0], [1.0]]))
        logs = np.log(safe[2] / safe[0]) / np.log(safe[1] / safe[0])
        return 2.0 * np.where(positive, logs, (values - low) / (high - low)) - 1.0


def _bounds(scenario: Scenario, key: str, text: str | None) -> tuple[float, float]:
    """Bounds of a free number, SI; raises `InputError`."""
    entries = numbers_of(scenario)
    if key in scenario.dispersed:
        raise InputError(f"--free: found {key}, which is dispersed, expected another key")
    if key not in entries or key.startswith(FIXED) or key not in scenario.values:
        keys = [name for name in scenario.values if not name.startswith(FIXED)]
        similar = [name for name in keys if name.split(".")[0] == key.split(".")[0]]
        similar = similar or [
            name for name in keys if name.startswith(("controller.", "compensator."))
        ]
        raise InputError(f"--free: found {key!r}, expected one of {', '.join(similar or keys)}")
    entry, value = entries[key], float(scenario.values[key])
    if text is None:
        if not 0.0 < value < np.inf:
            raise InputError(f"--free {key}: found {value:g}, expected bounds: {key}=LOW:HIGH")
        low, high = value / FACTOR, value * FACTOR
    else:
        ends = text.split(":")
        if len(ends) != 2:
            raise InputError(f"--free {key}: found {text!r}, expected LOW:HIGH")
        low, high = (quantity(end, entry.unit, f"--free {key}") for end in ends)
    for end in (low, high):
        if not entry.allows(end):
            raise InputError(f"--free {key}: found {end:g}, expected {entry.range(end)}")
    if not low < high:
        raise InputError(f"--free {key}: found {low:g} to {high:g}, expected the smaller one first")
    return low, high


@final
class TunedGains(dict[str, Any], PicturedText):
    """Content of report.json of a search for gains, as `tune` returns it.

    Attributes:
        folder: Folder of the search.
    """

    folder: Path


class FoundTuning(NamedTuple):
    """What a search for gains found.

    Attributes:
        question: The search.
        tuned: Best candidate.
        stored: The finished search.
    """

    question: Tuning
    tuned: Tuned
    stored: Stored

    def values(self) -> dict[str, float]:
        """Best value of each free number, SI."""
        numbers = self.question.numbers(self.tuned.best[None])[0]
        return dict(zip(self.question.free, numbers.tolist(), strict=True))


def found_tuning(folder: Path) -> FoundTuning:
    """Read what a finished search for gains found.

    Args:
        folder: Folder of the search.

    Raises:
        InputError: The folder has no finished search.
    """
    search = stored_search(folder)
    options = search.options()
    dispersed = [d for d in search.scenario.dispersions if d.keys[0] not in options[FREE]]
    scenario = replace(search.scenario, dispersions=tuple(dispersed))
    question = Tuning.of(scenario, options[FREE], options[MINIMISE], options[SUBJECT_TO])
    (tuned,), _ = search.results(question)
    return FoundTuning(question, tuned, search)
