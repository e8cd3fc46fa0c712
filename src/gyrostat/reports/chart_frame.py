"""Size of a chart, and its grid with ticks and their numbers."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from gyrostat.reports.axis import Axis, number

WIDTH, HEIGHT = 440, 236
"""Size of a chart in its own units, which are pixels on a page of common width."""
LEFT, RIGHT, TOP, BOTTOM = 52, 10, 24, 38
MOST = 7
"""Largest number of intervals of the horizontal axis; half of it where numbers are long."""
LETTER = 7.0
"""Width of a letter of a tick."""


def ticks(
    x: Axis, y: Axis, height: int, rows: Sequence[str], columns: Sequence[str]
) -> list[Markup]:
    """Grid, ticks and their numbers.

    Args:
        x: Horizontal axis.
        y: Vertical axis.
        height: Height of the chart.
        rows: Names of the values of the vertical axis, which then has no ticks.
        columns: Names of the values 0, 1, ... of the horizontal axis; numbers from 1 on where the
            names are too long. `chart.js` does the same.
    """
    wide, high = WIDTH - LEFT - RIGHT, height - TOP - BOTTOM
    parts = []
    is_long = LETTER * max(map(len, columns), default=0) > wide / max(len(columns), 1)
    values = x.ticks(MOST)
    if values and LETTER * max(len(x.named(value)) for value in values) > wide / len(values):
        values = x.ticks(MOST // 2)
    for value in range(len(columns)) if columns else values:
        position = float(x.place(np.array([value]))[0])
        at = LEFT + wide * position / 1000.0
        grid = Markup('<path d="M{:.1f} {}V{}"/>').format(at, TOP, height - BOTTOM)
        text = Markup('<text class="x" x="{:.1f}" y="{}">{}</text>')
        name = columns[int(value)] if columns and not is_long else x.named(value + bool(columns))
        parts.append(grid + text.format(at, height - BOTTOM + 16, name))
    for value in [] if rows else y.ticks(7 * height // HEIGHT):
        position = float(y.place(np.array([value]))[0])
        at = TOP + high * (1.0 - position / 1000.0)
        grid = Markup('<path d="M{} {:.1f}H{}"/>').format(LEFT, at, WIDTH - RIGHT)
        text = Markup('<text class="y" x="{}" y="{:.1f}">{}</text>')
        parts.append(grid + text.format(LEFT - 5, at + 4, number(value)))
    return parts
