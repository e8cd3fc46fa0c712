"""Read a bench record from a file."""

import os
import stat
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np

from gyrostat.core.units import Unit
from gyrostat.telemetry.assemble import Measured, assemble
from gyrostat.telemetry.columns import Chosen, choose_columns
from gyrostat.telemetry.edges import angle_at, read_edges
from gyrostat.telemetry.fault import fault
from gyrostat.telemetry.matlab import read_mat
from gyrostat.telemetry.parquet import read_parquet
from gyrostat.telemetry.record import Record
from gyrostat.telemetry.text import read_text

_READERS = {
    **dict.fromkeys((".csv", ".txt", ".tsv", ".dat"), read_text),
    ".parquet": read_parquet,
    ".mat": read_mat,
}


def read_record(
    path: str | os.PathLike[str],
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    unsigned_current: bool = False,
    max_samples: int = 2_000_000,
    missing: Literal["refuse", "drop"] = "refuse",
    edges: str | os.PathLike[str] | None = None,
    pulses: int = 1,
) -> Record:
    """Read a bench record from delimited text, Parquet or a MATLAB file; the suffix decides.

    Text may have any delimiter, one to three header rows (names, units, short names), comments
    before them, and a decimal comma if the comma is not the delimiter. Units are given in the names
    ('speed [rpm]', 'speed (rpm)', 'speed_rpm'), in the row of units, or by the argument `units`.

    An empty speed cell, or 0 in the column `valid`, marks a missing sample. In a missing sample, an
    empty cell of another column repeats its previous value; elsewhere it is an error.

    Args:
        path: File with the suffix .csv, .txt, .tsv, .dat, .parquet or .mat.
        columns: Role -> column name. Roles are time, current, speed (or angle instead), and
            optionally temperature, setpoint (or direction) and valid. A role that is not given is
            found by its name.
        units: Role -> unit, which takes precedence over the header; "rev/4096" for encoder counts.
        unsigned_current: Whether the current is a magnitude. Its sign is that of the setpoint, or
            of the speed if there is no setpoint or it is 0; if both are 0, the previous sign.
        missing: "drop" omits rows without a finite time or current and marks speeds that are not
            finite (NaN, 'NA', an empty cell) as missing; "refuse" raises an error for them.
        edges: File with the times of a tachometer's edges, s, one per line, on the clock of the
            record; the record then needs no speed.
        pulses: Edges per revolution.
        max_samples: Largest number of samples; a longer file is refused.

    Returns:
        The record in SI units, named after the file. `notes` lists what the reader changed.

    Raises:
        InputError: The file cannot be read or its content cannot be used. The one-line message
            names the file, the row and the column, what was found and what was expected.
    """
    file = Path(path)
    drop = missing == "drop"
    reader = _READERS.get(file.suffix.lower())
    if reader is None:
        found = f"the suffix {file.suffix!r}" if file.suffix else "no suffix"
        raise fault(file, found, f"one of {', '.join(_READERS)}")
    _require_readable(file)
    if reader is read_text:
        reader = partial(read_text, tolerant=drop)
    choose = partial(choose_columns, columns=columns, units=units, motion=edges is None)
    try:
        measured = reader(file, choose, max_samples)
    except OSError as error:
        raise fault(file, f"an unreadable file ({error.strerror})", "a record") from None
    if edges is not None:
        measured = _with_edges(measured, edges, pulses)
    return assemble(measured, unsigned_current, drop)


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


def _require_readable(file: Path) -> None:
    try:
        status = file.stat()
        # Opening a pipe would block until another process writes to it.
        if stat.S_ISREG(status.st_mode):
            file.open("rb").close()
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise fault(file, f"no readable file ({reason})", "a record") from None
    if not stat.S_ISREG(status.st_mode):
        file_type = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or device"
        raise fault(file, file_type, "a file")
    if status.st_size == 0:
        raise fault(file, "an empty file", "a record")
