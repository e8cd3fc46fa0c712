"""Validation of parameters, shared by all rooms."""

import math
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError

SMALLEST, LARGEST = 1e-30, 1e30
"""Smallest and largest accepted magnitude of a nonzero number in SI units. The range is far wider
than any physical parameter, and products of a few such numbers neither overflow nor vanish."""
SHORTEST_PERIOD, LONGEST_PERIOD = 1e-9, 1e9
"""Accepted range of control periods and integration steps, s; outside it a unit is wrong."""
MOST_PERIODS = 100_000_000
"""Largest number of control periods in a run, and of steps in a period; above it, a unit error."""
LARGEST_SEED = 2**63 - 1


def magnitude(where: str, value: float, unit: str = "", *, shown: object = None) -> float:
    """Return a number after checking its magnitude.

    Args:
        where: Place to name in the error message.
        value: Number in SI units.
        unit: Unit to name in the error message.
        shown: The number as the user wrote it, for the error message.

    Raises:
        InputError: The number is not finite, or is nonzero and outside the range of magnitudes.
    """
    if not math.isfinite(value) or (value != 0.0 and not SMALLEST <= abs(value) <= LARGEST):
        found = value if shown is None else shown
        raise InputError(
            f"{where}: found {found}, expected a finite number, 0 or of magnitude {SMALLEST:g} to "
            f"{LARGEST:g} {unit}".rstrip()
        )
    return value


def check_seed(seed: int) -> None:
    """Validate the seed of a random generator.

    Raises:
        InputError: The seed is negative or above `LARGEST_SEED`.
    """
    if not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"seed: found {seed}, expected 0 to {LARGEST_SEED}")


def require(name: str, value: Any, unit: str = "", *, positive: bool = False) -> None:
    """Validate a parameter: finite, not negative and of an accepted magnitude.

    Args:
        name: Name for the error message.
        value: One number, or one for each run.
        unit: Unit to name in the error message.
        positive: Whether zero is refused too.

    Raises:
        InputError: A number is negative, not finite, above `LARGEST` or between 0 and `SMALLEST`,
            or is zero although it must be positive.
    """
    every = np.asarray(value, dtype=float)
    sound = (every >= SMALLEST) & (every <= LARGEST)
    bad = ~(sound if positive else sound | (every == 0.0))  # comparisons with NaN are false
    if np.any(bad):
        found = every[bad].flat[0]
        expected = f"a finite value {'above 0' if positive else 'of 0 or more'} {unit}".rstrip()
        if np.isfinite(found) and found > 0.0:
            expected = f"{SMALLEST:g} to {LARGEST:g} {unit}".rstrip()
        raise InputError(f"{name}: found {found:g}, expected {expected}")


def require_period(name: str, period: float) -> None:
    """Validate a control period or integration step.

    Args:
        name: Name for the error message.
        period: Period, s.

    Raises:
        InputError: The period is outside `SHORTEST_PERIOD` to `LONGEST_PERIOD`.
    """
    if not SHORTEST_PERIOD <= period <= LONGEST_PERIOD:
        raise InputError(
            f"{name}: found {period:g} s, expected {SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s"
        )


def check_parts(*parts: Any) -> None:
    """Call `check()` of every part that has one; user-defined parts need not have one.

    Raises:
        InputError: A part refuses its parameters.
    """
    for part in parts:
        check = getattr(part, "check", None)
        if check is not None:
            check()


def check_period(period: float, *parts: Any) -> None:
    """Call `check_period(period)`, period in s, of every part that has this method.

    Raises:
        InputError: A part refuses the period.
    """
    for part in parts:
        check = getattr(part, "check_period", None)
        if check is not None:
            check(period)
