"""Search for the worst case of a metric within bounds."""

import re
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.scenario.kinds.distributions import distributions_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.search.condition import known_metric
from gyrostat.search.execute import Stored, stored_search
from gyrostat.search.flights import Columns
from gyrostat.search.moves import Answers, Moves
from gyrostat.search.worst import Bounds, Worst, fewest_flights, library, worst_case

WORST_CASE, WITHIN = "worst_case", "within"
"""Keys of the metric and of the bounds in the options of the search."""
BOX_SIGMA = 3.0
"""Bound of normal and log-normal dispersions in a box, standard deviations."""
MOST_SIGMA = 8.0
_SIGMA = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*sigma\s*", re.ASCII)


@dataclass(frozen=True)
class WorstCase:
    """Search for a worst case; see `gyrostat.search.execute.Question`.

    Attributes:
        metric: Metric; larger is worse.
        within: Bounds: "3sigma" (any number) or "box".
        bounds: The bounds of the dispersions.
    """

    metric: str
    within: str
    bounds: Bounds

    @classmethod
    def of(cls, scenario: Scenario, metric: str, within: str) -> Self:
        """Create the search from its options; raises `InputError`."""
        known_metric(metric, scenario, "--worst-case")
        match, ends = _SIGMA.fullmatch(within), within.strip() == "box"
        sigma = float(match[1]) if match is not None else BOX_SIGMA
        if (match is None and not ends) or not 0.0 < sigma <= MOST_SIGMA:
            raise InputError(
                f"--within: found {within!r}, expected box or a number up to {MOST_SIGMA:g} with "
                "sigma: 3sigma"
            )
        limited = [each.is_bounded() for each in distributions_of(scenario)]
        return cls(metric, within.strip(), Bounds(np.concatenate(limited), sigma, ends))

    def options(self) -> dict[str, Any]:
        """Options that campaign.json stores."""
        return {WORST_CASE: self.metric, WITHIN: self.within}

    def response(self, columns: Columns) -> Vector:
        """The metric of runs, (runs,); infinite for a run that ends early or never settles."""
        fallback = np.inf if self.metric.split(".")[-1] == "settling" else -np.inf
        value = np.where(np.isnan(columns[self.metric]), fallback, columns[self.metric])
        return np.where(columns["status"] != 0, np.inf, value)

    def searches(self, runs: int, seed: int) -> list[Generator[Moves, Answers, Worst]]:
        """The one search; raises `InputError`."""
        keys = len(self.bounds.limited)
        least = fewest_flights(keys)
        if runs < least:
            raise InputError(
                f"--runs: found {runs}, expected at least {least} with --worst-case and {keys} "
                "dispersed values"
            )
        library()  # before the first flight
        return [worst_case(self.bounds, runs, seed)]


class FoundWorst(NamedTuple):
    """What a search for the worst case found.

    Attributes:
        question: The search.
        worst: Worst case.
        stored: The finished search.
        refused: Number of proposed runs whose values are not allowed.
    """

    question: WorstCase
    worst: Worst
    stored: Stored
    refused: int

    def doubts(self) -> tuple[str, ...]:
        """Why there is no worst case; empty if there is one."""
        if self.worst.response > -np.inf:
            return ()
        return (f"no run has the metric {self.question.metric}",)


def found_worst(folder: Path) -> FoundWorst:
    """Read what a finished search for the worst case found.

    Args:
        folder: Folder of the search.

    Raises:
        InputError: The folder has no finished search.
    """
    search = stored_search(folder)
    options = search.options()
    question = WorstCase.of(search.scenario, options[WORST_CASE], options[WITHIN])
    (worst,), refused = search.results(question)
    return FoundWorst(question, worst, search, refused)
