"""Verdict on each pointing requirement of a campaign: pass, fail, or not decided, with its margin.

A run that did not end counts as one that exceeds every size. A run without values of an index, for
example without a second observation period, is left out and counted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.campaigns.pointing.collected import counted_sizes
from gyrostat.campaigns.pointing.statistics import least_runs, mean_bounds, size_at, sizes_around
from gyrostat.campaigns.summary import Estimate, percentile_of, share_bounds
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.requirement import Requirement

PASS, FAIL, OPEN = "pass", "fail", "not decided"


@dataclass(frozen=True)
class Verdict:
    """Verdict on a requirement.

    Attributes:
        requirement: Requirement.
        verdict: "pass", "fail" or "not decided".
        why: Reason, a sentence.
        size: Size that is not exceeded at the level, rad; NaN without an answer, see `why`.
        is_limit: Whether the size is only known to be at most `size`: it is below all sizes that
            are counted.
        share: Share that is not above the required value, to compare with the level (temporal: with
            `Requirement.share`).
        runs: Number of runs that count.
        without: Number of runs without values of the index.
        needed: Number of runs from which the requirement can be shown at all.
    """

    requirement: Requirement
    verdict: str
    why: str
    size: Estimate
    is_limit: bool
    share: Estimate
    runs: int
    without: int
    needed: int

    @property
    def margin(self) -> Estimate:
        """Margin relative to the required value; the lowest belongs to the largest size."""
        value, low, high = (1.0 - size / self.requirement.value for size in self.size)
        return Estimate(value, high, low)


def runs_needed(requirement: Requirement) -> int:
    """Number of runs from which a requirement can be shown at all."""
    return least_runs(_level_of_runs(requirement))


def _level_of_runs(requirement: Requirement) -> float:
    is_temporal = requirement.interpretation == "temporal"
    return requirement.share if is_temporal else requirement.level


def judged(
    requirement: Requirement, metric: Vector, status: NDArray, totals: Matrix | None = None
) -> Verdict:
    """Judge a requirement.

    Args:
        requirement: Requirement.
        metric: Its metric, (runs,); NaN without values.
        status: Status of each run, 0 if it is complete, (runs,).
        totals: For a mixed requirement: sum over the complete runs of the shares of time that are
            not above each of `counted_sizes`, (sizes,), or of the first of them.
    """
    incomplete = status != 0
    counts = np.isfinite(metric) | incomplete
    runs, is_mixed = int(np.sum(counts)), requirement.interpretation == "mixed"
    level, needed = _level_of_runs(requirement), runs_needed(requirement)
    without = len(metric) - runs
    if runs == 0:
        none = Estimate(np.nan, np.nan, np.nan)
        why = f"no run has values of {requirement.index}"
        return Verdict(requirement, OPEN, why, none, False, none, 0, without, needed)
    if is_mixed:
        assert totals is not None
        size, share = _mixed(requirement, np.where(incomplete, 0.0, 1.0 - metric)[counts], totals)
    else:
        worst = np.where(incomplete, np.inf, metric)[counts]
        size, share = _of_runs(level, worst, requirement.value)
    verdict, why = OPEN, "the required value is within the confidence interval"
    if share.low >= level:
        verdict, why = PASS, "the upper limit of the confidence interval is within the requirement"
    elif share.high < level:
        verdict, why = FAIL, "the confidence interval is above the required value"
        if np.isnan(size.low):  # runs that did not end, or an older table that ends at a size
            within = f"{100.0 * share.high:.3g} % ({100.0 * level:.12g} % are required)"
            why = f"with 95 % confidence it is met in at most {within}"
    elif runs < needed:
        why = f"{runs} runs cannot show {100.0 * level:.12g} %: at least {needed} are needed"
        size = size._replace(value=np.nan)
    if np.any(incomplete) and not np.all(np.isfinite(size)):
        why += f"; {np.sum(incomplete)} of {runs} runs did not end and exceed every size"
    if without > 0:
        why += f"; {without} of {len(metric)} runs have no values and are left out"
    smallest = counted_sizes(requirement.value)[0] * requirement.value
    is_limit = is_mixed and bool(size.value == smallest)
    return Verdict(requirement, verdict, why, size, is_limit, share, runs, without, needed)


def _of_runs(level: float, worst: Vector, value: float) -> tuple[Estimate, Estimate]:
    """Size that a share of the runs does not exceed, and share of the runs within the value."""
    # the order statistics of the size and the binomial limits of the share agree
    largest = np.finfo(float).max
    inside, count = int(np.sum(worst <= value)), len(worst)
    np.minimum(worst, largest, out=worst)
    estimate = percentile_of(worst, round(100.0 * level, 10))
    size = Estimate(*(part if part < largest else np.nan for part in estimate))
    return size, Estimate(inside / count, *share_bounds(inside, count))


def _mixed(requirement: Requirement, shares: Vector, totals: Vector) -> tuple[Estimate, Estimate]:
    """Size that is not exceeded in a share of time and runs, and the share within the value."""
    count = len(shares)
    sizes = counted_sizes(requirement.value)[: len(totals)] * requirement.value
    means = np.clip(totals / count, 0.0, 1.0)
    bounds = np.array([mean_bounds(mean, count) for mean in means.tolist()])
    level = requirement.level
    size = Estimate(
        size_at(level, means, sizes),
        sizes_around(level, bounds[:, 1], sizes)[0],
        sizes_around(level, bounds[:, 0], sizes)[1],
    )
    mean = float(np.mean(shares))
    return size, Estimate(mean, *mean_bounds(mean, count))
