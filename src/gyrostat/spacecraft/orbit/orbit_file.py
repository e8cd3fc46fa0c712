"""Orbit files: CSV, and the Orbit Ephemeris Message (OEM) of the CCSDS in its keyword form.

CCSDS 502.0-B, "Orbit Data Messages", section 5; positions in km, velocities in km/s.
"""

import csv
import io
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.spacecraft.orbit.elements import Trajectory
from gyrostat.spacecraft.orbit.ephemeris import DEGREE, Ephemeris
from gyrostat.spacecraft.orbit.frames import States
from gyrostat.spacecraft.orbit.time_scales import Epoch, Julian, read_utc

HEADER = ("time", "x", "y", "z", "vx", "vy", "vz")
"""Columns of a CSV file: s after the epoch of the run, m, m/s."""
OEM = "CCSDS_OEM_VERS"
"""First word of an OEM file."""
_FRAMES = {"GCRF": "GCRS", "ICRF": "GCRS", "EME2000": "EME2000", "TEME": "TEME"}


@final
@dataclass(frozen=True)
class OrbitFile:
    """Orbit from a file.

    Attributes:
        segments: Segments of the file in its order, at least one.
        where: Place for error messages, such as the name of the file.
    """

    segments: tuple[Ephemeris, ...]
    where: str = "orbit file"

    @classmethod
    def read(cls, text: str, frame: str = "GCRS", where: str = "orbit file") -> "OrbitFile":
        """Read an OEM file, or a CSV file with the header time,x,y,z,vx,vy,vz.

        Args:
            text: Content of the file.
            frame: Axes of a CSV file, one of `frames.FRAMES`.
            where: Place for error messages, such as the name of the file.

        Raises:
            InputError: A row is unreadable, or the frame, the centre or the time system is none of
                those expected.
        """
        if text.lstrip().startswith(OEM):
            return cls(_oem(text, where), where)
        return cls((_csv(text, frame, where),), where)

    @property
    def epoch(self) -> str | None:
        """Time of the first row, UTC; None for a CSV file, whose times count from any epoch."""
        return self.segments[0].epoch

    @property
    def period(self) -> float:
        """Period of the ellipse of the first row, s."""
        return self.segments[0].period

    def trajectory(self, epoch: Epoch, end: float) -> Trajectory:
        """Orbit from the epoch on, GCRS, by the first segment that covers the run.

        Args:
            epoch: Epoch of the run.
            end: Last time, s.

        Raises:
            InputError: No segment covers the run.
        """
        spans = []
        for segment in self.segments:
            times = segment.times_after(epoch)
            if len(self.segments) == 1 or (times[0] <= 0.0 and times[-1] >= end):
                return segment.trajectory(epoch, end)
            spans.append(f"{times[0]:.6g} s to {times[-1]:.6g} s")
        raise InputError(
            f"{self.where}: found the segments {', '.join(spans)} after the epoch, expected one "
            f"from 0 s to {end:.6g} s"
        )


class _Segment(NamedTuple):
    """Segment of an OEM file as read: its line, its metadata, times UTC and rows, m and m/s."""

    line: int
    keys: dict[str, str]
    texts: list[str]
    times: list[Julian]
    rows: list[list[float]]


def _csv(text: str, frame: str, where: str) -> Ephemeris:
    """Rows of a CSV file."""
    table = csv.reader(io.StringIO(text), skipinitialspace=True)
    header = tuple(name.strip() for name in next(table, []))
    if header != HEADER:
        raise InputError(
            f"{where}: found the header {','.join(header)!r}, expected {','.join(HEADER)!r}"
        )
    rows = []
    for cells in table:
        if not cells:
            continue
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            rows.append([])
        if len(rows[-1]) != len(HEADER):
            raise InputError(
                f"{where}, line {table.line_num}: found {','.join(cells)!r}, expected seven numbers"
            )
    values = np.array(rows, dtype=float).reshape(-1, len(HEADER))
    states = States(values[:, 1:4], values[:, 4:])
    return Ephemeris(values[:, 0], states, frame=frame, where=where)


def _oem(text: str, where: str) -> tuple[Ephemeris, ...]:
    """Segments of an OEM file."""
    segments: list[_Segment] = []
    part = "header"
    for number, line in enumerate((line.strip() for line in text.splitlines()), 1):
        label = f"{where}, line {number}"
        if not line or line.startswith("COMMENT"):
            continue
        if line == "META_START":
            part = "metadata"
            segments.append(_Segment(number, {}, [], [], []))
        elif line in ("META_STOP", "COVARIANCE_STOP"):
            part = "states"
        elif line == "COVARIANCE_START":
            part = "covariance"
        elif part == "metadata":
            key, sign, value = (word.strip() for word in line.partition("="))
            if not sign:
                raise InputError(f"{label}: found {line!r}, expected KEY = value")
            segments[-1].keys[key] = value
        elif part == "states":
            if not segments:
                raise InputError(f"{label}: found {line!r}, expected META_START")
            _add_state(segments[-1], line, label, where)
    if not any(segment.rows for segment in segments):
        raise InputError(f"{where}: found no states, expected an OEM file with segments")
    return tuple(_ephemeris(segment, where) for segment in segments if segment.rows)


def _add_state(segment: _Segment, line: str, label: str, where: str) -> None:
    """Read a line of a time, a state and perhaps an acceleration, which is left out."""
    system = segment.keys.get("TIME_SYSTEM")
    if system != "UTC":
        raise InputError(
            f"{where}, segment at line {segment.line}: found the TIME_SYSTEM {system}, expected UTC"
        )
    stamp, *words = line.split()
    try:
        values = [1e3 * float(word) for word in words]
    except ValueError:
        values = []
    if len(values) not in (6, 9):
        raise InputError(f"{label}: found {line!r}, expected a time and six numbers")
    time = stamp.removesuffix("Z")
    segment.texts.append(time)
    segment.times.append(read_utc(time, label))
    segment.rows.append(values[:6])


def _ephemeris(segment: _Segment, where: str) -> Ephemeris:
    """Rows of a segment as an orbit."""
    label, keys = f"{where}, segment at line {segment.line}", segment.keys
    centre, frame_name = keys.get("CENTER_NAME", ""), keys.get("REF_FRAME", "")
    if centre.upper() != "EARTH":
        raise InputError(f"{label}: found the CENTER_NAME {centre!r}, expected EARTH")
    frame = "ITRF" if frame_name.startswith("ITRF") else _FRAMES.get(frame_name)
    if frame is None:
        raise InputError(
            f"{label}: found the REF_FRAME {frame_name!r}, expected one of "
            f"{', '.join(_FRAMES)}, ITRF"
        )
    degree = keys.get("INTERPOLATION_DEGREE", str(DEGREE))
    if not degree.isdecimal():
        raise InputError(f"{label}: found the INTERPOLATION_DEGREE {degree!r}, expected a number")
    rows, text = np.array(segment.rows), f"{segment.texts[0]}Z"
    start = Epoch.of(text)
    return Ephemeris(
        np.array([start.seconds_to(time) for time in segment.times]),
        States(rows[:, :3], rows[:, 3:]),
        frame=frame,
        degree=int(degree),
        where=label,
        epoch=text,
    )
