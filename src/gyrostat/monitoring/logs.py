"""Telemetry that stands in several logs, each with times of its own, joined into one table.

A file of columns names the logs, and the columns of each:

    [[log]]
    file = "wheel_0.csv"           # the name; * and ? stand for any letters
    [log.columns]
    time = "timestamp"             # numbers with a unit, or dates as in 2026-03-01T12:00:00Z
    wheel1_speed = "rate"
    [log.units]
    wheel1_speed = "rpm"

The roles are those of `gyrostat.monitoring.reading`. The table has the times of the first log.
Speeds, body rates and temperatures of the others are interpolated between two of their samples;
currents, powers, torques and modes are held from a sample to the next. Where a log has a gap,
values are missing.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.files import whole_file
from gyrostat.core.toml_file import read_toml, refuse_unknown
from gyrostat.core.types import Vector
from gyrostat.core.units import SI_UNIT
from gyrostat.monitoring.reading import roles_of
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.telemetry.columns import Column, Header, choose_columns
from gyrostat.telemetry.fault import damaged, fault

GAP = 3.0
"""Time between two samples over the usual one above which a log has a gap."""
_HELD = ("current", "power", "torque", "mode")


@dataclass(frozen=True)
class Log:
    """Logs of one kind.

    Attributes:
        file: Name of the files, with * and ? for any letters.
        columns: Role -> column.
        units: Role -> unit.
    """

    file: str
    columns: Mapping[str, str]
    units: Mapping[str, str]


def read_logs_map(path: Path) -> list[Log]:
    """Read the logs that a file of columns names; empty if it names none.

    Raises:
        InputError: The file cannot be read, or a key or value is not one of these.
    """
    content = read_toml(path, "a file of columns")
    entries = content.get("log", [])
    if not isinstance(entries, list) or not all(isinstance(each, dict) for each in entries):
        raise InputError(f"{path}: log: found {entries!r}, expected tables [[log]]")
    if entries:
        refuse_unknown(path, "", content, ("log",))
    logs = []
    for number, entry in enumerate(entries, 1):
        where = f"log {number}"
        refuse_unknown(path, where, entry, ("file", "columns", "units"))
        tables = [entry.get(name, {}) for name in ("columns", "units")]
        if not isinstance(entry.get("file"), str):
            raise InputError(f"{path}: {where}: found no file, expected the name of its files")
        for table in tables:
            if not (isinstance(table, dict) and all(isinstance(v, str) for v in table.values())):
                raise InputError(f"{path}: {where}: found {table!r}, expected texts by role")
        if "time" not in tables[0]:
            raise InputError(f"{path}: {where}: found no column for time, expected one")
        logs.append(Log(entry["file"], *tables))
    return logs


def join_logs(paths: Sequence[Path], logs: Sequence[Log], known: KnownWheels, out: Path) -> None:
    """Write the telemetry of several logs as one Parquet file for the monitor.

    The logs are held in memory as a whole.

    Args:
        paths: Files of the logs.
        logs: Logs; a file belongs to the first one whose name it matches.
        known: The wheels.
        out: File to write.

    Raises:
        InputError: A file cannot be read or used, belongs to no log, or a log has no file.
    """
    import pyarrow
    import pyarrow.parquet

    groups: list[list[Path]] = [[] for _ in logs]
    for path in paths:
        kind = [k for k, log in enumerate(logs) if fnmatchcase(path.name, log.file)]
        if not kind:
            names = ", ".join(log.file for log in logs)
            raise InputError(f"{path}: found no log of this name, expected one of {names}")
        groups[kind[0]].append(path)
    for log, files in zip(logs, groups, strict=True):
        if not files:
            raise InputError(f"telemetry: found no file named {log.file}, expected its log")
    tables = [_whole(log, files, known) for log, files in zip(logs, groups, strict=True)]
    time = tables[0].pop("time")
    joined = {"time": time, **tables[0]}
    for table, log in zip(tables[1:], logs[1:], strict=True):
        moments = table.pop("time")
        for role, values in table.items():
            if role in joined:
                raise InputError(f"{log.file}: found {role} in two logs, expected one")
            joined[role] = _at(time, moments, values, held=role.endswith(_HELD))
    roles = roles_of(known)
    names = {role: _written(role, roles[role].dimension) for role in joined}
    with whole_file(out) as unfinished:
        pyarrow.parquet.write_table(
            pyarrow.table({names[role]: values for role, values in joined.items()}), unfinished
        )


def _written(role: str, dimension: str | None) -> str:
    """Name of a column with its SI unit."""
    return role if dimension is None else f"{role} [{SI_UNIT[dimension]}]"


def _whole(log: Log, files: Sequence[Path], known: KnownWheels) -> dict[str, Vector]:
    """Role -> values in SI units of all files of a log, in order of time, each time once."""
    parts = [_read(path, log, known) for path in files]
    joined = {role: np.concatenate([part[role] for part in parts]) for role in parts[0]}
    _, order = np.unique(joined["time"], return_index=True)
    order = order[np.isfinite(joined["time"][order])]
    if order.size < 2:
        raise fault(files[0], f"{order.size} samples with a time", "at least 2")
    return {role: values[order] for role, values in joined.items()}


def _read(path: Path, log: Log, known: KnownWheels) -> dict[str, Vector]:
    """Role -> values in SI units of one file."""
    table = read_table(path)
    names = table.column_names
    roles = {name: replace(role, required=False) for name, role in roles_of(known).items()}
    units = dict(log.units)
    time = log.columns["time"]
    dated = time in names and str(table.schema.field(time).type).startswith("timestamp")
    if dated:
        units["time"] = "s"
    header = Header(path, tuple(Column(k, (name,)) for k, name in enumerate(names)))
    chosen = choose_columns(
        header, log.columns, units, absent=roles.keys() - log.columns.keys(), roles=roles
    )
    series = {}
    for role, column in chosen.items():
        values = table.column(column.index)
        if role == "time" and dated:
            since = values.to_numpy().astype("datetime64[ns]") - np.datetime64(0, "ns")
            moments = since / np.timedelta64(1, "ns") * 1e-9
            series[role] = np.where(np.isnat(since), np.nan, moments)
            continue
        try:
            series[role] = column.unit.to_si(values.to_numpy().astype(float))
        except (TypeError, ValueError):
            raise fault(
                path, f"values of type {values.type}", "numbers", None, column.name
            ) from None
    return series


def read_table(path: Path) -> Any:
    """Table of a CSV or Parquet file.

    Raises:
        InputError: The file cannot be read.
    """
    import pyarrow
    import pyarrow.csv
    import pyarrow.parquet

    try:
        if path.suffix.lower() == ".parquet":
            return pyarrow.parquet.read_table(path)
        return pyarrow.csv.read_csv(path)
    except (OSError, pyarrow.ArrowException) as error:
        raise damaged(path, "a table as CSV or Parquet", error) from None


def _at(time: Vector, moments: Vector, values: Vector, *, held: bool) -> Vector:
    """Values of a log at other times; NaN in its gaps and outside of it."""
    longest = GAP * float(np.median(np.diff(moments)))
    before = np.maximum(np.searchsorted(moments, time, "right") - 1, 0)
    since = time - moments[before]
    if held:
        return np.where((since >= 0.0) & (since <= longest), values[before], np.nan)
    after = np.minimum(before + 1, moments.size - 1)
    step = moments[after] - moments[before]
    share = since / np.where(step > 0.0, step, 1.0)
    inside = (since == 0.0) | ((since > 0.0) & (step > 0.0) & (step <= longest))
    return np.where(inside, values[before] + share * (values[after] - values[before]), np.nan)
