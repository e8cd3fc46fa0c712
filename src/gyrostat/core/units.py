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
from gyrostat.core.sexagesimal import sexagesimal
from gyrostat.core.unit_table import RPM, TABLE, Unit
from gyrostat.core.validation import magnitude

__all__ = [
    "QUANTITY",
    "RPM",
    "SI_UNIT",
    "Unit",
    "find_unit",
    "known_unit",
    "normalised",
    "parse_quantity",
    "parse_uncertain",
    "si_unit",
    "to_si",
    "unit_of",
]

SI_UNIT: dict[str, str] = {dimension: rows[0][0].symbol for dimension, rows in TABLE.items()}
"""Unit of each dimension, inside and in outputs (temperature: °C)."""
PPM = ("1", Unit("ppm", 1e-6))
"""Unit of numbers without dimension, such as scale factor errors of data sheets."""
MOST_LISTED = 8
"""Largest number of units that an error message lists."""


_ROOT = re.compile(r"(?:√|\b(?i:sqrt|root|rt))[\s·-]*[({]?\s*([A-Za-z]+)\s*[)}]?")
_POWER = re.compile(
    r"([A-Za-z]+)\s*(?:\^|\*\*)\s*[({]?\s*(-?)\s*(1/2|0?\.5|3/2|1\.5)\s*[)}]?", re.ASCII
)


_PARTS = re.compile("([/·])")


def _as_root(power: re.Match[str]) -> str:
    name, minus, exponent = power.groups()
    root = f"√{name}" if exponent in ("1/2", "0.5", ".5") else f"{name}√{name}"
    return f"/{root}" if minus else root


def normalised(text: str) -> str:
    """Normalise the spelling of a unit: 'N.m', 'N m' -> 'N·m'; 'm²' -> 'm2'; 'sqrt(h)' -> '√h'."""
    text = re.sub("[º˚]", "°", text)  # as copied from data sheets
    text = unicodedata.normalize("NFKC", text).strip()  # ² -> 2, micro sign -> Greek mu
    text = text.replace("μ", "u").replace("−", "-").replace("⁄", "/")
    text = _POWER.sub(_as_root, _ROOT.sub(r"√\1", text))
    text = text.replace("**", "").replace("^", "")
    text = re.sub(r"\bdps\b", "deg/s", re.sub(r"\bmdps\b", "mdeg/s", text))
    text = re.sub(r"\s+per\s+", "/", text)
    text = re.sub(r"[\s.·⋅∙•*×]+", "·", text).rstrip("·")
    text = re.sub(r"·*/·*", "/", re.sub(r"·(√?[A-Za-z]+)-1(?!\d)", r"/\1", text))
    return re.sub(r"^\(([^()]+)\)(?=/)", r"\1", text)  # (deg/h)/√Hz


def si_unit(dimension: str) -> str:
    """SI unit of a dimension; a dimension that `SI_UNIT` lacks is the text of its SI unit."""
    return SI_UNIT.get(dimension, dimension)


def _spellings() -> tuple[dict[str, dict[str, Unit]], dict[str, dict[str, Unit]]]:
    """Dimension -> normalised spelling -> unit: exact spellings, and case-insensitive ones."""
    exact: dict[str, dict[str, Unit]] = {}
    folded: dict[str, dict[str, Unit]] = {}
    for dimension, rows in TABLE.items():
        exact[dimension], folded[dimension] = {}, {}
        for unit, strict, free in rows:
            for spelling in (normalised(text) for text in (unit.symbol, *strict, *free)):
                exact[dimension][spelling] = exact[dimension][spelling.replace("·", "")] = unit
            for spelling in (normalised(text).casefold() for text in free):
                folded[dimension][spelling] = folded[dimension][spelling.replace("·", "")] = unit
    return exact, folded


_EXACT, _FOLDED = _spellings()


def known_unit(text: str, dimension: str) -> Unit | None:
    """Unit of a dimension with the given spelling, or None; see `si_unit` for the dimension."""
    spelling = normalised(text)
    if dimension == PPM[0] and spelling == PPM[1].symbol:
        return PPM[1]
    if dimension not in TABLE:
        return Unit(dimension) if spelling == normalised(dimension) else None
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
    dimensions = [name for name in TABLE if known_unit(text, name) is not None]
    remark = f"; {text[:40]!r} is a unit of {_words(dimensions[0])}" if dimensions else ""
    raise InputError(
        f"{where}: found unit {text[:40]!r}, expected a unit of {_words(dimension)}: "
        f"{_listed(dimension)}{remark or _suggestion(text, dimension)}"
    )


def _words(dimension: str) -> str:
    return dimension.replace("_", " ")


def _listed(dimension: str) -> str:
    """Most common units of a dimension, for an error message."""
    symbols = [*_symbols(dimension)]
    return ", ".join([*symbols[:MOST_LISTED], *(["..."] if len(symbols) > MOST_LISTED else [])])


def _suggestion(text: str, dimension: str) -> str:
    """Suggest a unit for a misspelt one, with its size; empty if none differs by a misprint only.

    A part of a unit with another meaning is not a misprint: deg/day is not deg/s, kN is not N.
    """
    rows = {row[0].symbol.casefold(): row[0] for row in reversed(TABLE.get(dimension, ()))}
    parts = _PARTS.split(normalised(text).casefold())
    for near in difflib.get_close_matches(text.strip().casefold(), rows, n=3):
        near_parts = _PARTS.split(normalised(near).casefold())
        if len(parts) == len(near_parts) and all(map(_is_misprint, parts, near_parts)):
            unit = rows[near]
            plain = unit.factor == 1.0 or unit.offset
            size = "" if plain else f" ({unit.factor:.4g} {SI_UNIT[dimension]})"
            return f"; did you mean {unit.symbol!r}{size}?"
    return ""


def _is_misprint(part: str, target: str) -> bool:
    """Whether a part of a unit is another one with a misprint; a prefix is none."""
    is_prefixed = part[1:] == target or target[1:] == part
    return part == target or (
        not is_prefixed
        and min(len(part), len(target)) > 1
        and difflib.SequenceMatcher(None, part, target).ratio() > 0.6
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
    source_unit = find_unit(unit, dimension, dimension)
    with np.errstate(over="ignore"):
        converted = source_unit.to_si(np.asarray(value, dtype=np.float64))
    if not np.all(np.isfinite(converted)):
        raise InputError(f"{dimension}: found NaN or an infinite value, expected finite numbers")
    return float(converted) if converted.ndim == 0 else converted


WARMEST = 200.0
"""Largest temperature that is read as °C without a unit."""
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
    if dimension == "angle" and (angle := sexagesimal(text, where)) is not None:
        return angle
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(
            f"{where}: found {text[:40]!r}, expected a number in {si_unit(dimension)} "
            f"or with a unit: {_listed(dimension)}"
        )
    unit = match[2].strip() or si_unit(dimension)
    if dimension == "temperature" and not match[2].strip() and float(match[1]) > WARMEST:
        raise InputError(
            f"{where}: found {text[:40]!r} without a unit, expected at most {WARMEST:g} °C, or a "
            "unit such as K"
        )
    value = find_unit(unit, dimension, f"{where} {text[:40]!r}").to_si(float(match[1]))
    return magnitude(where, value, si_unit(dimension), shown=repr(text[:40]))


def unit_of(text: str, dimension: str, where: str) -> Unit:
    """Unit in which a quantity such as '4 rpm' is given; see `parse_quantity`."""
    parse_quantity(text, dimension, where)
    match = QUANTITY.fullmatch(text)
    assert match is not None
    return find_unit(match[2].strip() or SI_UNIT[dimension], dimension, where)


def ascii_number(text: str) -> float:
    """Number without a unit; unlike `float`, refuse '1_000' and digits of other scripts.

    Raises:
        ValueError: The text is no such number.
    """
    return float(text if text.isascii() and "_" not in text else "")


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
