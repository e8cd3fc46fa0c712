"""Tables of many runs that imitate those of a campaign, from the results of a few runs.

They measure what a campaign of any size costs after its runs: writing, statistics and report.
"""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.description import Campaign
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.pointing.campaign import PROFILED
from gyrostat.campaigns.store import Store
from gyrostat.core.types import Vector
from gyrostat.scenario.scenario import Scenario

_SPREAD = 1e-3
"""Relative standard deviation that makes the values of a metric differ between runs."""


def imitated_runs(
    scenario: Scenario, seed: int, runs: NDArray[np.int64], columns: Mapping[str, Vector]
) -> dict[str, Vector]:
    """Columns of runs that were not simulated.

    The drawn values are those of the runs. The other values are those of the simulated runs, in
    turn; a metric that differs between all of them differs between all of these runs too.

    Args:
        scenario: Scenario.
        seed: Seed of the campaign.
        runs: Numbers of the runs, (n,).
        columns: Columns of the simulated runs, see `gyrostat.campaigns.flown.Flown`.
    """
    random = np.random.default_rng(int(runs[0]))
    drawn = dict(zip(scenario.dispersed, draw(scenario, seed, runs)[0].T, strict=True))
    count = len(columns["run"])
    rows = runs % count
    imitated: dict[str, Vector] = {}
    for name, values in columns.items():
        column: Any = values[rows]
        if name == "run":
            column = runs
        elif name in drawn:
            column = drawn[name]
        elif column.ndim == 2 and name.endswith(".profile"):
            factor = 1.0 + _SPREAD * random.standard_normal(column.shape)
            column = np.where((runs < PROFILED)[:, None], factor * column, np.nan)
            column = column.astype(values.dtype)
        elif column.ndim == 1 and len(np.unique(values)) == count:
            column = column * (1.0 + _SPREAD * random.standard_normal(len(runs)))
        imitated[name] = column
    return imitated


def write_imitation(
    store: Store, scenario: Scenario, campaign: Campaign, columns: Mapping[str, Vector]
) -> float:
    """Start a campaign in a new folder and write all of its blocks; see `imitated_runs`.

    Returns:
        Processor time of the writing alone, s.
    """
    store.begin(campaign)
    spent = 0.0
    for number in range(campaign.blocks):
        runs = np.array(campaign.numbers(number))
        imitated = imitated_runs(scenario, campaign.seed, runs, columns)
        start = time.process_time()
        store.write_block(campaign, number, imitated)
        spent += time.process_time() - start
    return spent
