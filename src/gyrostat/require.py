"""Checks that many parts share: magnitudes and signs, seeds, and the checks of the parts."""

import math
from typing import Any

import numpy as np

from gyrostat.errors import InputError

SMALLEST, LARGEST = 1e-30, 1e30
"""Magnitudes in SI units that a number other than 0 may have: far beyond all that is built, and
such that products of a few of them neither overflow nor vanish."""
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
        InputError: as said.
    """
    every = np.asarray(value, dtype=float)
    sound = (every >= SMALLEST) & (every <= LARGEST)
    bad = ~(sound if positive else sound | (every == 0.0))
    if np.any(bad):
        least = f"above 0 ({SMALLEST:g} to {LARGEST:g})" if positive else "of 0 or more"
        raise InputError(
            f"{name}: found {every[bad].flat[0]:g}, expected a finite value {least} {unit}".rstrip()
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
