"""Speed from the times of a tachometer's edges, as an alternative to their counts."""

import math
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_text
from gyrostat.telemetry.fault import counted, fault
from gyrostat.telemetry.record import Record

LARGEST_FILE = 1_000_000_000
"""Largest file of edge times, bytes."""
LONGEST = 2.5
"""Largest time between two edges for a known angle in between, in usual sample intervals."""


def read_edges(path: str | os.PathLike[str]) -> NDArray[np.float64]:
    """Read the times of a tachometer's edges, s, one per line; a header line is allowed.

    Args:
        path: Text file.

    Raises:
        InputError: The file is not a regular file or cannot be read, or a line is not a finite
            number.
    """
    file = Path(path)
    times = []
    text = read_text(file, "edge times, one per line", LARGEST_FILE)
    for row, line in enumerate(text.splitlines(), 1):
        cell = line.strip().rstrip(",;")
        if not cell or cell.startswith("#"):
            continue
        try:
            time = float(cell)
        except ValueError:
            if times or row > 1:
                raise fault(file, repr(cell[:40]), "a time in s", row) from None
            continue
        if not math.isfinite(time):
            raise fault(file, repr(cell[:40]), "a finite time in s", row)
        times.append(time)
    return np.array(times)


def angle_at(
    name: str, time: NDArray[np.float64], edges: NDArray[np.float64], pulses: int
) -> NDArray[np.float64]:
    """Absolute angle turned by a wheel at some times, from a train of edges.

    The angle is exact at every edge. Between edges it follows a monotone cubic (Fritsch and Carlson
    1980).

    Args:
        name: Name of the record, for messages.
        time: Times, (N,), s.
        edges: Increasing times of the edges, (E,), s.
        pulses: Edges per revolution.

    Returns:
        Angles, (N,), rad; NaN if the nearest edges are more than `LONGEST` sample intervals apart.

    Raises:
        InputError: There are fewer than three edges, edges do not increase, or `pulses` is not
            positive.
    """
    from scipy.interpolate import PchipInterpolator

    if pulses < 1:
        raise InputError(f"{name}: pulses: found {pulses}, expected at least 1 per turn")
    if len(edges) < 3:
        raise InputError(f"{name}: edges: found {counted(len(edges), 'edge')}, expected at least 3")
    late = np.flatnonzero(~(np.diff(edges) > 0.0))
    if late.size:
        row = int(late[0]) + 1
        raise InputError(
            f"{name}: edges[{row}]: found {edges[row]:.9g} s after {edges[row - 1]:.9g} s, "
            "expected increasing times"
        )
    edge_angle = 2.0 * np.pi / pulses * np.arange(len(edges))
    angle = PchipInterpolator(edges, edge_angle, extrapolate=False)
    after = np.clip(np.searchsorted(edges, time, side="right"), 1, len(edges) - 1)
    usual = float(np.median(np.diff(time)))
    valid = (time >= edges[0]) & (time <= edges[-1])
    valid &= edges[after] - edges[after - 1] <= LONGEST * usual
    return np.where(valid, angle(time), np.nan)


def record_of_edges(
    name: str,
    time: NDArray[np.float64],
    current: NDArray[np.float64],
    edges: NDArray[np.float64],
    pulses: int,
    setpoint: NDArray[np.float64] | None = None,
) -> Record:
    """Build a record from sampled current and the times of a tachometer's edges.

    Differences of the angle are mean speeds over the sample intervals. One train of edges does not
    give the sense of rotation: the speed is a magnitude (see `gyrostat.identification.read.signs`).

    Args:
        name: Name of the record.
        time: Times of the currents, (N,), s.
        current: Motor current, (N,), A.
        edges: Increasing times of the edges, (E,), s.
        pulses: Edges per revolution.
        setpoint: Commanded speed or direction, (N,), or None.

    Raises:
        InputError: As for `angle_at`.
    """
    angle = angle_at(name, time, edges, pulses)
    speed = np.concatenate([[np.nan], np.diff(angle) / np.diff(time)])
    return Record(
        name=name,
        time=time,
        current=current,
        speed=speed,
        valid=np.isfinite(speed),
        setpoint=setpoint,
        notes=(f"speed from {counted(len(edges), 'edge')}, {pulses} per turn",),
        averaged=True,
    )
