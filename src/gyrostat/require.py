"""Refusals that many parts share: parameters that are no sizes, and parts that check themselves."""

from typing import Any

import numpy as np

from gyrostat.errors import InputError


def require(name: str, value: Any, unit: str = "", *, positive: bool = False) -> None:
    """Refuse a parameter that is negative or not finite.

    Args:
        name: for the message.
        value: one, or one for each run.
        unit: for the message.
        positive: whether zero is refused too.

    Raises:
        InputError: as said.
    """
    every = np.asarray(value, dtype=float)
    bad = ~(np.isfinite(every) & (every >= 0.0)) | (positive & (every == 0.0))
    if np.any(bad):
        least = "above 0" if positive else "of 0 or more"
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
