"""Read TOML files; errors name the key."""

import difflib
import math
import stat
import sys
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.units import parse_quantity
from gyrostat.core.validation import magnitude

__all__ = ["name_text", "number", "quantity", "read_text", "read_toml", "refuse_unknown"]


LONGEST_NAME = 100
LARGEST_FILE = 10_000_000
"""Bytes: hand-written files are thousands of times smaller."""


def read_text(path: Path, kind: str, largest: int = LARGEST_FILE) -> str:
    """Text of a file that a user names, which may be anything.

    Args:
        path: Of the file.
        kind: What it should be, for the message: "a model file".
        largest: Bytes at most.

    Raises:
        InputError: It is no regular file, cannot be read, is too large or is not UTF-8.
    """
    try:
        # a pipe or device is not opened: reading it may never end
        status = path.stat()
        if stat.S_ISREG(status.st_mode):
            with path.open("rb") as stream:
                content = stream.read(largest + 1)
            if len(content) <= largest:
                return content.decode("utf-8-sig")
            raise InputError(f"{path}: found more than {largest:.3g} bytes, expected {kind}")
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise InputError(f"{path}: found {reason}, expected {kind}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: found no UTF-8 text ({error.reason}), expected {kind}") from None
    except ValueError as error:  # a zero byte in the name
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: found {error}, expected {kind}") from None
    what = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or device"
    raise InputError(f"{path}: found {what}, expected {kind}")


def read_toml(path: Path, kind: str) -> dict[str, Any]:
    """The content of a file.

    Args:
        path: of the file.
        kind: what it should be, for the message: "a model file".

    Raises:
        InputError: it cannot be read, or is not TOML.
    """
    try:
        return tomllib.loads(read_text(path, kind))
    except InputError:
        raise
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


def name_text(path: Path, key: str, value: object) -> str:
    """A name that figures and tables show: printable and not long.

    Args:
        path: Of the file.
        key: In full.
        value: As TOML gives it.

    Raises:
        InputError: It is none.
    """
    if not isinstance(value, str) or not value.isprintable() or len(value) > LONGEST_NAME:
        found = repr(value)
        raise InputError(
            f"{path}: key {key}: found {found if len(found) <= 60 else found[:57] + '...'}, "
            f"expected a text of at most {LONGEST_NAME} printable characters"
        )
    return value


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
    return magnitude(f"{path}: key {key}", found, shown=value)


def quantity(path: Path, key: str, value: object, dimension: str, *, positive: bool) -> float:
    """A finite number in SI units, or a text with a unit such as "0.1 N·m".

    Args:
        path: of the file.
        key: in full.
        value: as TOML gives it.
        dimension: key of `gyrostat.core.units.SI_UNIT`.
        positive: whether it must be above 0.

    Returns:
        The value in SI units.

    Raises:
        InputError: it is none.
    """
    if isinstance(value, str):
        value = parse_quantity(value, dimension, f"{path}: key {key}")
    return number(path, key, value, positive=positive)
