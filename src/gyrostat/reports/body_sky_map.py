"""Map of the body directions: where a star tracker head is blind, and the paths of Sun and Moon."""

import numpy as np
from markupsafe import Markup

from gyrostat.core.types import Matrix, Vector
from gyrostat.reports.colours import BAND, MARK, MODEL
from gyrostat.reports.sky_map import (
    ACROSS,
    INK,
    MIDDLE,
    PAPER,
    QUIET,
    UP,
    WIDTH,
    angles,
    grid,
    pixels,
    translate,
)
from gyrostat.runs.placement import margins
from gyrostat.runs.placement_result import Placement

CELL = 5
"""Size of the cells of the map, degrees."""
TIMES = 1000
"""Largest number of times from which the shares are counted."""
SHADES = (0.001, 0.1, 0.3, 0.5, 0.7, 0.9, 0.999)
"""Lower ends of the shares of time with one shade."""
DOTS = 300
"""Largest number of dots of a path."""
HEIGHT = 400
AXES = {
    **{"+x": (1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0), "+z": (0.0, 0.0, 1.0)},
    **{"-y": (0.0, -1.0, 0.0), "-z": (0.0, 0.0, -1.0)},
}
"""Body axes that are named on the map; -x is its edge."""
HEAD, SURFACE, PRESENT = "head", "surface", "present"
"""Kinds of directions on the map."""


def body_sky_chart(result: Placement) -> tuple[Markup, list[tuple[Markup, str]]]:
    """Draw the map of the body directions (Mollweide projection), SVG, and its legend.

    Longitude is about body z, from x; the darker an area, the longer a head there is blind.

    Args:
        result: Directions that were found.

    Returns:
        The map, and each mark with its meaning.
    """
    outline = f'cx="{MIDDLE[0]:g}" cy="{MIDDLE[1]:g}" rx="{ACROSS:g}" ry="{UP:g}"'
    parts = [
        f'<svg class="sky" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" font-family="sans-serif" role="img" aria-label="map of body directions">',
        f'<ellipse {outline} fill="{PAPER}"/>',
        *_shades(result),
        grid(),
        f'<ellipse {outline} fill="none" stroke="{QUIET}"/>',
    ]
    legend = []
    for name, colour, directions in paths(result):
        mark = f'<circle r="3" fill="{colour}"/>'
        parts += [translate(mark, *_place(direction)) for direction in directions]
        legend.append((name, mark))
    for name, axis in AXES.items():
        x, y = _place(np.array(axis))
        parts.append(
            f'<text x="{x:.1f}" y="{y - 12:.1f}" text-anchor="middle" fill="{INK}" '
            f'stroke="{PAPER}" stroke-width="3" paint-order="stroke">{name}</text>'
        )
    for name, marks, directions in _directions(result):
        placed = zip(marks, directions, strict=True)
        parts += [
            translate(f'<g class="mark">{mark}</g>', *_place(direction))
            for mark, direction in placed
        ]
        legend.append((name, marks[0]))
    drawn = [
        (Markup(f'<svg width="20" height="20" viewBox="-10 -10 20 20">{mark}</svg>'), name)
        for name, mark in legend
    ]
    return Markup("".join([*parts, "</svg>"])), drawn


def paths(result: Placement) -> list[tuple[str, str, Matrix]]:
    """Name, colour and directions of Sun, Earth and Moon."""
    sky = result.sky
    rows = [
        ("Sun, in sunlight", "#e0a100", sky.sun[sky.sunlight > 0.0]),
        ("centre of the Earth", "#3f7f4f", sky.earth),
        ("Moon, not behind the Earth", "#8a8f98", sky.moon[sky.moonlit]),
    ]
    return [
        (
            name,
            colour,
            directions[np.unique(np.linspace(0, len(directions) - 1, DOTS).astype(int))],
        )
        for name, colour, directions in rows
        if len(directions)
    ]


def found_directions(result: Placement) -> list[tuple[str, str, Matrix]]:
    """Name, kind and directions of what was found, and of the heads of the scenario."""
    best, present = result.best[-1].directions, result.present
    rows = [(f"best {len(best)} head{'s' if len(best) > 1 else ''}", HEAD, best)]
    for name, surface in (("radiator", result.radiator), ("panel", result.panel)):
        if surface is not None:
            rows.append((f"normal of the {name}", SURFACE, surface.direction[None]))
    if present is not None:
        # last: where a surface is best, there is often a head already
        rows.append(("heads of the scenario", PRESENT, present.directions))
    return rows


def _directions(result: Placement) -> list[tuple[str, list[str], Matrix]]:
    """Name, mark of each and directions of what was found."""
    ring = f'<circle r="8" fill="white" stroke="{MODEL}" stroke-width="2.2"/>'
    square = f'<rect x="-8" y="-8" width="16" height="16" fill="white" stroke="{INK}"/>'
    cross = f'<path stroke="{MARK}" stroke-width="2" d="M-5-5L5 5M5-5L-5 5"/>'
    rows = []
    for name, kind, directions in found_directions(result):
        count = len(directions)
        marks = [cross] * count
        if kind == HEAD:
            marks = [ring + _letter(str(k)) for k in range(1, count + 1)]
        elif kind == SURFACE:
            marks = [square + _letter(name.split()[-1][0].upper())] * count
        rows.append((name, marks, directions))
    return rows


def _letter(text: str) -> str:
    return f'<text y="4" text-anchor="middle" font-size="12" fill="{INK}">{text}</text>'


def _place(direction: Vector) -> Vector:
    return pixels(*angles(direction))[0]


def blind_shares(result: Placement) -> tuple[Vector, Vector, Matrix]:
    """Longitudes and latitudes of the middles of cells, rad, and shares of time blind there."""
    latitude = np.radians(np.arange(-90, 90, CELL) + 0.5 * CELL)
    longitude = np.radians(np.arange(-180, 180, CELL) + 0.5 * CELL)
    east, north = np.meshgrid(longitude, latitude)
    cells = np.stack(
        [np.cos(north) * np.cos(east), np.cos(north) * np.sin(east), np.sin(north)], axis=-1
    )
    margin = margins(result.sky.thinned(TIMES), cells.reshape(-1, 3), result.exclusion)
    blind = np.mean(margin < 0.0, axis=0)
    for cone in result.blocked:
        blind[cells.reshape(-1, 3) @ cone.direction >= np.cos(cone.angle)] = 1.0
    return longitude, latitude, blind.reshape(east.shape)


def _shades(result: Placement) -> list[str]:
    """Areas in which a head is blind for shares of the time."""
    longitude, latitude, blind = blind_shares(result)
    levels = np.searchsorted(SHADES, blind, side="right")
    areas: list[list[str]] = [[] for _ in SHADES]
    half = np.radians(0.5 * CELL)
    for middle, row in zip(latitude, levels, strict=True):
        ends = np.flatnonzero(np.diff(row)) + 1
        for first, last in zip(np.r_[0, ends], np.r_[ends, len(row)], strict=True):
            if row[first] > 0:
                west, edge = longitude[first] - half, longitude[last - 1] + half
                areas[row[first] - 1].append(_band(west, edge, middle - half, middle + half))
    return [
        f'<path fill="{BAND}" fill-opacity="{0.12 + 0.12 * k:.2f}" d="{"".join(cells)}"/>'
        for k, cells in enumerate(areas)
        if cells
    ]


def _band(west: float, east: float, south: float, north: float) -> str:
    """Closed path around a part of a parallel."""
    around = np.array([west, east, east, west]), np.array([south, south, north, north])
    return f"M{'L'.join(f'{x:.1f} {y:.1f}' for x, y in pixels(*around).tolist())}Z"
