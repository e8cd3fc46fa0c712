"""Table of the fields of an object for a notebook: value, uncertainty, and meaning with unit."""

import inspect
import re
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from gyrostat.core.text import measured, plain
from gyrostat.core.units import si_unit

DIGITS = 6
MOST = 9
"""Largest number of elements of an array or a mapping that are listed."""
_ENTRY = re.compile(r"^ {4}(\w+): (.*)$")


def field_table(part: Any) -> str:
    """Table of the fields of an object: name, value, and what its docstring says of the field.

    A value with a standard deviation in another field, `sigma` or with the same name and `_sigma`,
    is shown with it.

    Args:
        part: Instance of a dataclass or named tuple, whose docstring has a section `Attributes`.
    """
    meanings = meanings_of(type(part))
    rows = [
        f"<tr><th>{escape(name)}</th><td>{escape(_with_sigma(part, name))}</td>"
        f"<td>{escape(meanings.get(name, ''))}</td></tr>"
        for name in _names(part)
    ]
    caption = f"<caption>{escape(type(part).__name__)}</caption>"
    return f"<table>{caption}<tbody>{''.join(rows)}</tbody></table>"


def meanings_of(kind: type) -> dict[str, str]:
    """Field -> what the docstring of a class says of it, with its unit; the base classes first."""
    meanings: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        _, _, section = inspect.cleandoc(each.__doc__ or "").partition("\nAttributes:\n")
        name = ""
        for line in section.splitlines():
            entry = _ENTRY.match(line)
            if entry:
                name, meanings[entry[1]] = entry[1], entry[2]
            elif line.startswith(" " * 8) and name:
                meanings[name] += f" {line.strip()}"
            elif line.strip():
                break
        fields = getattr(each, "__dataclass_fields__", {})
        for field in fields.values():
            if "dimension" in field.metadata:
                meanings.setdefault(field.name, si_unit(field.metadata["dimension"]))
    return meanings


def _names(part: Any) -> list[str]:
    """Fields of a named tuple or a dataclass; none of another object."""
    fields = getattr(part, "__dataclass_fields__", {}).values()
    return [*getattr(part, "_fields", [field.name for field in fields if field.repr])]


def _with_sigma(part: Any, name: str) -> str:
    value = getattr(part, name)
    if isinstance(value, float | np.floating):
        for other in (f"{name}_sigma", "sigma" if name in ("value", "mean") else ""):
            sigma = getattr(part, other, None)
            if isinstance(sigma, float | np.floating):
                return measured(float(value), float(sigma))
    return _text(value)


def _text(value: Any) -> str:
    """Short text of a value; of many elements only how many there are."""
    if isinstance(value, float | np.floating):
        return plain(float(value), DIGITS)
    if value is None or isinstance(value, str | bool | int):
        return "none" if value is None else str(value)
    if hasattr(value, "shape") and hasattr(value, "dtype"):
        return _array(value)
    if isinstance(value, Mapping):
        if len(value) > MOST:
            return f"{len(value)} entries"
        return ", ".join(f"{key}: {_text(each)}" for key, each in value.items())
    if {"value", "low", "high"} <= {*_names(value)}:
        return f"{_text(value.value)} ({_text(value.low)} to {_text(value.high)})"
    if isinstance(value, Sequence) and not hasattr(value, "_fields"):
        return ", ".join(map(_text, value)) if len(value) <= MOST else f"{len(value)} elements"
    return getattr(value, "__name__", type(value).__name__)


def _array(value: Any) -> str:
    try:
        array = np.asarray(value)
    except TypeError:  # JAX traces it
        return f"{value.dtype} of shape {value.shape}"
    if array.size <= MOST and array.dtype.kind in "biuf":
        return np.array2string(array, precision=DIGITS, separator=", ").replace("\n", "")
    if array.dtype.kind == "f" and np.any(np.isfinite(array)):
        ends = plain(float(np.nanmin(array)), DIGITS), plain(float(np.nanmax(array)), DIGITS)
        return f"{' to '.join(ends)}, shape {array.shape}"
    return f"{array.dtype} of shape {array.shape}"
