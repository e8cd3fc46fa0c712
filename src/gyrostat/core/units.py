"""Units: conversion to SI and parsing of quantities."""

import difflib
import math
import re
import unicodedata
from collections.abc import Sequence
from typing import overload

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.unit_table import RPM, TABLE, Unit
from gyrostat.core.validation import magnitude

__all__ = [
    "QUANTITY",
    "RPM",
    "SI_UNIT",
    "Unit",
    "dimension_of",
    "find_unit",
    "known_unit",
    "parse_quantity",
    "parse_uncertain",
    "si_unit",
    "speed_power",
    "to_si",
    "unit_of",
]

SI_UNIT: dict[str, str] = {dimension: rows[0][0].symbol for dimension, rows in TABLE.items()}
"""Unit of each dimension, inside and in outputs (temperature: °C)."""


def _normalised(text: str) -> str:
    """Normalise the spelling of a unit: 'N.m', 'N m', 'N*m' -> 'N·m'; 'm²', 'm^2' -> 'm2'."""
    text = unicodedata.normalize("NFKC", text).strip()  # ² -> 2, micro sign -> Greek mu
    text = text.replace("μ", "u").replace("−", "-").replace("**", "").replace("^", "")
    text = re.sub(r"\s*/\s*|\s+per\s+", "/", text)
    return re.sub(r"[\s.·⋅∙•*×]+", "·", text).rstrip("·")


def si_unit(dimension: str) -> str:
    """SI unit of a dimension; a dimension that `SI_UNIT` lacks is the text of its SI unit."""
    return SI_UNIT.get(dimension, dimension)


_PER_SPEED = re.compile(r"N·m(?:·s(-?[0-9.]*)/rad(-?[0-9.]*))?")
"""Unit of a torque over a power of a speed."""


def speed_power(unit: str) -> float | None:
    """Power k of the unit N·m/(rad/s)^k of a torque coefficient; None for any other unit."""
    match = _PER_SPEED.fullmatch(_normalised(unit))
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
    spelling = _normalised(text)
    of_unit = {_normalised(unit): dimension for dimension, unit in SI_UNIT.items()}
    if text in SI_UNIT or spelling in of_unit:
        return text if text in SI_UNIT else of_unit[spelling]
    if not all(map(_SYMBOL.fullmatch, re.split("[·/()]+", spelling.strip("()")))):
        raise InputError(
            f"{where}: found {text[:40]!r}, expected an SI unit such as N·m·s²/rad², or one of "
            f"{', '.join(SI_UNIT)}"
        )
    return text


def _spellings() -> tuple[dict[str, dict[str, Unit]], dict[str, dict[str, Unit]]]:
    """Dimension -> normalised spelling -> unit: exact spellings, and case-insensitive ones."""
    exact: dict[str, dict[str, Unit]] = {}
    folded: dict[str, dict[str, Unit]] = {}
    for dimension, rows in TABLE.items():
        exact[dimension], folded[dimension] = {}, {}
        for unit, strict, free in rows:
            for spelling in (_normalised(text) for text in (unit.symbol, *strict, *free)):
                exact[dimension][spelling] = exact[dimension][spelling.replace("·", "")] = unit
            for spelling in (_normalised(text).casefold() for text in free):
                folded[dimension][spelling] = folded[dimension][spelling.replace("·", "")] = unit
    return exact, folded


_EXACT, _FOLDED = _spellings()


def known_unit(text: str, dimension: str) -> Unit | None:
    """Unit of a dimension with the given spelling, or None; see `si_unit` for the dimension."""
    spelling = _normalised(text)
    if dimension not in TABLE:
        return Unit(dimension) if spelling == _normalised(dimension) else None
    return _EXACT[dimension].get(spelling) or _FOLDED[dimension].get(spelling.casefold())


def _symbols(dimension: str) -> dict[str, None]:
    """Symbols of the units of a dimension, in order and without repetition."""
    rows = TABLE.get(dimension, ())
    return dict.fromkeys(row[0].symbol for row in rows) or {dimension: None}


def find_unit(text: str, dimension: str, where: str) -> Unit:
    """Find the unit of a dimension by its spelling.

    Args:
        text: Spelling of the unit.
        dimension: Key of `SI_UNIT`.
        where: Place to name in the error message.

    Raises:
        InputError: No unit of this dimension has this spelling.
    """
    unit = known_unit(text, dimension)
    if unit is not None:
        return unit
    symbols = {symbol.casefold(): symbol for symbol in _symbols(dimension)}
    near = difflib.get_close_matches(text.strip().casefold(), symbols, n=1)
    raise InputError(
        f"{where}: found unit {text[:40]!r}, expected a unit of {dimension.replace('_', ' ')}: "
        + ", ".join(symbols.values())
        + (f"; did you mean {symbols[near[0]]!r}?" if near else "")
    )


@overload
def to_si(value: float, unit: str, dimension: str) -> float: ...
@overload
def to_si(value: Sequence[float] | NDArray, unit: str, dimension: str) -> NDArray[np.float64]: ...
def to_si(value, unit, dimension):
    """Convert a number or an array to SI.

    Args:
        value: Finite number or array (any shape), in `unit`.
        unit: Spelling of the unit.
        dimension: Key of `SI_UNIT`.

    Returns:
        The value in `SI_UNIT[dimension]`: a float for a number, otherwise a float64 array.

    Raises:
        InputError: The unit is unknown, or a value is not finite before or after conversion.
    """
    found = find_unit(unit, dimension, dimension)
    with np.errstate(over="ignore"):
        converted = found.to_si(np.asarray(value, dtype=np.float64))
    if not np.all(np.isfinite(converted)):
        raise InputError(f"{dimension}: found NaN or an infinite value, expected finite numbers")
    return float(converted) if converted.ndim == 0 else converted


QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(.*)", re.ASCII | re.DOTALL)
"""Number, then the text of its unit."""


def parse_quantity(text: str, dimension: str, where: str) -> float:
    """Parse a quantity such as '4rpm', '4 rpm' or '0.418879' (a bare number is in SI).

    Args:
        text: Number with its unit; without a unit the number is in SI.
        dimension: Key of `SI_UNIT`.
        where: Place to name in the error message, such as '--hold stribeck_speed'.

    Returns:
        The value in `SI_UNIT[dimension]`.

    Raises:
        InputError: Not a number, a magnitude outside the accepted range, or an unknown unit.
    """
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(
            f"{where}: found {text[:40]!r}, expected a number in {si_unit(dimension)} "
            f"or with a unit: {', '.join(_symbols(dimension))}"
        )
    unit = match[2].strip() or si_unit(dimension)
    value = find_unit(unit, dimension, f"{where} {text[:40]!r}").to_si(float(match[1]))
    return magnitude(where, value, si_unit(dimension), shown=repr(text[:40]))


def unit_of(text: str, dimension: str, where: str) -> Unit:
    """Unit in which a quantity such as '4 rpm' is given; see `parse_quantity`."""
    parse_quantity(text, dimension, where)
    match = QUANTITY.fullmatch(text)
    assert match is not None
    return find_unit(match[2].strip() or SI_UNIT[dimension], dimension, where)


_PLUS_MINUS = re.compile(r"\+/-|\+-|±")


def parse_uncertain(text: str, dimension: str | None, where: str) -> tuple[float | None, float]:
    """Parse a value with its tolerance: '1.5e-3 +- 1 %', '15 kg·cm² ± 0.2 kg·cm²', '+- 1 %'.

    Args:
        text: A quantity, a tolerance after '+-', '+/-' or '±' (in per cent or in a unit of the
            dimension), or both.
        dimension: Key of `SI_UNIT`; None for a dimensionless factor.
        where: Place to name in the error message, such as '--inertia'.

    Returns:
        The value in SI (None if only a tolerance is given), and the tolerance as one standard
        deviation relative to the value (0 if none is given).

    Raises:
        InputError: Not a quantity; a tolerance that is negative or not a number; an absolute
            tolerance without a value or with a value of zero.
    """

    def quantity(part: str) -> float:
        if dimension is not None:
            return parse_quantity(part, dimension, where)
        match = QUANTITY.fullmatch(part)
        if match is None or match[2].strip():
            raise InputError(f"{where}: found {part.strip()[:40]!r}, expected a factor or '+- 1 %'")
        return float(match[1])

    parts = _PLUS_MINUS.split(text)
    if len(parts) > 2:
        raise InputError(f"{where}: found {text[:40]!r}, expected one tolerance, as '+- 1 %'")
    value = quantity(parts[0]) if parts[0].strip() or len(parts) == 1 else None
    if len(parts) == 1:
        return value, 0.0
    amount = parts[1].strip()
    percent = amount.endswith("%")
    match = QUANTITY.fullmatch(amount.removesuffix("%"))
    if match is None or (percent and match[2].strip()):
        raise InputError(f"{where}: found tolerance {amount[:40]!r}, expected one such as '1 %'")
    sigma = float(match[1]) / 100.0 if percent else quantity(amount)
    if not percent:
        size = 1.0 if dimension is None and value is None else abs(value or 0.0)
        if size == 0.0:
            raise InputError(f"{where}: found tolerance {amount[:40]!r}, expected a share in %")
        sigma /= size
    if not (math.isfinite(sigma) and sigma >= 0.0):
        raise InputError(f"{where}: found tolerance {amount[:40]!r}, expected 0 or more")
    return value, sigma
