"""Comparison of fits as text."""

from typing import Any

from gyrostat.core.text import aligned, measured, plain
from gyrostat.identification.fit_changes import FALSE_ALARMS, Comparison

_CHANGES = ("parameter", "fit", "against", "difference ± sigma", "unit", "p", "significant")
_TRENDS = ("parameter", "change per year ± sigma", "unit", "p", "significant")
_SPREADS = ("parameter", "mean ± sigma", "spread between wheels (95 %)", "unit", "p", "significant")
YEAR = 365.25
"""Days of a year."""


def _chance(value: float) -> str:
    return "< 0.0001" if value < 1e-4 else f"{value:.4f}"


def _yes(significant: bool) -> str:
    return "YES" if significant else "no"


def _change_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Rows of the table of differences."""
    return [
        (
            c.parameter,
            c.fit,
            c.reference,
            "" if c.difference is None or c.sigma is None else measured(c.difference, c.sigma),
            c.unit,
            _chance(c.chance),
            _yes(c.significant),
        )
        for c in comparison.changes
    ]


def _trend_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Rows of the table of trends."""
    return [
        (
            t.parameter,
            measured(YEAR * t.slope, YEAR * t.sigma),
            f"{t.unit} per year",
            _chance(t.chance),
            _yes(t.significant),
        )
        for t in comparison.trends
    ]


def _spread_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Rows of the table of spreads between wheels."""
    return [
        (
            s.parameter,
            measured(s.mean, s.mean_sigma),
            f"{plain(s.spread, 3)} ({plain(s.low, 2)} to {plain(s.high, 2)})",
            s.unit,
            _chance(s.chance),
            _yes(s.significant),
        )
        for s in comparison.spreads
    ]


def tables(comparison: Comparison) -> list[tuple[str, tuple[str, ...], list[Any]]]:
    """Title, header, and rows with their results, of each table that has a row."""
    every = (
        ("Differences", _CHANGES, _change_rows(comparison), comparison.changes),
        ("Trends", _TRENDS, _trend_rows(comparison), comparison.trends),
        ("Spread between wheels", _SPREADS, _spread_rows(comparison), comparison.spreads),
    )
    return [
        (title, header, list(zip(rows, items, strict=True)))
        for title, header, rows, items in every
        if rows
    ]


def verdict(comparison: Comparison) -> str:
    """Result of a comparison in one sentence."""
    changed = [f"{c.parameter} of {c.fit}" for c in comparison.changes if c.significant]
    changed += [f"trend of {t.parameter}" for t in comparison.trends if t.significant]
    changed += [f"spread of {s.parameter}" for s in comparison.spreads if s.significant]
    told = ", ".join(changed) or "nothing"
    return (
        f"significant over {comparison.tests} tests (Holm, {100.0 * FALSE_ALARMS:.0f} % false "
        f"alarms over all): {told}"
    )


def shared_text(comparison: Comparison) -> str:
    """What the fits have in common, in one sentence."""
    what = "one wheel" if comparison.same_wheel else "different wheels"
    names = " and ".join(name.replace("_", " ") for name in comparison.shared)
    if not names:
        return f"fits of {what}; all errors are taken as independent"
    return f"fits of {what}; the error of the {names} is common to them and cancels in differences"


def comparison_table(comparison: Comparison) -> list[str]:
    """Format a comparison as the command line prints it, in lines."""
    lines = [shared_text(comparison)]
    for _, header, rows in tables(comparison):
        lines += [f"  {line}" for line in aligned([row for row, _ in rows], header)]
    return [*lines, *(f"note: {note}" for note in comparison.notes), verdict(comparison)]
