"""Comparison of fits as text."""

from collections.abc import Callable, Mapping
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


def _change(item: Change, factor: float, unit: str) -> tuple[str, ...]:
    difference = ""
    if item.difference is not None and item.sigma is not None:
        difference = measured(factor * item.difference, factor * item.sigma)
    return item.parameter, item.fit, item.reference, difference, unit


def _trend(item: Trend, factor: float, unit: str) -> tuple[str, ...]:
    slope = measured(YEAR * factor * item.slope, YEAR * factor * item.sigma)
    return item.parameter, slope, f"{unit} per year"


def _spread(item: BatchSpread, factor: float, unit: str) -> tuple[str, ...]:
    low, high = (plain(factor * end, 2) for end in (item.low, item.high))
    mean = measured(factor * item.mean, factor * item.mean_sigma)
    return item.parameter, mean, f"{plain(factor * item.spread, 3)} ({low} to {high})", unit


_TABLES: dict[type, tuple[tuple[str, ...], Callable[[Any, float, str], tuple[str, ...]]]] = {
    Change: (("parameter", "fit", "against", "difference ± sigma", "unit"), _change),
    Trend: (("parameter", "change per year ± sigma", "unit"), _trend),
    BatchSpread: (("parameter", "mean ± sigma", "spread between wheels (95 %)", "unit"), _spread),
}
"""Class of a row -> header and cells, without its significance."""


def _significance(item: Any) -> tuple[str, str]:
    chance = "< 0.0001" if item.chance < 1e-4 else f"{item.chance:.4f}"
    return chance, "YES" if item.significant else "no"


def tables(
    comparison: Comparison, units: Mapping[str, tuple[float, str]] | None = None
) -> list[tuple[str, tuple[str, ...], list[Any]]]:
    """Title, header, and rows with their results, of each table that has a row.

    Args:
        comparison: Comparison of fits.
        units: Parameter -> factor from SI and unit in which it is shown; None: SI units.
    """
    every = (
        ("Differences", comparison.changes),
        ("Trends", comparison.trends),
        ("Spread between wheels", comparison.spreads),
    )
    return [
        (title, _header(items[0]), [(_row(item, units or {}), item) for item in items])
        for title, items in every
        if items
    ]


def _header(item: Any) -> tuple[str, ...]:
    return (*_TABLES[type(item)][0], "p", "significant")


def _row(item: Any, units: Mapping[str, tuple[float, str]]) -> tuple[str, ...]:
    cells = _TABLES[type(item)][1](item, *units.get(item.parameter, (1.0, item.unit)))
    return (*cells, *_significance(item))


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


@text_view.register(Change)
@text_view.register(Trend)
@text_view.register(BatchSpread)
def row_table(item: Any) -> list[str]:
    """Format one row of a comparison with its header, in lines."""
    return aligned([_row(item, {})], _header(item))


@text_view.register(Comparison)
def comparison_table(comparison: Comparison) -> list[str]:
    """Format a comparison as the command line prints it, in lines."""
    lines = [shared_text(comparison)]
    for _, header, rows in tables(comparison):
        lines += [f"  {line}" for line in aligned([row for row, _ in rows], header)]
    return [*lines, *(f"note: {note}" for note in comparison.notes), verdict(comparison)]
