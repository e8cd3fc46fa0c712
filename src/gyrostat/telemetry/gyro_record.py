"""Record of a rate gyro at rest.

Columns are found by their names or assigned (`gyrostat.telemetry.mapping`). The roles are `time`
(and `time_fine`), and for one to three axes `rate_x`, `rate_y`, `rate_z` (mean rates over the
interval before each sample), or instead `angle_x`, ... (integrated angles), or `increment_x`, ...
(angles since the sample before).
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Chosen, Header, choose_columns
from gyrostat.telemetry.fault import counted, fault, listed, shown
from gyrostat.telemetry.mapping import column_map
from gyrostat.telemetry.read import format_of, with_time
from gyrostat.telemetry.record_format import Request
from gyrostat.telemetry.role import Role

AXES = ("x", "y", "z")
KINDS = {"rate": "speed", "angle": "angle", "increment": "angle"}
"""What a column measures -> its dimension."""
_USUAL = {
    "rate": ("rate", "gyro", "omega", "w"),
    "angle": ("angle", "theta"),
    "increment": ("increment", "delta_angle", "dtheta"),
}
"""Beginnings of usual names; the axis follows. Without an axis, the first name is that of x."""
LARGEST_STEP = 1.5
"""Time between two samples above which one is missing, in intervals; below its inverse, one is
twice."""
MOST_SAMPLES = 50_000_000


def _role(kind: str, axis: str) -> Role:
    names = [f"{name}{mark}{axis}" for name in _USUAL[kind] for mark in ("_", "")]
    names += [_USUAL[kind][0]] if axis == "x" else []
    return Role(f"{kind}_{axis}", tuple(names), KINDS[kind])


ROLES = {
    "time": Role("time", ("time", "t"), "time", required=True),
    "time_fine": Role("time_fine", ("time_fine",), "time"),
    **{f"{kind}_{axis}": _role(kind, axis) for kind in KINDS for axis in AXES},
}


@dataclass(frozen=True, eq=False)
class GyroRecord:
    """Rates of a gyro at equal intervals.

    Attributes:
        name: Name of the record.
        interval: Time from sample to sample, s.
        axes: Names of the axes.
        rate: Mean rates over the intervals, (axes, N), rad/s.

    Raises:
        InputError: A rate is not a finite number, or all rates of an axis are equal.
    """

    name: str
    interval: float
    axes: tuple[str, ...]
    rate: Matrix

    def __post_init__(self):
        for axis, rate in zip(self.axes, self.rate, strict=True):
            bad = ~np.isfinite(rate)
            if bad.any():
                k = int(np.argmax(bad))
                raise InputError(f"{self.name}: {axis}[{k}]: found {rate[k]}, expected a number")
            if np.ptp(rate) == 0.0:
                raise InputError(f"{self.name}: {axis}: found one value throughout, expected noise")


def read_gyro_record(
    path: str | os.PathLike[str],
    columns: Mapping[str, str] | str | os.PathLike[str] | None = None,
    units: Mapping[str, str] | None = None,
    interval: float | None = None,
) -> GyroRecord:
    """Read the record of a gyro at rest from a file.

    Args:
        path: File with the suffix of one of `gyrostat.telemetry.formats`.
        columns: Role -> column name, or a file of them.
        units: Role -> unit, where the file has none.
        interval: Time from sample to sample, s, of a file without times.

    Raises:
        InputError: The file cannot be read or used, its times do not increase by equal steps, or a
            sample is missing or is no number.
    """
    file = Path(path)
    mapping = column_map(columns, units)
    if interval is not None:
        if "time" in mapping.columns:
            raise fault(file, "an interval and a column for time", "one of the two")
        mapping = replace(mapping, interval=interval)
    absent = () if mapping.interval is None else ("time", "time_fine")
    choose = partial(_choose, columns=mapping.columns, units=mapping.units, absent=absent)
    request = Request(choose, MOST_SAMPLES, packets=mapping.packets)
    try:
        measured = with_time(format_of(file).read(file, request), mapping.interval)
    except OSError as error:
        raise fault(file, f"an unreadable file ({error.strerror})", "a record") from None
    for role, values in measured.values.items():
        bad = ~np.isfinite(values)
        if bad.any():
            k = int(np.argmax(bad))
            found = "an empty cell" if measured.empty[role][k] else repr(float(values[k]))
            row, column = int(measured.rows[k]), measured.chosen[role].name
            raise fault(file, found, "a finite number", row, column)
    if measured.rows.size < 2:
        raise fault(file, counted(measured.rows.size), "at least 2")
    step = _equal_step(measured)
    roles = [role for role in measured.values if role != "time"]
    rates = [_rate(measured, role, step) for role in roles]
    # the first increment of an angle has no beginning
    return GyroRecord(file.name, step, tuple(r.split("_")[1] for r in roles), np.array(rates))


def _choose(
    header: Header, columns: Mapping[str, str], units: Mapping[str, str], absent: tuple[str, ...]
) -> dict[str, Chosen]:
    """Columns of the file, all of one kind."""
    chosen = choose_columns(header, columns, units, absent=absent, roles=ROLES)
    if absent:
        times = replace(ROLES["time"], required=False)
        found = choose_columns(header, None, {"time": "s"}, roles={"time": times})
        if found:
            name = shown(found["time"].name)
            raise fault(header.file, f"an interval and the times in {name}", "one of the two")
    kinds = {role.split("_")[0] for role in chosen if not role.startswith("time")}
    if len(kinds) != 1:
        names = listed(name for column in header.columns for name in column.names)
        wanted = "rate_x, rate_y, rate_z (or angle_..., increment_...), or an assignment in columns"
        found = f"columns for {' and '.join(sorted(kinds))}" if kinds else f"columns {names}"
        raise fault(header.file, found, f"one kind: {wanted}", header.row)
    return chosen


def _equal_step(measured: Measured) -> float:
    """Time from sample to sample, s."""
    time = measured.chosen["time"].unit.to_si(measured.values["time"])
    step = float(np.median(np.diff(time)))
    column = measured.chosen["time"].name
    steps = np.diff(time)
    late = steps <= 0.0
    if late.any():
        row = int(measured.rows[int(np.argmax(late)) + 1])
        raise fault(measured.file, "a time not after that before", "increasing times", row, column)
    gap = (steps > LARGEST_STEP * step) | (steps < step / LARGEST_STEP**2)
    if gap.any():
        k = int(np.argmax(gap))
        found = f"{steps[k]:.6g} s since the sample before"
        raise fault(
            measured.file,
            found,
            f"equal steps of {step:.6g} s: use the part of the record before or after",
            int(measured.rows[k + 1]),
            column,
        )
    return float(time[-1] - time[0]) / (time.size - 1)


def _rate(measured: Measured, role: str, step: float) -> Vector:
    """Mean rates over the intervals, rad/s."""
    values = measured.chosen[role].unit.to_si(measured.values[role])
    if role.startswith("rate"):
        return values
    if role.startswith("increment"):
        return values / step
    increments = np.diff(values)
    if np.ptp(values) <= 2.0 * np.pi * (1.0 + 1e-9) and np.any(np.abs(increments) > np.pi):
        k = int(np.argmax(np.abs(increments) > np.pi))
        raise fault(
            measured.file,
            "an angle that starts again after a turn",
            "one that goes on, or increments",
            int(measured.rows[k + 1]),
            measured.chosen[role].name,
        )
    return increments / step
