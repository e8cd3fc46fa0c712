"""Sky maps as SVG."""

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from gyrostat.core.directions import across
from gyrostat.core.types import Matrix, Vector
from gyrostat.failures import SkyMap
from gyrostat.reports.colours import BAND, MARK, MODEL

ROWS = 360
"""Number of rows of a drawn map from pole to pole, each with twice as many cells."""
THIN = np.radians(1.0)
"""Width below which a band is drawn as a line, rad."""
INK, PAPER, QUIET = "#22262b", "#f3f4f6", "#6b7077"
WIDTH, HEIGHT, ACROSS, UP = 760, 480, 346.0, 173.0
"""Size of the drawing, and semi-axes of the map in it, pixels."""
COLUMNS = 3
"""Number of columns of the legend."""
MIDDLE = (WIDTH / 2, UP + 24.0)
_STAR = "M0-8L1.8-2.5H7.6L2.9 .9L4.7 6.5L0 3.1L-4.7 6.5L-2.9 .9L-7.6-2.5H-1.8Z"


def sky_chart(
    sky: SkyMap, *, target: Vector | None = None, nearest: Vector | None = None
) -> Markup:
    """Draw the inertial directions at which a boresight can be held (Mollweide projection).

    J. P. Snyder, "Map projections: a working manual", 1987, section 31.

    Args:
        sky: The map.
        target: Inertial direction to point the boresight at, (3,).
        nearest: Inertial direction of the boresight at the nearest feasible attitude, (3,).

    Returns:
        SVG element.
    """
    outline = f'cx="{MIDDLE[0]:g}" cy="{MIDDLE[1]:g}" rx="{ACROSS:g}" ry="{UP:g}"'
    parts = [
        f'<svg class="sky" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'width="{WIDTH}" font-family="sans-serif" font-size="15" role="img" '
        'aria-label="sky map: directions that can be held">',
        f'<ellipse {outline} fill="{PAPER}"/>',
        f'<path class="bands" fill="{BAND}" d="{_areas(sky)}"/>',
    ]
    for low, high in sky.bands:
        if high - low < THIN:
            path = circle(sky.momentum_direction, 0.5 * (low + high))
            parts.append(
                f'<path class="bands" fill="none" stroke="{BAND}" stroke-width="3" d="{path}"/>'
            )
    parts += [grid(), f'<ellipse {outline} fill="none" stroke="{QUIET}"/>']
    square = f'<path fill="{BAND}" d="M-5-5H5V5H-5Z"/>'
    marks: list[tuple[str, str, Vector | None]] = [("can be held", square, None)]
    if np.any(sky.momentum_direction):
        opposite = f'<path stroke="{INK}" stroke-width="2" d="M-5 0H5"/>'
        star = f'<path fill="{INK}" d="{_STAR}"/>'
        marks.append(("total momentum", star, sky.momentum_direction))
        marks.append(("opposite direction", opposite, -sky.momentum_direction))
    if target is not None:
        cross = f'<path stroke="{MARK}" stroke-width="1.8" d="M-5-5L5 5M5-5L-5 5"/>'
        marks.append(("target", cross, target))
    if nearest is not None:
        ring = f'<circle r="6.5" fill="none" stroke="{MODEL}" stroke-width="2.2"/>'
        marks.append(("nearest", ring, nearest))
    for number, (label, mark, direction) in enumerate(marks):
        if direction is not None:
            inner = translate(f'<g class="mark">{mark}</g>', *pixels(*angles(direction))[0])
            parts.append(inner.replace("<g", f'<g data-mark="{label}"', 1))
        row, column = divmod(number, COLUMNS)
        text = f'<text x="14" y="5" fill="{INK}">{label}</text>'
        place = 45.0 + column * WIDTH / COLUMNS, HEIGHT - 66.0 + 32.0 * row
        entry = translate(f'<g class="mark">{mark}</g>{text}', *place)
        parts.append(entry.replace("<g", '<g class="legend"', 1))
    return Markup("".join([*parts, "</svg>"]))


def translate(mark: str, x: float, y: float) -> str:
    """Mark at a place of the drawing."""
    return f'<g transform="translate({x:.1f} {y:.1f})">{mark}</g>'


def angles(direction: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Longitude and latitude of directions (..., 3), rad."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))


def pixels(longitude: NDArray[np.float64], latitude: NDArray[np.float64]) -> Matrix:
    """Places in the drawing, (N, 2), of longitudes and latitudes, rad; (N,) or scalars."""
    longitude, latitude = np.atleast_1d(*np.broadcast_arrays(longitude, latitude))
    target = np.pi * np.sin(latitude)
    # 2 t + sin 2t = pi sin(latitude), by bisection: Newton's method fails at the poles
    low, high = np.full(target.shape, -0.5 * np.pi), np.full(target.shape, 0.5 * np.pi)
    for _ in range(40):
        middle = 0.5 * (low + high)
        below = 2.0 * middle + np.sin(2.0 * middle) < target
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    x = ACROSS * longitude / np.pi * np.cos(low)
    return np.stack([MIDDLE[0] + x, MIDDLE[1] - UP * np.sin(low)], axis=-1)


def _line(points: Matrix) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points.tolist())


def _areas(sky: SkyMap) -> str:
    """Path around the feasible cells: one closed curve for each area that widens steadily."""
    _, latitude, cells = sky.grid(ROWS)
    half = 0.5 * np.pi / ROWS
    areas: list[list[tuple[float, float, float]]] = []
    open_areas: list[list[tuple[float, float, float]]] = []
    for middle, row in zip(latitude, cells, strict=True):
        edges = np.flatnonzero(np.diff(np.r_[False, row, False])) * np.pi / ROWS - np.pi
        runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
        fits = len(runs) == len(open_areas) and all(
            a < area[-1][1] and b > area[-1][0]
            for (a, b), area in zip(runs, open_areas, strict=True)
        )
        if not fits:
            for area in open_areas:
                area.append((*area[-1][:2], middle - half))
            open_areas = [[(a, b, middle - half)] for a, b in runs]
            areas += open_areas
        for (a, b), area in zip(runs, open_areas, strict=True):
            area.append((a, b, middle))
    for area in open_areas:
        area.append((*area[-1][:2], 0.5 * np.pi))
    paths = []
    for area in areas:
        left, right, height = np.array(area).T
        around = np.concatenate([left, right[::-1]]), np.concatenate([height, height[::-1]])
        paths.append(f"{_line(pixels(*around))}Z")
    return "".join(paths)


def circle(pole: Vector, angle: float) -> str:
    """Path through the directions at a given angle, rad, from a pole."""
    return "".join(_line(pixels(*piece)) for piece in ring_of(pole, angle))


def ring_of(pole: Vector, angle: float) -> list[tuple[Vector, Vector]]:
    """Longitudes and latitudes, rad, at a given angle, rad, from a pole, in pieces."""
    normal = across(pole)
    around = np.linspace(0.0, 2.0 * np.pi, 361)
    ring = np.outer(np.cos(around), normal) + np.outer(np.sin(around), np.cross(pole, normal))
    longitude, latitude = angles(np.cos(angle) * pole + np.sin(angle) * ring)
    # no line across the map where the circle crosses its edge
    jumps = np.flatnonzero(np.abs(np.diff(longitude)) > np.pi) + 1
    return list(zip(np.split(longitude, jumps), np.split(latitude, jumps), strict=True))


def grid() -> str:
    """Meridians and parallels with their degrees."""
    latitude = np.radians(np.arange(-90, 91, 5))
    paths, texts = [], []
    for degrees in range(-120, 121, 60):
        paths.append(_line(pixels(np.radians(degrees), latitude)))
        ((x, y),) = pixels(np.radians(degrees), np.zeros(()))
        texts.append(f'<text x="{x + 3:.1f}" y="{y - 3:.1f}">{degrees}°</text>')
    for degrees in range(-60, 61, 30):
        ends = pixels(np.array([-np.pi, np.pi]), np.radians(degrees))
        paths.append(_line(ends))
        x, y = ends[0]
        texts.append(f'<text x="{x - 5:.1f}" y="{y + 3:.1f}" text-anchor="end">{degrees}°</text>')
    lines = f'fill="none" stroke="{QUIET}" stroke-width="0.5" opacity="0.4" d="{"".join(paths)}"'
    return f'<path {lines}/><g fill="{QUIET}" class="degrees" font-size="12">{"".join(texts)}</g>'
