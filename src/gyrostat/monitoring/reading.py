"""Read telemetry of wheels in flight from files, part by part.

Columns are found by their names or assigned by a file (`gyrostat.telemetry.mapping`). The roles are
`time` (and `time_fine`, added to it), for each wheel NAME `NAME_speed`, and where there are:
`NAME_current`, `NAME_power` (electrical power of wheel and drive), `NAME_torque` (commanded motor
torque), `NAME_temperature`; further `rate_x`, `rate_y`, `rate_z` (body rate), `temperature` (of all
wheels) and `mode` (a number).

The drive is the current. Without it, it is the power where idle power and resistance of
each wheel are known, as that is measured and a command is not; else the commanded torque.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError, placed
from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.power import current_of_power, lacks_of
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Chosen, Header, choose_columns
from gyrostat.telemetry.fault import fault
from gyrostat.telemetry.mapping import ColumnMap, column_map
from gyrostat.telemetry.read import format_of, with_time
from gyrostat.telemetry.record_format import Request
from gyrostat.telemetry.role import Role

SLOWEST = 300.0
"""Usual time between samples above which times have probably another unit, s."""
WHOLE = 20_000_000
"""Largest number of samples of a file that is not read in parts."""
_DATES = (
    "; dates, as in 2026-03-01T12:00:00Z, are read with [[log]] in a file of columns, which "
    "--columns-template writes"
)
Choose = Callable[[Header], Mapping[str, Chosen]]
DRIVES = ("current", "power", "torque")
"""Quantities that can be the drive."""
_RATES = ("rate_x", "rate_y", "rate_z")


def roles_of(known: KnownWheels) -> dict[str, Role]:
    """Roles that columns of the telemetry of these wheels can have."""
    roles = {
        "time": Role("time", ("time", "t"), "time", required=True, hint=_DATES),
        "time_fine": Role("time_fine", ("time_fine",), "time"),
        **{name: Role(name, (name,), "speed") for name in _RATES},
        "temperature": Role("temperature", ("temperature", "temp"), "temperature"),
        "mode": Role("mode", ("mode",), None),
    }
    for wheel in known.wheels:
        for quantity in ("speed", *DRIVES, "temperature"):
            name = f"{wheel.name}_{quantity}"
            usual = tuple(f"{wheel.name}{mark}{quantity}".casefold() for mark in "_./ ")
            roles[name] = Role(name, usual, quantity, required=quantity == "speed")
    return roles


@dataclass(frozen=True)
class Telemetry:
    """Part of a file of telemetry.

    Attributes:
        samples: Its samples; the drive is the current, also that of a power, or the commanded
            torque over the motor constant that is known beforehand, or NaN.
        rows: Number of each row in the file, (N,).
        drive: One of `DRIVES`, or "none".
    """

    samples: Samples
    rows: NDArray[np.int64]
    drive: str

    def part(self, chosen: NDArray[np.bool_]) -> "Telemetry":
        """Selected samples."""
        return Telemetry(self.samples.part(chosen), self.rows[chosen], self.drive)


def read_parts(
    path: str | os.PathLike[str],
    known: KnownWheels,
    columns: Mapping[str, str] | str | os.PathLike[str] | None = None,
    units: Mapping[str, str] | None = None,
    *,
    part: int,
) -> Iterator[Telemetry]:
    """Read a file of telemetry in parts.

    Args:
        path: File with the suffix of one of `gyrostat.telemetry.formats`.
        known: The wheels.
        columns: Role -> column name, or a file of them.
        units: Role -> unit, where the file has none.
        part: Largest number of samples of a part, where the format allows parts.

    Raises:
        InputError: The file cannot be read or used.
    """
    file = Path(path)
    mapping = column_map(columns, units)
    if mapping.interval is not None:
        raise InputError(
            f"{columns}: found interval, expected times in the telemetry: gaps are not known"
        )
    roles = roles_of(known)
    names = [wheel.name for wheel in known.wheels]
    groups = [{f"{name}_{drive}" for name in names} for drive in DRIVES]
    # a column of power that cannot be read as a current is no drive, unless it is named
    absent = {f"{name}_power" for name in names} if any(lacks_of(known)) else set[str]()

    def choose(header: Header) -> Mapping[str, Chosen]:
        chosen = choose_columns(header, mapping.columns, mapping.units, absent=absent, roles=roles)
        # drives are not read where a better one is known
        best = next((k for k, roles in enumerate(groups) if roles <= chosen.keys()), len(groups))
        unused = set().union(*groups[best + 1 :])
        return {role: column for role, column in chosen.items() if role not in unused}

    for measured in _measured(file, mapping, choose, part):
        if measured.rows.size:
            drive, samples = _samples(file, measured, known)
            yield Telemetry(samples, measured.rows, drive)


def first_time(
    path: str | os.PathLike[str],
    known: KnownWheels,
    columns: Mapping[str, str] | str | os.PathLike[str] | None = None,
    units: Mapping[str, str] | None = None,
) -> float:
    """Time of the first sample of a file, s; infinite if it has none.

    Raises:
        InputError: The file cannot be read or used, or its times decrease or are far apart.
    """
    for part in read_parts(path, known, columns, units, part=1000):
        finite = part.samples.time[np.isfinite(part.samples.time)]
        if finite.size:
            steps = np.diff(finite)
            if np.sum(np.sign(steps)) < 0.0:
                raise fault(Path(path), "times that decrease", "increasing times: sort its rows")
            if steps.size and np.median(steps) > SLOWEST:
                found = f"times {np.median(steps):.4g} s apart"
                raise fault(Path(path), found, "15 s at most: is the unit of the times right?")
            return float(finite[0])
    return np.inf


def _measured(file: Path, mapping: ColumnMap, choose: Choose, part: int) -> Iterator[Measured]:
    kind = format_of(file)
    request = Request(choose, part if kind.in_parts else WHOLE, True, mapping.packets)
    try:
        for measured in kind.parts(file, request):
            yield with_time(measured, None)
    except OSError as error:
        raise fault(file, f"an unreadable file ({error.strerror})", "telemetry") from None


def _samples(file: Path, measured: Measured, known: KnownWheels) -> tuple[str, Samples]:
    """Samples in SI units, and what drives the wheels."""
    series = {
        role: measured.chosen[role].unit.to_si(values) for role, values in measured.values.items()
    }
    names = [wheel.name for wheel in known.wheels]

    def columns(quantity: str) -> list[Vector] | None:
        roles = [f"{name}_{quantity}" for name in names]
        present = [role for role in roles if role in series]
        if present and len(present) < len(roles):
            missing = next(role for role in roles if role not in series)
            raise fault(file, f"no column for {missing}", "one for each wheel, or for none")
        return [series[role] for role in present] or None

    speed = np.column_stack(columns("speed") or [])
    present = {drive: np.column_stack(v) for drive in DRIVES if (v := columns(drive))}
    drive, values = next(iter(present.items()), ("none", np.full(speed.shape, np.nan)))
    if drive == "torque":
        values = values / np.array([wheel.motor_constant for wheel in known.wheels])
    if drive == "power":
        with placed(str(file)):
            values = current_of_power(values, speed, known)
    rates = [series[name] for name in _RATES if name in series]
    warm = columns("temperature")
    if warm is None and "temperature" in series:
        warm = [series["temperature"]] * len(names)
    return drive, Samples(
        series["time"],
        speed,
        values,
        np.column_stack(rates) if len(rates) == 3 else None,
        None if warm is None else np.column_stack(warm),
        series.get("mode"),
    )
