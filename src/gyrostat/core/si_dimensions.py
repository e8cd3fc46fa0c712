"""Dimensions that are named by their SI unit, such as those of a user's parameters."""

import re

from gyrostat.core.errors import InputError
from gyrostat.core.units import SI_UNIT, normalised

_PER_SPEED = re.compile(r"N·m(?:·s(-?[0-9.]*)/rad(-?[0-9.]*))?")
"""Unit of a torque over a power of a speed."""


def speed_power(unit: str) -> float | None:
    """Power k of the unit N·m/(rad/s)^k of a torque coefficient; None for any other unit."""
    match = _PER_SPEED.fullmatch(normalised(unit))
    if match is None or match[1] != match[2]:
        return None
    return 0.0 if match[1] is None else float(match[1] or 1.0)


_SYMBOL = re.compile(r"(?:1|rad|kg|mol|Hz|[msNAKWVJT])-?[0-9.]*")
"""SI symbol with an exponent."""


def dimension_of(text: str, where: str) -> str:
    """Dimension of a quantity, from the name of the dimension or from its SI unit.

    Args:
        text: Key of `SI_UNIT`, or an SI unit such as "N·m·s²/rad²".
        where: Place to name in the error message.

    Raises:
        InputError: The text is neither.
    """
    spelling = normalised(text)
    of_unit = {normalised(unit): dimension for dimension, unit in SI_UNIT.items()}
    if text in SI_UNIT or spelling in of_unit:
        return text if text in SI_UNIT else of_unit[spelling]
    if not all(map(_SYMBOL.fullmatch, re.split("[·/()]+", spelling.strip("()")))):
        raise InputError(
            f"{where}: found {text[:40]!r}, expected an SI unit such as N·m·s²/rad², or one of "
            f"{', '.join(SI_UNIT)}"
        )
    return text
