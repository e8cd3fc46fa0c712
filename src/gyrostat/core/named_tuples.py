"""Named tuples with additional fields."""

from collections import namedtuple
from collections.abc import Mapping
from functools import cache
from typing import Any

from gyrostat.core.checked import declared_units


def with_fields(prefix: str, values: Any, added: Mapping[str, Any], units: Mapping[str, str]):
    """Named tuple with additional fields.

    Args:
        prefix: Prefix of the name of the new type.
        values: Named tuple.
        added: Additional fields, name -> value.
        units: Units of additional fields, for histories; a field may have none.

    Returns:
        A named tuple of the fields of `values`, followed by the additional ones. Equal arguments
        give the same type.
    """
    extension = _extend(prefix, type(values), tuple(added), tuple(sorted(units.items())))
    return extension(*values, *added.values())


def without_fields(values: Any) -> Any:
    """Named tuple to which `with_fields` has added fields."""
    kind = type(values).EXTENDS
    return kind(*values[: len(kind._fields)])


@cache
def _extend(
    prefix: str, kind: Any, names: tuple[str, ...], units: tuple[tuple[str, str], ...]
) -> Any:
    extension: Any = namedtuple(f"{prefix}{kind.__name__}", (*kind._fields, *names))
    extension.UNITS = declared_units(kind) | dict(units)
    extension.EXTENDS = kind
    # the type is made when it is needed, so that pickle cannot find it by its name
    extension.__reduce__ = lambda row: (
        with_fields,
        (
            prefix,
            without_fields(row),
            dict(zip(names, row[-len(names) :], strict=True)),
            dict(units),
        ),
    )
    return extension
