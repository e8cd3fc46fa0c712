"""Build a checked record from the columns of a file."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.units import parse_quantity
from gyrostat.telemetry.columns import Chosen
from gyrostat.telemetry.fault import counted, fault
from gyrostat.telemetry.record import CHANNELS, Record

_HOW_TO_MARK = (
    "a finite number (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
    "--missing drop leaves such rows out)"
)
WRAPPED = 0.45
"""Turns between two samples above which the sense of rotation of a wrapped angle is uncertain."""


@dataclass(frozen=True)
class Measured:
    """Columns of a file that have a role, with the values as stored in the file."""

    file: Path
    chosen: Mapping[str, Chosen]
    values: Mapping[str, NDArray[np.float64]]
    """Role -> numbers in the unit of the file, (N,); NaN if the cell is empty."""
    empty: Mapping[str, NDArray[np.bool_]]
    """Role -> whether the cell is empty, (N,)."""
    rows: NDArray[np.int64]
    """Row number of each sample in the file, (N,), for messages."""
    notes: tuple[str, ...] = ()
    metadata: Mapping[str, str] = field(default_factory=dict)
    """Metadata of the record from comments of the file."""


def assemble(measured: Measured, unsigned_current: bool, drop: bool = False) -> Record:
    """Check the columns of a file and build a record.

    Args:
        measured: Columns of the file.
        unsigned_current: Whether the current is a magnitude whose sign must come from setpoint or
            speed.
        drop: Whether to drop rows without a finite time or current, mark speeds that are not finite
            as missing and repeat the last value in other columns; otherwise these are errors.

    Raises:
        InputError: An empty cell, NaN or infinity where a number is required; time that does not
            increase; negative current although it is declared unsigned; fewer than two samples.
    """
    if drop:
        measured = _drop_rows(measured)
    count = measured.rows.size
    if count < 2:
        raise fault(measured.file, counted(count), "at least 2")
    missing = _missing_samples(measured)
    notes = list(measured.notes)
    if np.any(missing):
        notes.append(f"{counted(int(np.sum(missing)))} marked missing")
    series: dict[str, NDArray[np.float64]] = {}
    for role in measured.values:
        if role != "valid":
            series[role], fill_count = _in_si(measured, role, missing)
            if fill_count:
                notes.append(f"{role} held over {counted(fill_count)}")
    _require_increasing_time(measured, series["time"])
    averaged = "angle" in series
    if averaged:
        series["speed"], missing = _differences(
            measured, series.pop("angle"), series["time"], missing
        )
        notes.append("speed: mean over each interval, from the angle")
    series["speed"][missing] = np.nan
    if unsigned_current:
        negative = series["current"] < 0.0
        _refuse(measured, "current", negative, "no negative value in a current declared unsigned")
        sign, source = _direction(measured, series["speed"], series.get("setpoint"))
        notes.append(source)
        unknown = int(np.sum((sign == 0.0) & (series["current"] > 0.0)))
        if unknown:
            notes.append(f"direction unknown in {counted(unknown)}: sign of current held")
        series["current"] = np.copysign(series["current"], _held_direction(sign))
    temperature = measured.metadata.get("temperature")
    if temperature and "temperature" not in series:
        where = f"{measured.file}: comment temperature"
        series["temperature"] = np.full(count, parse_quantity(temperature, "temperature", where))
    beside: dict[str, Any] = {name: series.get(name) for name in CHANNELS}
    return Record(
        name=measured.file.name,
        time=series["time"],
        current=series["current"],
        speed=series["speed"],
        valid=~missing,
        notes=tuple(notes),
        averaged=averaged,
        metadata=dict(measured.metadata),
        **beside,
    )


def _motion(measured: Measured) -> str:
    """Role that measures the motion: speed or angle."""
    return "angle" if "angle" in measured.values else "speed"


def _drop_rows(measured: Measured) -> Measured:
    """Drop rows without time or current, and mark or hold other values that are not finite."""
    values = {role: series.copy() for role, series in measured.values.items()}
    empty = {role: gaps.copy() for role, gaps in measured.empty.items()}
    motion = _motion(measured)
    complete = np.isfinite(values["time"]) & np.isfinite(values["current"])
    notes = list(measured.notes)
    if not complete.all():
        notes.append(f"{counted(int(np.sum(~complete)), 'row')} without time or current dropped")
    bad = ~np.isfinite(values[motion]) & ~empty[motion]
    empty[motion] |= bad
    for role in set(values) - {"time", "current", motion}:
        wrong = ~np.isfinite(values[role])
        if wrong.all():
            del values[role], empty[role]
            notes.append(f"column {role} left out: no finite number in it")
        elif wrong.any():
            values[role] = values[role][_latest(~wrong)]
            empty[role][:] = False
            notes.append(f"{role} held over {counted(int(wrong.sum()))}")
    return replace(
        measured,
        values={role: series[complete] for role, series in values.items()},
        empty={role: gaps[complete] for role, gaps in empty.items()},
        rows=measured.rows[complete],
        notes=tuple(notes),
    )


def _differences(
    measured: Measured,
    angle: NDArray[np.float64],
    time: NDArray[np.float64],
    missing: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Mean speed over the interval before each sample, rad/s, and whether it is missing, (N,)."""
    increment = np.diff(np.where(missing, 0.0, angle))
    valid = ~(missing[1:] | missing[:-1])
    turn = 2.0 * np.pi
    samples = angle[~missing]
    if np.ptp(samples) <= turn * (1.0 + 1e-9):
        increment = (increment + 0.5 * turn) % turn - 0.5 * turn
        if np.any(np.abs(increment[valid]) > WRAPPED * turn):
            found = "an angle within one turn that changes by nearly half a turn between samples"
            expected = "a continuous angle, or more samples per turn"
            column = measured.chosen["angle"].name
            raise fault(measured.file, found, expected, None, column)
    speed = np.concatenate([[np.nan], increment / np.diff(time)])
    return speed, np.concatenate([[True], ~valid])


def _missing_samples(measured: Measured) -> NDArray[np.bool_]:
    """Whether the speed of each sample is missing, (N,)."""
    missing = measured.empty[_motion(measured)].copy()
    if "valid" in measured.values:
        valid = measured.values["valid"]
        _refuse(measured, "valid", ~np.isin(valid, (0.0, 1.0)), "0 or 1")
        missing |= valid == 0.0
    return missing


def _in_si(
    measured: Measured, role: str, missing: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], int]:
    """Column in SI, with empty cells of missing samples filled; and the number of filled cells."""
    values, empty = measured.values[role], measured.empty[role]
    with np.errstate(over="ignore"):
        converted = measured.chosen[role].unit.to_si(values)
    bad = ~np.isfinite(converted)
    if role in ("speed", "angle"):
        # The value of a sample that is marked missing is not used.
        _refuse(measured, role, bad & ~missing, _HOW_TO_MARK)
        return converted, 0
    # A cell may be empty only in a sample marked missing, and time must always be given.
    first_known = int(np.argmin(empty))
    gaps = empty & missing & (np.arange(empty.size) > first_known) & (role != "time")
    _refuse(measured, role, bad & ~gaps, _HOW_TO_MARK if role == "current" else "a finite number")
    return converted[_latest(~gaps)], int(np.sum(gaps))


def _latest(valid: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Index of the last known sample up to each, (N,); before the first known one, its index."""
    return np.maximum.accumulate(np.where(valid, np.arange(valid.size), np.argmax(valid)))


def _require_increasing_time(measured: Measured, time: NDArray[np.float64]) -> None:
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        index = int(late[0]) + 1
        column = measured.chosen["time"]
        before, after = (repr(float(t)) for t in measured.values["time"][index - 1 : index + 1])
        last, row = measured.rows[index - 1 : index + 1]
        found = f"time {after} after {before} {column.unit.symbol} in row {last}"
        raise fault(measured.file, found, "strictly increasing time", int(row), column.name)


def _direction(
    measured: Measured, speed: NDArray[np.float64], setpoint: NDArray[np.float64] | None
) -> tuple[NDArray[np.float64], str]:
    """Sign of the current, (N,), 0 if unknown; and a note that names its source."""
    of_speed = np.sign(np.nan_to_num(speed))
    name = measured.chosen["speed"].name
    if setpoint is None:
        return of_speed, f"current unsigned: sign taken from column {name}"
    source = f"current unsigned: sign taken from column {measured.chosen['setpoint'].name}"
    is_zero = setpoint == 0.0
    if np.any(is_zero):
        source += f", and from {name} if it is 0"
    return np.where(is_zero, of_speed, np.sign(setpoint)), source


def _held_direction(sign: NDArray[np.float64]) -> NDArray[np.float64]:
    """Replace zeros by the last nonzero sign before them, or the first after; +1 if all are zero.

    A sign of zero would remove a current that actually flowed, for example before breakaway.
    """
    return sign[_latest(sign != 0.0)] if np.any(sign) else np.ones_like(sign)


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
