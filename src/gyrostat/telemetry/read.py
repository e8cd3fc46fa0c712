"""Read a bench record from a file."""

import os
import stat
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from gyrostat.core.classes_of import classes_of
from gyrostat.core.units import SI_UNIT, Unit
from gyrostat.telemetry import formats
from gyrostat.telemetry.assemble import Measured, assemble
from gyrostat.telemetry.columns import MOTION, Chosen, choose_columns
from gyrostat.telemetry.edges import angle_at, read_edges
from gyrostat.telemetry.fault import fault
from gyrostat.telemetry.mapping import ColumnMap, column_map
from gyrostat.telemetry.record import Record
from gyrostat.telemetry.record_format import RecordFormat, Request
from gyrostat.telemetry.two_logs import combine

_FORMATS = {suffix: kind for kind in classes_of(formats, RecordFormat) for suffix in kind.suffixes}


def read_record(
    path: str | os.PathLike[str],
    columns: Mapping[str, str] | str | os.PathLike[str] | None = None,
    units: Mapping[str, str] | None = None,
    unsigned_current: bool = False,
    max_samples: int = 2_000_000,
    missing: Literal["refuse", "drop"] = "refuse",
    edges: str | os.PathLike[str] | None = None,
    pulses: int = 1,
    speed_from: str | os.PathLike[str] | None = None,
    speed_columns: Mapping[str, str] | str | os.PathLike[str] | None = None,
) -> Record:
    """Read a bench record from a file; its suffix decides on the format.

    Columns in groups are called 'GROUP/CHANNEL', or 'CHANNEL' if no other group has it.
    Text may have any delimiter, one to three header rows (names, units, short names), comments
    before them, and a decimal comma if the comma is not the delimiter. Units are given in the names
    ('speed [rpm]', 'speed (rpm)', 'speed_rpm'), in the row of units, or by the argument `units`.

    An empty speed cell, or 0 in the column `valid`, marks a missing sample. In a missing sample, an
    empty cell of another column repeats its previous value; elsewhere it is an error.

    Args:
        path: File with the suffix of one of `gyrostat.telemetry.formats`.
        columns: Role -> column name, or a file of them (`gyrostat.telemetry.mapping`). Roles are
            time, current, speed (or angle instead), and optionally time_fine, temperature, setpoint
            (or direction) and valid. A role that is not given is found by its name.
        units: Role -> unit, which takes precedence over the header; "rev/4096" for encoder counts.
        unsigned_current: Whether the current is a magnitude. Its sign is that of the setpoint, or
            of the speed if there is no setpoint or it is 0; if both are 0, the previous sign.
        missing: "drop" omits rows without a finite time or current and marks speeds that are not
            finite (NaN, 'NA', an empty cell) as missing; "refuse" raises an error for them.
        edges: File with the times of a tachometer's edges, s, one per line, on the clock of the
            record; the record then needs no speed.
        pulses: Edges per revolution.
        speed_from: File with the speed or angle, of a logger with its own clock; `path` then needs
            no speed (`gyrostat.telemetry.two_logs`). `units` of speed and angle are those of this
            file.
        speed_columns: Columns of this file; as `columns`.
        max_samples: Largest number of samples; a longer file is refused.

    Returns:
        The record in SI units, named after the file. `notes` lists what the reader changed.

    Raises:
        InputError: The file cannot be read or its content cannot be used. The one-line message
            names the file, the row and the column, what was found and what was expected.
    """
    drop = missing == "drop"
    absent = () if edges is None and speed_from is None else MOTION
    measured = _measured(Path(path), column_map(columns, units), max_samples, drop, absent)
    if speed_from is None:
        if edges is not None:
            measured = _with_edges(measured, edges, pulses)
        return assemble(measured, unsigned_current, drop)
    if edges is not None:
        raise fault(Path(path), "edges and speed_from", "one of the two")
    if unsigned_current and "setpoint" not in measured.values:
        raise fault(
            Path(path), "an unsigned current", "a setpoint, or a signed current: speed_from"
        )
    stated = {role: unit for role, unit in (units or {}).items() if role in MOTION}
    tacho = _measured(
        Path(speed_from), column_map(speed_columns, stated), max_samples, drop, ("current",)
    )
    current = _blank(measured, "speed", np.nan)
    speed = _blank(tacho, "current", 0.0)
    return combine(
        replace(assemble(current, unsigned_current, drop), notes=measured.notes),
        assemble(speed, False, drop),
    )


def _blank(measured: Measured, role: str, value: float) -> Measured:
    """Columns of a file with a column that another file has."""
    count = measured.rows.size
    column = np.full(count, value)
    return replace(
        measured,
        chosen={**measured.chosen, role: Chosen(-1, role, Unit(SI_UNIT[role]))},
        values={**measured.values, role: column},
        empty={**measured.empty, role: np.isnan(column)},
    )


def _measured(
    file: Path, given: ColumnMap, max_samples: int, drop: bool, absent: tuple[str, ...]
) -> Measured:
    """Columns of a file."""
    kind = format_of(file)
    if given.interval is not None:
        absent = (*absent, "time", "time_fine")
    choose = partial(choose_columns, columns=given.columns, units=given.units, absent=absent)
    try:
        measured = kind.read(file, Request(choose, max_samples, drop, given.packets))
    except OSError as error:
        raise fault(file, f"an unreadable file ({error.strerror})", "a record") from None
    return with_time(measured, given.interval)


def format_of(file: Path) -> type[RecordFormat]:
    """Format of a file by its suffix.

    Raises:
        InputError: The suffix is unknown, or the file cannot be read or is empty.
    """
    kind = _FORMATS.get(file.suffix.lower())
    if kind is None:
        found = f"the suffix {file.suffix!r}" if file.suffix else "no suffix"
        raise fault(file, found, f"one of {', '.join(_FORMATS)}")
    require_readable(file, "a record")
    return kind


def with_time(measured: Measured, interval: float | None) -> Measured:
    """Columns of a file with times at equal intervals, s, or with the fine part of its times."""
    chosen = {**measured.chosen}
    values = {**measured.values}
    empty = {**measured.empty}
    if interval is not None:
        chosen["time"] = Chosen(-1, "interval", Unit("s"))
        values["time"] = interval * np.arange(measured.rows.size, dtype=np.float64)
        empty["time"] = np.zeros(measured.rows.size, np.bool_)
    elif "time_fine" in chosen:
        fine = chosen.pop("time_fine").unit.to_si(values.pop("time_fine"))
        values["time"] = values["time"] + fine / chosen["time"].unit.factor
        empty["time"] = empty["time"] | empty.pop("time_fine")
    return replace(measured, chosen=chosen, values=values, empty=empty)


def _with_edges(measured: Measured, edges: str | os.PathLike[str], pulses: int) -> Measured:
    """Columns of a file with the angle from its tachometer's edges added."""
    time = measured.chosen["time"].unit.to_si(measured.values["time"])
    angle = angle_at(measured.file.name, time, read_edges(edges), pulses)
    return replace(
        measured,
        chosen={**measured.chosen, "angle": Chosen(-1, "edges", Unit("rad"))},
        values={**measured.values, "angle": angle},
        empty={**measured.empty, "angle": np.isnan(angle)},
    )


def require_readable(file: Path, wanted: str) -> None:
    """Check a file before a package opens it by its name: it might wait for a pipe for ever.

    Args:
        file: Path of the file.
        wanted: What the file should be, for the error message.

    Raises:
        InputError: It is no regular file, cannot be read or is empty.
    """
    try:
        status = file.stat()
        # Opening a pipe would block until another process writes to it.
        if stat.S_ISREG(status.st_mode):
            file.open("rb").close()
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise fault(file, f"no readable file ({reason})", wanted) from None
    if not stat.S_ISREG(status.st_mode):
        file_type = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or device"
        raise fault(file, file_type, "a file")
    if status.st_size == 0:
        raise fault(file, "an empty file", wanted)
