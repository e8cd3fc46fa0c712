"""Search for the probability of a rare failure of a run."""

from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.search.condition import Condition
from gyrostat.search.estimate import Rarity, rarity
from gyrostat.search.execute import stored_search
from gyrostat.search.flights import Columns
from gyrostat.search.moves import Answers, Moves
from gyrostat.search.subset import Replication, flights_of, subset_simulation

REPLICATIONS = 5
"""Number of independent replications.

A replication with few chains misses failures that few of its independent runs come close to. Few
replications with many chains each are therefore better than many.
"""
ENOUGH = 20_000
"""Number of runs that suits probabilities down to 1e-6."""
FEW = (
    f"fewer than {ENOUGH} runs often have no answer: 4100 suit probabilities of 1e-2, "
    f"8200 of 1e-3, {ENOUGH} of 1e-6"
)
"""Message before a search with fewer runs."""
FEWEST_CHAINS = 20
"""Fewest chains of a replication."""
RARE = "rare"
"""Key of the condition in the options of the search."""


@dataclass(frozen=True)
class RareFailure:
    """Search for failures; see `gyrostat.search.execute.Question`.

    Attributes:
        condition: Condition of a failure.
    """

    condition: Condition

    def options(self) -> dict[str, Any]:
        """Options that campaign.json stores."""
        return {RARE: self.condition.text}

    def response(self, columns: Columns) -> Vector:
        """Response of runs, (runs,): positive for a failure."""
        return self.condition.response(columns)

    def searches(self, runs: int, seed: int) -> list[Generator[Moves, Answers, Replication]]:
        """Independent replications of subset simulation; raises `InputError`."""
        return searches_of(runs, seed)


class Found(NamedTuple):
    """What a search for failures found.

    Attributes:
        condition: Condition of a failure.
        rarity: Probability and its interval.
        replications: Independent replications.
        columns: Columns of the table of runs.
        refused: Number of proposed runs whose values are not allowed.
    """

    condition: Condition
    rarity: Rarity
    replications: tuple[Replication, ...]
    columns: dict[str, Vector]
    refused: int


def searches_of(runs: int, seed: int) -> list[Generator[Moves, Answers, Replication]]:
    """Independent replications for a largest number of runs; raises `InputError`."""
    chains = runs // (REPLICATIONS * flights_of(1))
    if chains < FEWEST_CHAINS:
        least = FEWEST_CHAINS * REPLICATIONS * flights_of(1)
        raise InputError(f"--runs: found {runs}, expected at least {least} with --rare")
    return [subset_simulation(chains, [seed, k]) for k in range(REPLICATIONS)]


def found_failures(folder: Path) -> Found:
    """Read what a finished search for failures found.

    Args:
        folder: Folder of the search.

    Raises:
        InputError: The folder has no finished search.
    """
    search = stored_search(folder)
    condition = Condition.parse(search.options()[RARE], search.scenario, "--rare")
    replications, refused = search.results(RareFailure(condition))
    result = rarity(replications)
    count = condition.missing(search.columns)
    if count:
        doubt = f"{count} runs have no {condition.metric}: they count as no failure"
        result = replace(result, doubts=(*result.doubts, doubt))
    return Found(condition, result, tuple(replications), search.columns, refused)
