"""Numbers and tables as text."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def plain(value: float, digits: int = 4) -> str:
    """Format a number with significant digits, with a power of ten where zeros would hide it."""
    return f"{value:.{digits}g}"


def triple(values: Sequence[float] | NDArray[np.float64], digits: int = 4) -> str:
    """Format numbers separated by commas, in the form that the command line accepts."""
    # values that are zero apart from rounding errors are shown as zero
    return ", ".join(f"{value:.{digits}g}" for value in np.round(values, 12) + 0.0)


def or_none(value: float) -> float | None:
    """Replace a number that is not finite by None, for JSON."""
    return value if math.isfinite(value) else None


def measured(value: float, sigma: float) -> str:
    """Format a value with its standard deviation, rounded to two digits of the latter."""
    if not (math.isfinite(value) and math.isfinite(sigma)) or sigma <= 0.0:
        return plain(value)
    top = max(abs(value), sigma)
    power = math.floor(math.log10(top))
    power = 0 if -3 <= power <= 3 else 3 * (power // 3)
    decimals = max(0, 1 - math.floor(math.log10(sigma)) + power)
    scaled = f"{value / 10.0**power:.{decimals}f} ± {sigma / 10.0**power:.{decimals}f}"
    return scaled if power == 0 else f"({scaled})e{power:+03d}"


def shortened(parts: Sequence[str], most: int) -> str:
    """Parts separated by commas; of more than a number, the first ones and how many follow."""
    listed = [*parts[:most], *([f"{len(parts) - most} more"] if len(parts) > most else [])]
    return ", ".join(listed)


def aligned(rows: Sequence[Sequence[str]], header: Sequence[str]) -> list[str]:
    """Align a table in columns, for a terminal."""
    every = [list(header), *[list(row) for row in rows]]
    widths = [max(len(row[k]) for row in every) for k in range(len(header))]
    return [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in every
    ]
