"""Options in tables of a spec sheet: quantities, shares and counts."""

import math
from collections.abc import Mapping
from dataclasses import field, fields
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import number, quantity, refuse_unknown
from gyrostat.core.units import ascii_number

MOST_SHARE = 0.5
"""Largest share."""


def option(default: float | None, dimension: str, text: str) -> Any:
    """Field of a table: its default, dimension (or "share", "count") and meaning."""
    return field(default=default, metadata={"dimension": dimension, "text": text})


def read_options(
    path: Path, where: str, table: Mapping[str, Any], kind: type[Any], *, required: bool = False
) -> dict[str, float]:
    """Values of a table whose keys are the fields of a class.

    Args:
        path: Path of the file, for the error message.
        where: Name of the table.
        table: Its content.
        kind: Class with fields made by `option`.
        required: Whether a field without default must be there.

    Raises:
        InputError: A key is unknown or missing, or a value is not possible.
    """
    keys = {each.name: each.metadata for each in fields(kind)}
    refuse_unknown(path, f"{where}.", table, tuple(keys))
    values = {}
    for each in fields(kind):
        key, dimension = f"{where}.{each.name}", each.metadata["dimension"]
        if each.name not in table:
            if each.default is None and required:
                raise InputError(f"{path}: key {key}: found none, expected {each.metadata['text']}")
            continue
        values[each.name] = _value(path, key, table[each.name], dimension, each.default)
    return values


def _value(path: Path, key: str, value: object, dimension: str, default: object) -> float:
    """One number of a table: a share, a whole number, or a quantity."""
    if dimension == "share":
        return share(path, key, value)
    if dimension == "count":
        if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= 1000:
            raise InputError(
                f"{path}: key {key}: found {value!r}, expected a whole number 1 to 1000"
            )
        return value
    result = quantity(path, key, value, dimension, positive=default != 0.0)
    if result < 0.0:
        raise InputError(f"{path}: key {key}: found {result:g}, expected 0 or more")
    return result


def share(path: Path, key: str, value: object) -> float:
    """Share as a number or in per cent."""
    found = value
    if isinstance(value, str):
        text = value.rstrip()
        try:
            found = ascii_number(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
        except ValueError:
            found = math.nan
    found = number(path, key, found, positive=False)
    if not 0.0 <= found <= MOST_SHARE:
        raise InputError(f"{path}: key {key}: found {value!r}, expected 0 to {MOST_SHARE:g}")
    return found
