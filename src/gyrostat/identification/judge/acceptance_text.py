"""Acceptance test as text."""

import numpy as np

from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.views import lines as text_view
from gyrostat.identification.judge.acceptance_lines import Acceptance, Line

MOST = 100.0
"""Largest margin that is stated as a number, in standard deviations."""
HEADER = ("quantity", "limits", "unit", "measured ± sigma", "margin", "verdict")


@text_view.register
def acceptance_table(acceptance: Acceptance) -> list[str]:
    """Format an acceptance test as the command line prints it, in lines."""
    lines = aligned(acceptance_rows(acceptance), HEADER)
    return [*lines, *(f"note: {note}" for note in acceptance.notes), acceptance.verdict]


def acceptance_rows(acceptance: Acceptance) -> list[tuple[str, str, str, str, str, str]]:
    """Rows of the acceptance table: quantity, limits, unit, measured ± sigma, margin, verdict."""
    return [_row(line) for line in acceptance.lines]


def _row(line: Line) -> tuple[str, str, str, str, str, str]:
    unit = line.limit.unit
    low, high = line.limit.minimum / unit.factor, line.limit.maximum / unit.factor
    limits = "none"
    if np.isfinite(low) and np.isfinite(high):
        limits = f"{plain(low)} to {plain(high)}"
    elif line.limit.limited:
        limits = f"at least {plain(low)}" if np.isfinite(low) else f"at most {plain(high)}"
    elif line.limit.value is not None:
        limits = f"({plain(line.limit.value / unit.factor)})"
    value = margin = ""
    if line.measured is not None and line.sigma is not None:
        value = measured(line.measured / unit.factor, line.sigma / unit.factor)
    if line.margin is not None:
        margin = f"{line.margin / unit.factor:+.3g}"
        margin += _in_sigma(line.margin / line.sigma) if line.sigma else ""
    verdict = f"{line.verdict}: {line.why}" if line.why else line.verdict
    return line.title, limits, unit.symbol, value, margin, verdict


def _in_sigma(ratio: float) -> str:
    """Margin in standard deviations; beyond `MOST` the number says nothing more."""
    if abs(ratio) > MOST:
        return f" (more than {MOST:g} sigma{' outside' if ratio < 0.0 else ''})"
    return f" ({ratio:+.1f} sigma)"
