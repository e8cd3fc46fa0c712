"""Table of smear and jitter over wheel speed, fine where the motion changes fast."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.unit_table import RPM
from gyrostat.microvibration.disturbance_file import Structure
from gyrostat.microvibration.model import TWO_PI, WheelDisturbance
from gyrostat.microvibration.sight import NOISE_SPEEDS, line_of_sight
from gyrostat.microvibration.transfer import FrequencyResponse
from gyrostat.microvibration.transfer_file import Transfer

ERROR = 1e-3
"""Largest error of a mean square by interpolation, as a share of it."""
FLOOR = 1e-9
"""Further error as a share of the largest mean square: at antiresonances the share has no end."""
CELLS = 2 * (NOISE_SPEEDS - 1)
"""Number of cells of the table; the motion by noise is linear in each of them."""
FEWEST, MOST = 8, 1 << 15
"""Fewest and most intervals in a cell, powers of 2."""
AT_LIMIT = 64
"""Intervals in a cell from which one may contain a limit of the transfer's frequencies, beyond
which the motion counts as 0."""
CHUNK = 4000
"""Speeds that are computed at once: they share an array of (speeds, tones, 2, 6)."""
AROUND = np.concatenate([-np.geomspace(0.1, 30.0, 12)[::-1], [0.0], np.geomspace(0.1, 30.0, 12)])
"""Places about a resonance at which the table is tested, in half widths."""
_Rows = Float[np.ndarray, "rows wheels 2"]


class SightTable(NamedTuple):
    """Mean square of smear and jitter about both axes, linear between rows.

    The speeds are divided into cells of equal width, and each cell into intervals of equal width;
    an interval is found without a search. The last row of a cell has the speed of the first row of
    the next one.

    Attributes:
        lowest: Lowest speed, rad/s; below it, the motion counts as that at it.
        highest: Highest speed, rad/s.
        first: Number of the first row of each cell, and the number of rows, (cells + 1,).
        squares: Mean square by each wheel that turns forward and backward, (rows, wheels, 2), rad².
    """

    lowest: float
    highest: float
    first: Int[np.ndarray, " ends"]
    squares: _Rows


def sight_table(structure: Structure) -> SightTable:
    """Table of the motion of the line of sight by the wheels of a structure.

    Rows are added until the table is within `ERROR` of the motion halfway between its rows and at
    the frequencies that resolve the structure and the wheels.

    Raises:
        InputError: The motion changes too fast over the speed.
    """
    wheels, transfer, exposure = structure.wheels, structure.transfer, structure.exposure
    tones = [replace(w, disturbance=replace(w.disturbance, noise={})) for w in wheels]
    low, high = structure.speeds
    few = np.linspace(low, high, NOISE_SPEEDS)
    both, alone = (
        line_of_sight(each, transfer, few, exposure).mean_squares() for each in (wheels, tones)
    )
    noise = (both - alone).transpose(2, 1, 0)

    def squares(speed: Vector) -> _Rows:
        parts = np.array_split(speed, -(-len(speed) // CHUNK) or 1)
        motions = [line_of_sight(tones, transfer, part, exposure) for part in parts if len(part)]
        every = [each.mean_squares().transpose(2, 1, 0) for each in motions]
        return np.concatenate([noise[:0], *every]) + _interpolated(few, noise, speed)

    edges = np.linspace(low, high, CELLS + 1)
    cells = _refined(squares, edges, *_features(structure))
    first = np.cumsum([0, *(len(each) for each in cells)])
    return SightTable(low, high, first, np.concatenate(cells))


def _refined(
    squares: Callable[[Vector], _Rows], edges: Vector, features: Vector, jumps: Vector
) -> list[_Rows]:
    """Rows of each cell.

    Args:
        squares: Rows at some speeds.
        edges: Ends of the cells, rad/s.
        features: Speeds at which the rows are tested too, rad/s.
        jumps: Speeds at which the motion jumps, rad/s.
    """
    count = len(edges) - 1
    cells: list[Any] = [None] * count
    inside = np.searchsorted(edges, features, side="right") - 1
    tests = [features[inside == k] for k in range(count)]
    exact = _computed(squares, dict(enumerate(tests)))
    nodes = {k: np.linspace(edges[k], edges[k + 1], FEWEST + 1) for k in range(count)}
    rows = _computed(squares, nodes)
    largest = max(float(np.max(each, initial=0.0)) for each in [*rows.values(), *exact.values()])
    while rows:
        between = _computed(squares, {k: 0.5 * (nodes[k][1:] + nodes[k][:-1]) for k in rows})
        for k in list(rows):
            middles = 0.5 * (nodes[k][1:] + nodes[k][:-1])
            speed, wanted = np.r_[middles, tests[k]], np.concatenate([between[k], exact[k]])
            error = np.abs(_interpolated(nodes[k], rows[k], speed) - wanted)
            error = np.max(error - ERROR * wanted, axis=(1, 2)) - FLOOR * largest
            if len(middles) >= AT_LIMIT:
                place, at_jump = (np.searchsorted(nodes[k], each) for each in (speed, jumps))
                error[np.isin(place, at_jump)] = 0.0
            finer = np.empty((2 * len(rows[k]) - 1, *rows[k].shape[1:]))
            finer[::2], finer[1::2] = rows[k], between[k]
            if np.all(error <= 0.0):
                cells[k] = rows.pop(k)
                continue
            if len(finer) > MOST:
                raise InputError(
                    "found a line of sight that changes too fast over the wheel speed at "
                    f"{speed[np.argmax(error)] / RPM:.6g} rpm, expected modes with more damping"
                )
            rows[k], nodes[k] = finer, np.linspace(edges[k], edges[k + 1], len(finer))
    return cells


def _computed(squares: Callable[[Vector], _Rows], speeds: Mapping[int, Vector]) -> dict[int, _Rows]:
    """Rows at the speeds of some cells, computed together."""
    rows = squares(np.concatenate([*speeds.values()]))
    ends = np.cumsum([len(each) for each in speeds.values()])[:-1]
    return dict(zip(speeds, np.split(rows, ends), strict=True))


def _interpolated(nodes: Vector, rows: _Rows, speed: Vector) -> _Rows:
    """Rows at speeds between equidistant nodes."""
    place = (speed - nodes[0]) / (nodes[1] - nodes[0])
    low = np.clip(np.floor(place).astype(int), 0, len(nodes) - 2)
    share = (place - low)[:, None, None]
    return rows[low] + share * (rows[low + 1] - rows[low])


def _features(structure: Structure) -> tuple[Vector, Vector]:
    """Wheel speeds at which a tone meets a resonance, and a limit of the transfer, rad/s."""
    transfer = structure.transfer
    grid, limits = _grid(transfer), [x for x in transfer.limits if 0.0 < x < np.inf]
    disturbances = {id(each.disturbance): each.disturbance for each in structure.wheels}
    speeds, jumps = [], []
    for disturbance in disturbances.values():
        for harmonic in disturbance.harmonics:
            speeds.append(TWO_PI * grid / harmonic.number)
            jumps.append(TWO_PI * np.array(limits) / harmonic.number)
        speeds += _resonances(disturbance)
    low, high = structure.speeds

    def within(parts: list[Vector]) -> Vector:
        every = np.unique(np.concatenate([np.zeros(0), *parts]))
        return every[(every > low) & (every < high)]

    return within(speeds), within(jumps)


def _grid(transfer: Transfer) -> Vector:
    """Frequencies that resolve a transfer, Hz."""
    if isinstance(transfer, FrequencyResponse):
        return transfer.grid()
    return np.ravel(transfer.frequency[:, None] * (1.0 + transfer.damping[:, None] * AROUND))


def _resonances(disturbance: WheelDisturbance) -> list[Vector]:
    """Wheel speeds around those at which a harmonic meets a mode of the wheel, rad/s."""
    speeds = []
    for mode in disturbance.modes.values():
        for harmonic in disturbance.harmonics:
            for sense in (1.0, -1.0):
                # (h W)² - sense g h W² = n²
                square = harmonic.number * (harmonic.number - sense * mode.inertia_ratio)
                if square > 0.0:
                    speeds.append(mode.frequency / np.sqrt(square) * (1.0 + mode.damping * AROUND))
    return speeds
