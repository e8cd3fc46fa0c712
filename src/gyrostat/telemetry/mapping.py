"""File that maps the columns of a record's file."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_toml, refuse_unknown
from gyrostat.core.units import parse_quantity


@dataclass(frozen=True)
class ColumnMap:
    """Columns of a record by role.

    Attributes:
        columns: Role -> column name.
        units: Role -> unit.
        interval: Time from sample to sample, s, of a file without times; or None.
        packets: XTCE description of the packets, or None.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    interval: float | None = None
    packets: Path | None = None


def column_map(
    columns: Mapping[str, str] | str | os.PathLike[str] | None, units: Mapping[str, str] | None
) -> ColumnMap:
    """Combine columns and units of the caller, or read them from a file.

    Args:
        columns: Role -> column name, or a TOML file with tables [columns] and [units], and the keys
            `interval` and `packets`.
        units: Role -> unit; takes precedence over the file.

    Raises:
        InputError: The file cannot be read, or a key or value is not one of these.
    """
    if columns is None or isinstance(columns, Mapping):
        return ColumnMap(columns or {}, units or {})
    file = Path(columns)
    content = read_toml(file, "a file of columns")
    refuse_unknown(file, "", content, ("columns", "units", "interval", "packets"))
    tables = {
        name: _texts(content.get(name, {}), f"{file}: {name}") for name in ("columns", "units")
    }
    interval = None
    if "interval" in content:
        interval = parse_quantity(str(content["interval"]), "time", f"{file}: interval")
        if not interval > 0.0:
            raise InputError(f"{file}: interval: found {interval:g} s, expected a time above 0")
        if "time" in tables["columns"]:
            raise InputError(f"{file}: found interval and columns.time, expected one of the two")
    packets = content.get("packets")
    if packets is not None and not isinstance(packets, str):
        raise InputError(f"{file}: packets: found {packets!r}, expected the name of an XTCE file")
    return ColumnMap(
        tables["columns"],
        {**tables["units"], **(units or {})},
        interval,
        None if packets is None else file.parent / packets,
    )


def _texts(table: object, where: str) -> dict[str, str]:
    """Table whose values are texts."""
    if not isinstance(table, dict):
        raise InputError(f"{where}: found {table!r}, expected a table")
    for key, value in table.items():
        if not isinstance(value, str):
            raise InputError(f"{where}.{key}: found {value!r}, expected a text")
    return table
