"""Reading of TOML files, with error messages that name the file and the key; quoted texts."""

import difflib
import json
import math
import stat
import sys
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import parse_quantity
from gyrostat.core.validation import magnitude

__all__ = [
    "described",
    "direction",
    "inertia_matrix",
    "name_text",
    "number",
    "quantity",
    "quoted",
    "read_content",
    "read_text",
    "read_toml",
    "refuse_unknown",
    "three",
]


LONGEST_NAME = 100
LARGEST_FILE = 10_000_000
"""Largest file that is read, bytes. Hand-written files are thousands of times smaller."""


def read_text(path: Path, kind: str, largest: int = LARGEST_FILE) -> str:
    """Read the text of a file that the user names.

    Args:
        path: Path of the file.
        kind: Kind of file expected, for the error message: "a model file".
        largest: Largest size accepted, bytes.

    Raises:
        InputError: The file is not a regular file, cannot be read, is too large or is not UTF-8.
    """
    try:
        return read_content(path, kind, largest).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: found no UTF-8 text ({error.reason}), expected {kind}") from None


def read_content(path: Path, kind: str, largest: int) -> bytes:
    """Read the bytes of a file that the user names; see `read_text`.

    Raises:
        InputError: The file is not a regular file, cannot be read or is too large.
    """
    try:
        # a pipe or device is not opened: reading from it may block forever
        status = path.stat()
        if stat.S_ISREG(status.st_mode):
            with path.open("rb") as stream:
                content = stream.read(largest + 1)
            if len(content) <= largest:
                return content
            raise InputError(f"{path}: found more than {largest:.3g} bytes, expected {kind}")
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise InputError(f"{path}: found {reason}, expected {kind}") from None
    except ValueError as error:  # a zero byte in the name
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: found {error}, expected {kind}") from None
    file_type = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or device"
    raise InputError(f"{path}: found {file_type}, expected {kind}")


KINDS = {
    "body": "a spacecraft file",
    "friction": "a model of a wheel",
    "run": "a scenario",
    "telemetry": "a file of the wheels of a spacecraft",
}
"""Key -> the only kind of file that has it."""


def read_toml(path: Path, kind: str) -> dict[str, Any]:
    """Read a TOML file.

    Args:
        path: Path of the file.
        kind: Kind of file expected, for the error message: "a model file".

    Raises:
        InputError: The file cannot be read or is not TOML.
    """
    try:
        return tomllib.loads(read_text(path, kind))
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        # not only TOMLDecodeError: Python limits the number of digits and the nesting depth
        raise InputError(f"{path}: found invalid TOML ({error}), expected {kind}") from error


def refuse_unknown(path: Path, prefix: str, found: Collection[str], known: Collection[str]) -> None:
    """Reject unknown keys; name the kind of file that has them, or the key of similar spelling.

    Args:
        path: Path of the file, for the error message.
        prefix: Prefix of the keys in the message: "wheel." for keys of the table [wheel].
        found: Keys in the file.
        known: Keys that are allowed.

    Raises:
        InputError: A key is unknown.
    """
    kinds = [key for key in found if key in KINDS and not prefix]
    others = [] if any(key in known for key in kinds) else [KINDS[key] for key in kinds]
    for key in found:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f" (did you mean {prefix}{near[0]}?)" if near else ""
            hint = f"; this is {others[0]}" if others else hint
            name = key if key.isprintable() else repr(key)
            raise InputError(
                f"{path}: key {prefix}{name}: found an unknown key{hint}, expected "
                f"{', '.join(known)}"
            )


def name_text(path: Path, key: str, value: object) -> str:
    """Check a name that figures and tables show: printable and of limited length.

    Args:
        path: Path of the file, for the error message.
        key: Full key, for the error message.
        value: Value from the TOML file.

    Raises:
        InputError: The value is not such a name.
    """
    if not isinstance(value, str) or not value.isprintable() or len(value) > LONGEST_NAME:
        text = repr(value)
        raise InputError(
            f"{path}: key {key}: found {text if len(text) <= 60 else text[:57] + '...'}, "
            f"expected a text of at most {LONGEST_NAME} printable characters"
        )
    return value


def number(path: Path, key: str, value: object, *, positive: bool) -> float:
    """Check a finite number.

    Args:
        path: Path of the file, for the error message.
        key: Full key, for the error message.
        value: Value from the TOML file.
        positive: Whether the number must be greater than zero.

    Raises:
        InputError: The value is not such a number.
    """
    result = math.nan
    if isinstance(value, int | float) and not isinstance(value, bool):
        result = float(value) if abs(value) <= sys.float_info.max else math.inf
    if not math.isfinite(result) or (positive and result <= 0.0):
        expected = "a number above 0" if positive else "a finite number"
        raise InputError(f"{path}: key {key}: found {value!r}, expected {expected}")
    return magnitude(f"{path}: key {key}", result, shown=value)


def quantity(path: Path, key: str, value: object, dimension: str, *, positive: bool) -> float:
    """Convert a number in SI units, or a text with a unit such as "0.1 N·m", to a number in SI.

    Args:
        path: Path of the file, for the error message.
        key: Full key, for the error message.
        value: Value from the TOML file.
        dimension: Key of `gyrostat.core.units.SI_UNIT`.
        positive: Whether the number must be greater than zero.

    Returns:
        The value in SI units.

    Raises:
        InputError: The value is not such a quantity.
    """
    if isinstance(value, str):
        value = parse_quantity(value, dimension, f"{path}: key {key}")
    return number(path, key, value, positive=positive)


def three(path: Path, key: str, value: object, dimension: str | None) -> Vector:
    """Read three numbers, with a dimension or dimensionless.

    Args:
        path: Path of the file, for the error message.
        key: Full key, for the error message.
        value: Value from the TOML file.
        dimension: Key of `gyrostat.core.units.SI_UNIT`; None for dimensionless numbers.

    Returns:
        The numbers in SI units, (3,).

    Raises:
        InputError: The value is not a list of three such numbers.
    """
    if not isinstance(value, list) or len(value) != 3:
        raise InputError(f"{path}: key {key}: found {described(value)}, expected three numbers")
    entries = [
        quantity(path, f"{key}[{k}]", entry, dimension, positive=False)
        if dimension
        else number(path, f"{key}[{k}]", entry, positive=False)
        for k, entry in enumerate(value)
    ]
    return np.array(entries)


def direction(path: Path, key: str, value: object) -> Vector:
    """Read three dimensionless numbers, (3,), that are a direction of any length.

    Args:
        path: Path of the file, for the error message.
        key: Full key, for the error message.
        value: Value from the TOML file.

    Raises:
        InputError: The value is not a list of three numbers, or they are all zero.
    """
    vector = three(path, key, value, None)
    if not vector.any():
        raise InputError(f"{path}: key {key}: found zero, expected a direction")
    return vector


def inertia_matrix(path: Path, key: str, value: object) -> Matrix:
    """Read an inertia: three principal values, or three rows of three.

    Args:
        path: Path of the file, for the error message.
        key: Full key, for the error message.
        value: Value from the TOML file.

    Returns:
        The matrix, (3, 3), kg·m²; not validated.

    Raises:
        InputError: The value is neither.
    """
    if not isinstance(value, list) or len(value) != 3:
        raise InputError(
            f"{path}: key {key}: found {described(value)}, expected three principal values or "
            "three rows of three, kg·m²"
        )
    if any(isinstance(row, list) for row in value):
        return np.stack([three(path, f"{key}[{k}]", row, "inertia") for k, row in enumerate(value)])
    return np.diag(three(path, key, value, "inertia"))


def described(value: object) -> str:
    """Description of a value of a wrong type, for an error message."""
    if value is None:
        return "none"
    if isinstance(value, dict):
        return "a table"
    return f"{len(value)} values" if isinstance(value, list) else repr(value)


def quoted(text: str) -> str:
    """TOML basic string: a JSON string, except for the one control character that JSON allows."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
