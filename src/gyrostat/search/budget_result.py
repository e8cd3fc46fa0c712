"""Result of a budget of the pointing error by source."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gyrostat.campaigns.summary import Estimate
from gyrostat.core.field_table import field_table
from gyrostat.core.pictured import Pictured
from gyrostat.core.text import aligned
from gyrostat.scenario.requirement import Requirement
from gyrostat.search.contributions import Contributions
from gyrostat.search.error_budget import FEWEST

ARCSEC = float(np.degrees(3600.0))
"""Arcseconds per radian."""
BIAS, LAG, REST = "bias (mean error)", "controller lag (all sources off)", "interactions"
"""Lines of a budget that are no sources."""
LARGE = 0.1
"""Share of the interactions in the whole from which contributions are rough."""
FEW, MOST = 0.05, 0.5
"""Fraction of the runs that are the worst, and the share of the mean square that is too much."""


class Line(NamedTuple):
    """Line of a budget.

    Attributes:
        name: Name of the source, or one of `BIAS`, `LAG` and `REST`.
        mean_square: Contribution to the mean square, rad².
        share: The same relative to the whole.
        alone: What the source adds alone, rad²; None for a line that is no source.
        missing: What is missing without it, rad²; None for a line that is no source.
    """

    _repr_html_ = field_table

    name: str
    mean_square: Estimate
    share: Estimate
    alone: Estimate | None = None
    missing: Estimate | None = None


class Missing(NamedTuple):
    """What is missing of a metric without a source or a property of the loop.

    Attributes:
        metric: Metric in words.
        unit: SI unit.
        whole: Metric with all sources.
        without: Source or property -> whole minus the metric without it.
    """

    _repr_html_ = field_table

    metric: str
    unit: str
    whole: Estimate
    without: dict[str, Estimate]


class IndexBudget(NamedTuple):
    """Budget of one pointing index.

    Attributes:
        requirement: Requirement with the index.
        split: Its mean square, split.
        properties: Property of the loop -> mean square that is missing without it, rad².
        size: What is missing of its size at the level.
        is_shapley: Whether the contributions are means over orders, so that nothing is left over.
        worst: Share of the whole mean square that the worst runs have, a fraction `FEW` of all.
    """

    _repr_html_ = field_table

    requirement: Requirement
    split: Contributions
    properties: dict[str, Estimate]
    size: Missing
    is_shapley: bool = False
    worst: float = 0.0

    def lines(self) -> list[Line]:
        """Lines that sum up to the whole: bias, lag, sources by size, interactions."""
        split = self.split
        bias, lag, rest = split.shares
        sources = sorted(split.sources, key=lambda each: -each.mean_square.value)
        return [
            Line(BIAS, split.bias, bias),
            Line(LAG, split.lag, lag),
            *(Line(e.name, e.mean_square, e.share, e.alone, e.missing) for e in sources),
            *([] if self.is_shapley else [Line(REST, split.interaction, rest)]),
        ]

    @property
    def title(self) -> str:
        """Index, axis and window in words."""
        each = self.requirement
        window = f" over {each.window:g} s" if each.window else ""
        stability = f", {each.stability:g} s apart" if each.stability else ""
        during = f", {' and '.join(each.during)}" if each.during else ""
        return f"{each.index}{window}{stability}, {each.axis.replace('_', ' ')}{during}"


@dataclass(frozen=True, eq=False)
class ErrorBudget(Pictured):
    """Budget of the pointing error by source.

    Attributes:
        scenario: Name of the scenario.
        runs: Number of runs with each set of sources.
        valid: Number of runs that ended with every set; the others are left out.
        failed: Set of sources -> number of runs that did not end with it.
        without: Requirement or metric -> number of the others that lack it with one of the sets.
        sets: Number of sets of sources.
        seed: Seed of the draws.
        indices: Budget of each pointing index.
        metrics: What is missing of further metrics.
        not_switched: Places of parts that cannot be switched off.
        orders: Number of orders in which the sources were switched on; 0: each alone.
        is_every_order: Whether these are all orders.
    """

    scenario: str
    runs: int
    valid: int
    failed: dict[str, int]
    without: dict[str, int]
    sets: int
    seed: int
    indices: tuple[IndexBudget, ...]
    metrics: tuple[Missing, ...]
    not_switched: tuple[str, ...]
    orders: int = 0
    is_every_order: bool = False

    def doubts(self) -> list[str]:
        """Why there is no result; empty if there is one."""
        if self.valid < FEWEST:
            return [f"{self.valid} of {self.runs} runs ended with every set of sources"]
        return [
            f"{self.valid - count} runs have values of {name} with every set of sources"
            for name, count in self.without.items()
            if self.valid - count < FEWEST
        ]

    def remarks(self) -> list[str]:
        """What a reader must know beside the numbers."""
        remarks = [
            f"{count} of {self.runs} runs did not end {name}; they are left out everywhere"
            for name, count in self.failed.items()
        ]
        remarks += [
            f"{count} of {self.valid} runs lack {name} with one of the sets; they are left out"
            for name, count in self.without.items()
        ]
        if self.orders:
            which = "all" if self.is_every_order else "random"
            remarks.append(f"contributions are Shapley values from {self.orders} {which} orders")
        remarks += [
            f"{each.title}: interactions of three and more sources are "
            f"{100.0 * each.split.shares[2].value:.0f} % of the whole, so that contributions are "
            "rough: --orders 32 shares the interactions out among the sources"
            for each in self.indices
            if not each.is_shapley and abs(each.split.shares[2].value) > LARGE
        ]
        remarks += [
            f"{each.title}: {100.0 * FEW:g} % of the runs have {100.0 * each.worst:.0f} % of the "
            "mean square: a rare event, for which the intervals are too narrow"
            for each in self.indices
            if each.worst > MOST
        ]
        lines = [line for each in self.indices for line in each.lines()]
        if any(line.mean_square.value < 0.0 for line in lines):
            remarks.append(
                "a negative number: the source lowers the error, or does nothing within its "
                "confidence"
            )
        if self.not_switched:
            remarks.append(
                f"not switched off, in every line: {', '.join(self.not_switched)} (no key is "
                "declared as a source, or a window or a later event needs it)"
            )
        return remarks

    def text_lines(self) -> list[str]:
        """The budget as lines for a terminal."""
        lines = [
            f"{self.scenario}: {self.valid} runs with each of {self.sets} sets of sources, seed "
            f"{self.seed}; arcsec are roots of mean squares"
        ]
        for index in self.indices:
            whole = index.split.whole.value
            lines += ["", f"{index.title}: {rms_text(index.split.whole, whole)} arcsec"]
            rows = [
                (
                    line.name,
                    rms_text(line.mean_square, whole),
                    square_text(line.mean_square.value, whole),
                    percent_text(line.share),
                )
                for line in index.lines()
            ]
            lines += [f"  {row}" for row in aligned(rows, ("source", "arcsec", "arcsec²", "share"))]
            for name, estimate in index.properties.items():
                lines.append(
                    f"  whole minus that without {name}: {rms_text(estimate, whole)} arcsec"
                )
        return [*lines, *(f"  {text}" for text in (*self.remarks(), *self.doubts()))]

    def __str__(self) -> str:
        """The lines for a terminal."""
        return "\n".join(self.text_lines())


def root(mean_square: float) -> float:
    """Root of a mean square, arcsec, with the sign of the mean square."""
    return float(np.sign(mean_square) * np.sqrt(np.abs(mean_square)) * ARCSEC)


def rms_text(estimate: Estimate, whole: float) -> str:
    """Root of a mean square with its interval, arcsec, as precise as the whole mean square."""
    digits = decimals(root(whole))
    value, low, high = (fixed(root(each), digits) for each in estimate)
    return f"{value} ({low} to {high})"


def square_text(mean_square: float, whole: float) -> str:
    """Mean square, arcsec², as precise as the whole."""
    return fixed(mean_square * ARCSEC**2, decimals(whole * ARCSEC**2))


def percent_text(share: Estimate) -> str:
    """Share with its interval, percent."""
    value, low, high = (fixed(100.0 * each, 1) for each in share)
    return f"{value} % ({low} to {high})"


def decimals(scale: float) -> int:
    """Number of decimals with which a number of this size has three digits."""
    if not (np.isfinite(scale) and scale != 0.0):
        return 2
    return max(0, 2 - int(np.floor(np.log10(abs(scale)))))


def fixed(value: float, digits: int) -> str:
    """Number with some decimals; zero has no sign."""
    return f"{round(value, digits) + 0.0:.{digits}f}"
