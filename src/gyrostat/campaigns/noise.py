"""Noise of flights whose parts of time have the noise of several runs.

A run is divided into parts of equal length. The noise of a flight in a part is that of the run with
a given number, in the same part. A flight takes these numbers over from its parent, and replaces
some of them at random by its own. Parent and expected share of replaced parts therefore determine
the noise of a flight.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.description import Campaign
from gyrostat.campaigns.draws import noise_keys
from gyrostat.core.threefry import Words, threefry
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.scenario import Scenario

MOST_PARTS = 512
"""Largest number of parts of a run."""
PARENT, REPLACED = "parent", "replaced"
"""Columns of the table of runs: parent of a flight and expected share of its replaced noise."""
_PARTS = 2


def parts_of(scenario: Scenario) -> int:
    """Number of parts of a run: one for each sample if there are not too many."""
    size = -(-(scenario.count + 1) // MOST_PARTS)
    return -(-(scenario.count + 1) // size)


def noise_of(
    numbers: NDArray[np.int64], parents: NDArray[np.int64], shares: Vector, seed: int, parts: int
) -> Words:
    """Random keys of the noise of flights, (n, parts).

    Args:
        numbers: Numbers of the flights, (n,).
        parents: Parent of every flight of the search; negative for a flight without a parent.
        shares: Expected share of replaced parts of every flight.
        seed: Seed of the campaign.
        parts: Number of parts of a run.
    """
    source = np.full((len(numbers), parts), -1, np.int64)
    rows, columns = (indices.ravel() for indices in np.indices(source.shape))
    current = np.repeat(numbers, parts)
    while len(rows):
        is_new = (parents[current] < 0) | _is_replaced(seed, current, columns, shares[current])
        source[rows[is_new], columns[is_new]] = current[is_new]
        rows, columns, current = rows[~is_new], columns[~is_new], parents[current[~is_new]]
    return noise_keys(seed, source)


def given_of(campaign: Campaign, table: Any, runs: Sequence[int]) -> tuple[Matrix, Words]:
    """Dispersed values, (n, keys), and random keys of the noise, (n, parts), of finished flights.

    Args:
        campaign: Campaign of the search.
        table: Table of all flights.
        runs: Numbers of the flights.
    """
    scenario = Scenario.from_text(campaign.scenario)
    numbers = np.array(runs, np.int64)
    values = np.stack([table[key].to_numpy()[numbers] for key in scenario.dispersed], axis=1)
    parents, shares = (table[name].to_numpy() for name in (PARENT, REPLACED))
    return values, noise_of(numbers, parents, shares, campaign.seed, parts_of(scenario))


def _is_replaced(seed: int, flights: NDArray, part: NDArray, share: Vector) -> NDArray[np.bool_]:
    bits = threefry(threefry(threefry(seed, flights), _PARTS), part)
    return (bits >> np.uint64(11)).astype(float) * 2.0**-53 < share
