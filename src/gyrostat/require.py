"""Refusals that many parts share: parameters that are no sizes, and parts that check themselves."""

from typing import Any

import numpy as np

from gyrostat.errors import InputError

LARGEST = 1e30
"""Size beyond which a number in SI units is a slip: products of a few such numbers overflow."""
SMALLEST = 1e-30
"""Size below which a number that must be positive is a slip: its inverse is beyond `LARGEST`."""
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-9, 1e9
"""s: control periods and integration steps outside of this range are a slip of units."""

MOST_PERIODS = 100_000_000
"""Control periods in a run, and steps in one of them: more are a slip of units."""


def require(name: str, value: Any, unit: str = "", *, positive: bool = False) -> None:
    """Refuse a parameter that is negative, not finite or of absurd size.

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
    # comparisons with NaN are false
    good = (every >= (SMALLEST if positive else 0.0)) & (every <= LARGEST)
    if not np.all(good):
        found = every[~good].flat[0]
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
