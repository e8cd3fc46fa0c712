"""Comparison of fits as text."""

from typing import Any

from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.views import lines as text_view
from gyrostat.identification.judge.fit_changes import (
    FALSE_ALARMS,
    BatchSpread,
    Change,
    Comparison,
    Trend,
)

YEAR = 365.25
"""Days of a year."""


def _change(item: Change) -> tuple[str, ...]:
    difference = ""
    if item.difference is not None and item.sigma is not None:
        difference = measured(item.difference, item.sigma)
    return item.parameter, item.fit, item.reference, difference, item.unit


def _trend(item: Trend) -> tuple[str, ...]:
    slope = measured(YEAR * item.slope, YEAR * item.sigma)
    return item.parameter, slope, f"{item.unit} per year"


def _spread(item: BatchSpread) -> tuple[str, ...]:
    spread = f"{plain(item.spread, 3)} ({plain(item.low, 2)} to {plain(item.high, 2)})"
    return item.parameter, measured(item.mean, item.mean_sigma), spread, item.unit


def _significance(item: Any) -> tuple[str, str]:
    chance = "< 0.0001" if item.chance < 1e-4 else f"{item.chance:.4f}"
    return chance, "YES" if item.significant else "no"


def tables(comparison: Comparison) -> list[tuple[str, tuple[str, ...], list[Any]]]:
    """Title, header, and rows with their results, of each table that has a row."""
    changes = ("parameter", "fit", "against", "difference ± sigma", "unit")
    trends = ("parameter", "change per year ± sigma", "unit")
    spreads = ("parameter", "mean ± sigma", "spread between wheels (95 %)", "unit")
    every: tuple[Any, ...] = (
        ("Differences", changes, _change, comparison.changes),
        ("Trends", trends, _trend, comparison.trends),
        ("Spread between wheels", spreads, _spread, comparison.spreads),
    )
    return [
        (
            title,
            (*header, "p", "significant"),
            [((*text(item), *_significance(item)), item) for item in items],
        )
        for title, header, text, items in every
        if items
    ]


def verdict(comparison: Comparison) -> str:
    """Result of a comparison in one sentence."""
    results = [f"{c.parameter} of {c.fit}" for c in comparison.changes if c.significant]
    results += [f"trend of {t.parameter}" for t in comparison.trends if t.significant]
    results += [f"spread of {s.parameter}" for s in comparison.spreads if s.significant]
    text = ", ".join(results) or "nothing"
    return (
        f"significant over {comparison.tests} tests (Holm, {100.0 * FALSE_ALARMS:.0f} % false "
        f"alarms over all): {text}"
    )


def shared_text(comparison: Comparison) -> str:
    """What the fits have in common, in one sentence."""
    kind = "one wheel" if comparison.same_wheel else "different wheels"
    names = " and ".join(name.replace("_", " ") for name in comparison.shared)
    if not names:
        return f"fits of {kind}; all errors are taken as independent"
    return f"fits of {kind}; the error of the {names} is common to them and cancels in differences"


@text_view.register(Comparison)
def comparison_table(comparison: Comparison) -> list[str]:
    """Format a comparison as the command line prints it, in lines."""
    lines = [shared_text(comparison)]
    for _, header, rows in tables(comparison):
        lines += [f"  {line}" for line in aligned([row for row, _ in rows], header)]
    return [*lines, *(f"note: {note}" for note in comparison.notes), verdict(comparison)]
