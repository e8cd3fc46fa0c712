"""Parameter validation shared by all parts."""

import math
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError

SMALLEST, LARGEST = 1e-30, 1e30
"""Magnitudes in SI units that a number other than 0 may have: far beyond all that is built, and
such that products of a few of them neither overflow nor vanish."""
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-9, 1e9
"""s: control periods and integration steps outside of this range are a slip of units."""
MOST_PERIODS = 100_000_000
"""Control periods in a run, and steps in one of them: more are a slip of units."""
LARGEST_SEED = 2**63 - 1


def magnitude(where: str, value: float, unit: str = "", *, shown: object = None) -> float:
    """Give a number back, or refuse it.

    Args:
        where: For the message.
        value: SI.
        unit: For the message.
        shown: As the user wrote it, for the message.

    Raises:
        InputError: It is not finite, or neither 0 nor of a magnitude that float64 can compute with.
    """
    if not math.isfinite(value) or (value != 0.0 and not SMALLEST <= abs(value) <= LARGEST):
        found = value if shown is None else shown
        raise InputError(
            f"{where}: found {found}, expected a finite number, 0 or of magnitude {SMALLEST:g} to "
            f"{LARGEST:g} {unit}".rstrip()
        )
    return value


def check_seed(seed: int) -> None:
    """Refuse a seed that the random generators cannot take.

    Raises:
        InputError: It is negative or above `LARGEST_SEED`.
    """
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed: found {seed}, expected 0 to {LARGEST_SEED}")


def require(name: str, value: Any, unit: str = "", *, positive: bool = False) -> None:
    """Refuse a parameter that is negative, not finite or of no physical magnitude.

    Args:
        name: for the message.
        value: one, or one for each run.
        unit: for the message.
        positive: whether zero is refused too.

    Raises:
        InputError: as said, or a size above `LARGEST`, or, where it must be positive, below
            `SMALLEST`.
    """
    every = np.asarray(value, dtype=float)
    sound = (every >= SMALLEST) & (every <= LARGEST)
    bad = ~(sound if positive else sound | (every == 0.0))  # comparisons with NaN are false
    if np.any(bad):
        found = every[bad].flat[0]
        wanted = f"a finite value {'above 0' if positive else 'of 0 or more'} {unit}".rstrip()
        if np.isfinite(found) and found > 0.0:
            wanted = f"{SMALLEST:g} to {LARGEST:g} {unit}".rstrip()
        raise InputError(f"{name}: found {found:g}, expected {wanted}")


def require_period(name: str, period: float) -> None:
    """Refuse a control period or integration step that no loop has.

    Args:
        name: for the message.
        period: s.

    Raises:
        InputError: not within `SHORTEST_PERIOD` to `LONGEST_PERIOD`.
    """
    if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        raise InputError(
            f"{name}: found {period:g} s, expected {SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s"
        )


def check_parts(*parts: Any) -> None:
    """Let every part that has a `check()` refuse its parameters; a user's own need not have one.

    Raises:
        InputError: a part refuses.
    """
    for part in parts:
        check = getattr(part, "check", None)
        if check is not None:
            check()


def check_period(period: float, *parts: Any) -> None:
    """Let every part that has a `check_period(period)` refuse a control period, s.

    Raises:
        InputError: a part refuses.
    """
    for part in parts:
        check = getattr(part, "check_period", None)
        if check is not None:
            check(period)
