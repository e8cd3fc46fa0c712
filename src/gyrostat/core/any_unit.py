"""Numbers with a unit of any dimension."""

import math

from gyrostat.core.errors import InputError
from gyrostat.core.units import QUANTITY, SI_UNIT, Unit, known_unit, normalised
from gyrostat.core.validation import magnitude

ANY_UNIT = "any"
"""Dimension of a number whose unit is not known: text is converted to SI by its own unit."""


def parse_any(text: str, where: str) -> float:
    """Parse a number with any unit, also a quotient such as "20 mN·m/deg", and convert it to SI.

    Args:
        text: Number with or without a unit.
        where: Place to name in the error message.

    Raises:
        InputError: Not a number, an unknown unit, or a magnitude outside the accepted range.
    """
    match = QUANTITY.fullmatch(text)
    spelling = None if match is None else match[2].strip()
    unit = Unit("") if spelling == "" else _any_unit(spelling or "?")
    if match is None or unit is None:
        raise InputError(
            f"{where}: found {text[:40]!r}, expected a number in SI units or with a unit such as "
            "mN·m or mN·m/deg"
        )
    return magnitude(where, unit.to_si(float(match[1])), shown=repr(text[:40]))


def _any_unit(text: str) -> Unit | None:
    """Unit of any dimension, or a quotient of units; None if it is unknown or ambiguous."""
    text = normalised(text)
    units = {unit for dimension in SI_UNIT if (unit := known_unit(text, dimension)) is not None}
    # N·m·s is a momentum and a viscous coefficient
    if len({(unit.factor, unit.offset) for unit in units}) == 1:
        return units.pop()
    if text.startswith("√"):
        inner = _any_unit(text[1:])
        return None if inner is None or inner.offset else Unit(text, math.sqrt(inner.factor))
    above, slash, below = text.rpartition("/")
    if below.endswith(")") and "/(" in text:
        above, slash, below = text[:-1].partition("/(")
    if not slash:
        return None
    upper, lower = Unit("1") if above.strip() == "1" else _any_unit(above), _any_unit(below)
    if upper is None or lower is None or upper.offset or lower.offset:
        return None
    return Unit(text, upper.factor / lower.factor)
