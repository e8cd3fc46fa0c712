"""Dispersed cases with every controller, for the full reproduction."""

from collections.abc import Mapping, Sequence

import numpy as np

from gyrostat.papers.claims import Value
from gyrostat.papers.endo_sekiguchi_nonaka.controllers import (
    OURS,
    SAFE_FRIT,
    SLOW,
    UNCOMPENSATED,
    Outcome,
    evaluate,
)
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import Case, draw, paper_case
from gyrostat.papers.endo_sekiguchi_nonaka.figures import dispersed_figure
from gyrostat.papers.reproduction import Part, Run

CASES, SEED = 1000, 2024
"""Number of cases, simulated with every controller, and their seed."""
EXTRA = 40.0
"""Allowance, s: a run is in time within 1.10 T + 40 s."""


def dispersed_runs(run: Run) -> Part:
    """Simulate the dispersed cases and the paper's own."""
    cases = [*draw(CASES, SEED), paper_case()]
    every = (OURS, SAFE_FRIT, UNCOMPENSATED, *SLOW)
    return claimed(cases, {each.key: evaluate(each, cases, say=run.say) for each in every})


def claimed(cases: Sequence[Case], found: Mapping[str, Outcome]) -> Part:
    """Values and figure of the dispersed runs.

    Args:
        cases: Dispersed cases, followed by the paper's own.
        found: Key of a candidate -> its runs of all cases.
    """
    paper_settled = float(found[OURS.key].settled[-1])
    found = {key: Outcome(*(x[:-1] for x in outcome)) for key, outcome in found.items()}
    ours = found[OURS.key]
    share = {key: float(np.mean(outcome.holds)) for key, outcome in found.items()}
    quickest = np.array([case.quickest for case in cases[:-1]])
    values: dict[str, Value] = {
        "dispersed.cases": float(len(quickest)),
        "dispersed.success_fraction": share[OURS.key],
        "dispersed.worst_settle_ratio": float(np.max(ours.settled / quickest)),
        "dispersed.worst_last_error_deg": float(np.max(ours.last)),
        "paper_case.settle_s": paper_settled,
        "dispersed.paper_success_fraction": share["paper"],
        "dispersed.fixed_gain_success_fraction": share["fixed_gain"],
    }
    in_time = [np.mean(ours.settled <= factor * quickest + EXTRA) for factor in (1.10, 1.05)]
    facts = {
        "share": share,
        "in_time": in_time,
        "demand": float(np.max(ours.demand)),
        "roll": float(np.rad2deg(np.max(ours.roll))),
        "mean_last": {key: float(np.mean(outcome.last)) for key, outcome in found.items()},
    }
    return Part(values, facts, (dispersed_figure(quickest, found),))
