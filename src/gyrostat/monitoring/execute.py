"""Monitor the wheels of a spacecraft from files, resumably."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.monitoring.change.assess import Limit, assess, reference_to
from gyrostat.monitoring.change.detector import AlarmSettings
from gyrostat.monitoring.change.kinds.tachometer import Tachometer
from gyrostat.monitoring.health import Health
from gyrostat.monitoring.reading import Telemetry, first_time, read_parts
from gyrostat.monitoring.state import Progress, load_state, save_state
from gyrostat.monitoring.stream import DAY, WheelMonitor
from gyrostat.monitoring.verdict import FEWEST
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.monitoring.windows import Windows
from gyrostat.telemetry.fault import counted

PART = 200_000
"""Largest number of samples that are read at once."""
USED = "left out, it was used before"
CHECKPOINT = 30.0
"""Shortest time between two checkpoints, s."""
HOTTEST = 150.0
"""Temperature above which that of a wheel has probably another unit, °C."""
NOTES = {
    "torque": "the commanded torque drives the wheels: motor_constant is the nominal one times "
    "actual over commanded torque",
    "power": "the electrical power shows the motor torque: motor_constant is the nominal one times "
    "true over measured power above idle, and a change of the true motor constant hardly shows; a "
    "change of the idle power looks like one of the Coulomb torque; braking is left out",
    "none": "there is no motor current, electrical power or commanded torque: friction is internal "
    "to the spacecraft and does not show in speeds and rates alone; power is read if wheels.toml "
    "states idle_power and resistance",
}
"""Drive -> remark on results with it."""


@dataclass(frozen=True)
class Options:
    """How telemetry is read and divided.

    Attributes:
        columns: Role -> column, or a file of them.
        units: Role -> unit.
        window: Length of a window, s.
        alarm: Settings of alarms and classes of change.
        friction_limit: Friction torque whose day is forecast, N·m; None: no forecast.
    """

    columns: Mapping[str, str] | str | Path | None = None
    units: Mapping[str, str] | None = None
    window: float = DAY
    alarm: AlarmSettings = field(default_factory=AlarmSettings)
    friction_limit: float | None = None

    def settings(self, known: KnownWheels) -> str:
        """Text that changes with all that the rows depend on."""
        columns = self.columns
        if isinstance(columns, str | Path):
            columns = Path(columns).read_text(encoding="utf-8")
        axes = None if known.axes is None else known.axes.tolist()
        inertia = None if known.inertia is None else known.inertia.tolist()
        rest = (known.modes_left_out, known.speed_resolution, known.power_resolution)
        return repr((known.wheels, axes, inertia, rest, columns, self.units, self.window))


def monitor_files(
    paths: Sequence[Path],
    known: KnownWheels,
    options: Options,
    *,
    state: Path | None = None,
    restart: bool = False,
    say: Callable[[str], None] = lambda message: None,
) -> Health:
    """Monitor wheels from files of telemetry.

    Files are used in the order of their first times. What a call with the same state has used
    before is left out.

    Args:
        paths: Files of telemetry.
        known: What is known of the wheels beforehand.
        options: How telemetry is read and divided.
        state: File of the state between calls, or None.
        restart: Whether to forget the state.
        say: Receives each message for the user.

    Raises:
        InputError: A file cannot be used, or the state is of other wheels or options.
    """
    names = [path.name for path in paths]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"telemetry: found two files named {name}, expected different names")
    if state is not None and restart:
        state.unlink(missing_ok=True)
    monitor = WheelMonitor(known, window=options.window)
    settings = options.settings(known)
    progress = Progress(settings) if state is None else load_state(state, monitor, settings)
    labels = {path: progress.label(path) for path in paths}
    fresh = [p for p in paths if _size(p) != progress.sizes.get(labels[p])]
    for path in paths:
        if path not in fresh:
            say(f"{path}: {USED}")
    order = {p: first_time(p, known, options.columns, options.units) for p in fresh}
    saved = time.monotonic()
    for path in sorted(fresh, key=lambda p: order[p]):
        label = labels[path]
        if label != progress.latest:
            monitor.begin_file()
            progress.latest = label
        count, repeats = 0, monitor.clock.repeats
        for part in _new_parts(path, known, options, progress, label):
            _check_drive(path, progress, part.drive)
            monitor.drive = part.drive
            monitor.add(part.samples)
            count += len(part.samples)
            progress.rows[label] = int(part.rows[-1])
            progress.sums[label] = (progress.sums.get(label, 0) + part.samples.checksum()) % 2**64
            if state is not None and time.monotonic() - saved > CHECKPOINT:
                save_state(state, monitor, progress)
                saved = time.monotonic()
                say(f"{path.name}: row {part.rows[-1]}")
        progress.sizes[label] = _size(path)
        if not count:
            say(f"{path}: {USED}")
        elif monitor.clock.repeats - repeats == count:
            progress.late.append(label)
    if state is not None:
        save_state(state, monitor, progress)
    return _health(monitor, progress, options)


def _new_parts(
    path: Path, known: KnownWheels, options: Options, progress: Progress, label: str
) -> Iterator[Telemetry]:
    """Parts of a file without the rows that were used before, which must still be the same."""
    skip, used, seen = progress.rows.get(label, 0), progress.sums.get(label, 0), 0
    for part in read_parts(path, known, options.columns, options.units, part=PART):
        old = part.rows <= skip
        if old.any():
            seen = (seen + part.samples.part(old).checksum()) % 2**64
        if not old.all():
            _check_same(path, seen == used, skip)
            yield part.part(~old) if old.any() else part
    _check_same(path, seen == used, skip)


def _check_same(path: Path, same: bool, rows: int) -> None:
    if not same:
        raise InputError(
            f"{path}: found other values up to row {rows} than an earlier call used, expected the "
            "same: start again with --restart and all telemetry, or give another --out"
        )


def _size(path: Path) -> list[int]:
    try:
        status = path.stat()
        return [status.st_size, status.st_mtime_ns]
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise InputError(f"{path}: found {reason}, expected a file of telemetry") from None


def _check_drive(path: Path, progress: Progress, drive: str) -> None:
    if progress.drive not in ("", drive):
        raise InputError(
            f"{path}: found {drive} as the drive of the wheels, expected {progress.drive} as in "
            "the telemetry before: monitor it in another --out"
        )
    progress.drive = drive


def _health(monitor: WheelMonitor, progress: Progress, options: Options) -> Health:
    clock = monitor.clock
    telemetry: dict[str, Any] = {
        "files": sorted(progress.rows),
        "rows": sum(progress.rows.values()),
        "last_time": clock.last if np.isfinite(clock.last) else None,
        "drive": progress.drive,
        "repeats": clock.repeats,
        "resets": clock.resets,
        "wild_times": clock.wild,
        "without_time": clock.without_time,
        "window": monitor.window,
    }
    notes = [NOTES[progress.drive]] if progress.drive in NOTES else []
    if progress.late:
        names = ", ".join(progress.late[:3]) + (", ..." if len(progress.late) > 3 else "")
        notes.append(
            f"all times of {names} had been reached by other telemetry: left out; to use telemetry "
            "that came late, start again with --restart and all files"
        )
    if clock.repeats:
        notes.append(f"{counted(clock.repeats)} with times that earlier ones had reached: left out")
    if clock.resets:
        notes.append(
            f"{clock.resets} resets of the clock: windows follow one that goes on; if these are "
            "rows out of order, sort them"
        )
    if clock.wild:
        notes.append(
            f"{counted(clock.wild)} with times an hour or more off those around them: left out"
        )
    windows = monitor.windows()
    if not len(windows):
        lasts = f"the telemetry lasts {clock.last - clock.first:.4g} s"
        if not np.isfinite(clock.last):
            lasts = "no sample has a time that others confirm"
        notes.append(
            f"no window yet: {lasts}, and a window needs {FEWEST * monitor.block:g} s; is the unit "
            "of the times right?"
        )
    low, high = windows["speed_min"], windows["speed_max"]
    held = (high != 0.0) & (high - low <= 1e-12 * np.abs(high))
    if held.any():
        names, count = _wheels_and_windows(windows, held)
        notes.append(
            f"the speed of {names} has one value in {count}: is it held, or is its sensor stuck?"
        )
    stuck = windows["stuck_blocks"] > 0
    if stuck.any():
        names, count = _wheels_and_windows(windows, stuck)
        notes.append(
            f"in {count}, a sensor of speed or drive of {names} holds one value for minutes while "
            "the other one changes: these minutes are left out"
        )
    for text in sorted({*windows["held_as_stated"].tolist()} - {""}):
        names, count = _wheels_and_windows(windows, windows["held_as_stated"] == text)
        notes.append(
            f"{text.replace(', ', ' and ')} of {names} in {count}: held as stated, as the rounding "
            "of the drive makes estimates less certain than that; a wrong stated value, or a "
            "change, does not show there, and makes the Coulomb torque wrong"
        )
    warmest = np.nanmax(windows["temperature_max"], initial=-np.inf)
    if warmest > HOTTEST:
        notes.append(f"temperatures of up to {warmest:.4g} °C: is their unit right?")
    if monitor.known.axes is None and len(monitor.known.wheels) > 3:
        notes.append(
            "the axes of the wheels are not known: speeds that do not turn the body are used as if "
            "friction could not move them"
        )
    if monitor.latest.contradicted:
        notes.append(
            "body rates and wheel speeds fit an inertia that differs from the stated one by "
            f"{100.0 * monitor.latest.difference:.0f} %: check units and signs of rates and "
            "speeds, axes and inertia; the scales of the speeds are not used"
        )
    wheels = monitor.known.wheels
    limit = options.friction_limit
    settings = replace(options.alarm, window=monitor.window / DAY)
    conditions = assess(
        windows,
        settings,
        {wheel.name: reference_to(wheel) for wheel in wheels},
        {} if limit is None else {wheel.name: Limit(limit) for wheel in wheels},
    )
    if len(conditions) > 1 and all(each.probable == Tachometer.name for each in conditions):
        notes.append(
            "all wheels seem to have a tachometer fault: a change of the gyro's scale or of the "
            "body's inertia looks like this"
        )
    return Health(windows, telemetry, tuple(notes), tuple(conditions), settings)


def _wheels_and_windows(windows: Windows, rows: NDArray[np.bool_]) -> tuple[str, str]:
    """Names of the wheels of some rows, and the number of rows in words."""
    names = ", ".join(dict.fromkeys(windows["wheel"][rows].tolist()))
    return names, counted(int(rows.sum()), "window")
