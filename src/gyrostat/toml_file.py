"""TOML files that users write: read, and refused by the key that is wrong."""

import difflib
import math
import sys
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from gyrostat.errors import InputError
from gyrostat.units import parse_quantity

__all__ = ["number", "quantity", "read_toml", "refuse_unknown"]


def read_toml(path: Path, kind: str) -> dict[str, Any]:
    """The content of a file.

    Args:
        path: of the file.
        kind: what it should be, for the message: "a model file".

    Raises:
        InputError: it cannot be read, or is not TOML.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise InputError(f"{path}: found {reason}, expected {kind}") from error
    except (ValueError, RecursionError) as error:
        # not only TOMLDecodeError: Python has its own limits on digits and on nesting
        raise InputError(f"{path}: found invalid TOML ({error}), expected {kind}") from error


def refuse_unknown(path: Path, prefix: str, found: Collection[str], known: Collection[str]) -> None:
    """Refuse a key that nobody reads, and name one that is spelled alike.

    Args:
        path: of the file.
        prefix: of the keys, "wheel." for those of [wheel].
        found: keys in the file.
        known: keys that are read.

    Raises:
        InputError: one is not known.
    """
    for key in found:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f" (did you mean {prefix}{near[0]}?)" if near else ""
            shown = key if key.isprintable() else repr(key)
            raise InputError(
                f"{path}: key {prefix}{shown}: found an unknown key{hint}, expected "
                f"{', '.join(known)}"
            )


def number(path: Path, key: str, value: object, *, positive: bool) -> float:
    """A finite number.

    Args:
        path: of the file.
        key: in full.
        value: as TOML gives it.
        positive: whether it must be above 0.

    Raises:
        InputError: it is none.
    """
    found = math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        found = float(value) if abs(value) <= sys.float_info.max else math.inf
    if not math.isfinite(found) or (positive and found <= 0.0):
        wanted = "a number above 0" if positive else "a finite number"
        raise InputError(f"{path}: key {key}: found {value!r}, expected {wanted}")
    return found


def quantity(path: Path, key: str, value: object, dimension: str, *, positive: bool) -> float:
    """A finite number in SI units, or a text with a unit such as "0.1 N·m".

    Args:
        path: of the file.
        key: in full.
        value: as TOML gives it.
        dimension: key of `gyrostat.units.SI_UNIT`.
        positive: whether it must be above 0.

    Returns:
        The value in SI units.

    Raises:
        InputError: it is none.
    """
    if isinstance(value, str):
        value = parse_quantity(value, dimension, f"{path}: key {key}")
    return number(path, key, value, positive=positive)
