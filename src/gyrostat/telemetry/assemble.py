"""Build a checked record from the columns of a file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrostat.telemetry.columns import Chosen
from gyrostat.telemetry.fault import counted, fault
from gyrostat.telemetry.record import Record

_HOW_TO_MARK = (
    "a finite number (a missing speed sample is an empty cell, or has 0 in a column 'valid')"
)


@dataclass(frozen=True)
class Measured:
    """The columns of a file that have a role, with the values as stored in the file."""

    file: Path
    chosen: Mapping[str, Chosen]
    values: Mapping[str, NDArray[np.float64]]
    """Role -> (N,) numbers in the unit of the file; NaN if the cell is empty."""
    empty: Mapping[str, NDArray[np.bool_]]
    """Role -> (N,) whether the cell is empty."""
    rows: NDArray[np.int64]
    """(N,) row number of each sample in the file, for messages."""
    notes: tuple[str, ...] = ()


def assemble(measured: Measured, unsigned_current: bool) -> Record:
    """Check the columns of a file and build a record.

    Args:
        measured: Columns of the file.
        unsigned_current: Whether the current is a magnitude whose sign must come from setpoint or
            speed.

    Raises:
        InputError: An empty cell, NaN or infinity where a number is required; time that does not
            increase; negative current although it is declared unsigned; fewer than two samples.
    """
    count = measured.rows.size
    if count < 2:
        raise fault(measured.file, counted(count), "at least 2")
    missing = _missing(measured)
    notes = list(measured.notes)
    if np.any(missing):
        notes.append(f"{counted(int(np.sum(missing)))} marked missing")
    series: dict[str, NDArray[np.float64]] = {}
    for role in measured.values:
        if role != "valid":
            series[role], held = _in_si(measured, role, missing)
            if held:
                notes.append(f"{role} held over {counted(held)}")
    _require_increasing_time(measured, series["time"])
    series["speed"][missing] = np.nan
    if unsigned_current:
        negative = series["current"] < 0.0
        _refuse(measured, "current", negative, "no negative value in a current called unsigned")
        sign, source = _direction(measured, series["speed"], series.get("setpoint"))
        notes.append(source)
        unknown = int(np.sum((sign == 0.0) & (series["current"] > 0.0)))
        if unknown:
            notes.append(f"direction unknown in {counted(unknown)}: sign of current held")
        series["current"] = np.copysign(series["current"], _held_direction(sign))
    return Record(
        name=measured.file.name,
        valid=~missing,
        notes=tuple(notes),
        **series,
    )


def _missing(measured: Measured) -> NDArray[np.bool_]:
    """Flag of each sample whose speed is missing, (N,)."""
    missing = measured.empty["speed"].copy()
    if "valid" in measured.values:
        valid = measured.values["valid"]
        _refuse(measured, "valid", ~np.isin(valid, (0.0, 1.0)), "0 or 1")
        missing |= valid == 0.0
    return missing


def _in_si(
    measured: Measured, role: str, missing: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], int]:
    """One column in SI, with empty cells of missing samples filled; and how many were filled."""
    values, empty = measured.values[role], measured.empty[role]
    with np.errstate(over="ignore"):
        converted = measured.chosen[role].unit.to_si(values)
    bad = ~np.isfinite(converted)
    if role == "speed":
        # The speed of a sample that is marked missing is not used.
        _refuse(measured, role, bad & ~missing, _HOW_TO_MARK)
        return converted, 0
    # A cell may be empty only in a sample marked missing, and time must always be given.
    first_known = int(np.argmin(empty))
    held = empty & missing & (np.arange(empty.size) > first_known) & (role != "time")
    _refuse(measured, role, bad & ~held, _HOW_TO_MARK if role == "current" else "a finite number")
    latest = np.maximum.accumulate(np.where(held, 0, np.arange(empty.size)))
    return converted[latest], int(np.sum(held))


def _require_increasing_time(measured: Measured, time: NDArray[np.float64]) -> None:
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        index = int(late[0]) + 1
        column = measured.chosen["time"]
        before, after = (repr(float(t)) for t in measured.values["time"][index - 1 : index + 1])
        found = (
            f"time {after} after {before} {column.unit.symbol} in row {measured.rows[index - 1]}"
        )
        raise fault(
            measured.file,
            found,
            "strictly increasing time",
            int(measured.rows[index]),
            column.name,
        )


def _direction(
    measured: Measured, speed: NDArray[np.float64], setpoint: NDArray[np.float64] | None
) -> tuple[NDArray[np.float64], str]:
    """Sign of the current, (N,), 0 where unknown; and a note that names its source."""
    of_speed = np.sign(np.nan_to_num(speed))
    name = measured.chosen["speed"].name
    if setpoint is None:
        return of_speed, f"current unsigned: sign taken from column {name}"
    source = f"current unsigned: sign taken from column {measured.chosen['setpoint'].name}"
    rest = setpoint == 0.0
    if np.any(rest):
        source += f", and from {name} where that is 0"
    return np.where(rest, of_speed, np.sign(setpoint)), source


def _held_direction(sign: NDArray[np.float64]) -> NDArray[np.float64]:
    """Replace zeros by the last nonzero sign before them, or the first after; +1 if all are zero.

    A sign of zero would erase a current that really flowed, for example before breakaway.
    """
    known = np.flatnonzero(sign)
    if not known.size:
        return np.ones_like(sign)
    latest = np.maximum.accumulate(np.where(sign == 0.0, known[0], np.arange(sign.size)))
    return sign[latest]


def _refuse(measured: Measured, role: str, bad: NDArray[np.bool_], expected: str) -> None:
    """Raise an error for the first bad sample of a column, if there is one."""
    if not np.any(bad):
        return
    index = int(np.argmax(bad))
    value = float(measured.values[role][index])
    raise fault(
        measured.file,
        "an empty cell" if measured.empty[role][index] else repr(value),
        expected,
        int(measured.rows[index]),
        measured.chosen[role].name,
    )
