"""Figures of sky maps."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.failures import SkyMap
from gyrostat.reports.drawing import BAND, MARK, MODEL, STYLE

ROWS = 360
"""Number of cells of a drawn map from pole to pole."""
THIN = np.radians(1.0)
"""Width below which a band is drawn as a line, rad."""
INK, PAPER = "#22262b", "#f3f4f6"


def sky_figure(
    sky: SkyMap, *, target: Vector | None = None, nearest: Vector | None = None
) -> Figure:
    """Plot the inertial directions at which a boresight can be held (Mollweide projection).

    Args:
        sky: The map.
        target: Inertial direction to point the boresight at, (3,).
        nearest: Inertial direction of the boresight at the nearest feasible attitude, (3,).
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.6, 4.6))
        figure.subplots_adjust(left=0.04, right=0.96, bottom=0.1, top=0.99)
        axes = figure.add_subplot(projection="mollweide")
        longitude, latitude, cells = sky.grid(ROWS)
        axes.pcolormesh(
            longitude,
            latitude,
            cells.astype(float),
            cmap=ListedColormap([PAPER, BAND]),
            vmin=0.0,
            vmax=1.0,
            shading="nearest",
            rasterized=True,
        )
        axes.plot([], [], "s", ms=8, color=BAND, label="can be held")
        for low, high in sky.bands:
            if high - low < THIN:
                _circle(axes, sky.momentum_direction, 0.5 * (low + high))
        if np.any(sky.momentum_direction):
            _mark(axes, sky.momentum_direction, "total momentum", "*", INK)
            _mark(axes, -sky.momentum_direction, "opposite direction", "$-$", INK)
        if target is not None:
            _mark(axes, target, "target", "x", MARK)
        if nearest is not None:
            _mark(axes, nearest, "nearest", "o", MODEL)
        axes.set_xticks(np.radians(np.arange(-120, 180, 60)))
        axes.tick_params(labelsize=7, colors="#6b7077")
        axes.set_axisbelow(False)
        axes.grid(color="#6b7077", lw=0.5, alpha=0.3)
        figure.legend(loc="lower center", ncols=5, handletextpad=0.4)
    return figure


def _place(direction: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Longitude and latitude of directions (..., 3), rad."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))


def _mark(axes: Axes, direction: Vector, label: str, marker: str, color: str) -> None:
    longitude, latitude = _place(direction)
    hollow = {"fillstyle": "none", "ms": 11, "mew": 1.8} if marker == "o" else {"ms": 9, "mew": 1.2}
    axes.plot([longitude], [latitude], ls="none", marker=marker, color=color, label=label, **hollow)


def _circle(axes: Axes, pole: Vector, angle: float) -> None:
    """Draw the directions at a given angle, rad, from a pole."""
    first = np.cross(pole, np.eye(3)[int(np.argmin(np.abs(pole)))])
    first = first / np.linalg.norm(first)
    around = np.linspace(0.0, 2.0 * np.pi, 721)
    ring = np.outer(np.cos(around), first) + np.outer(np.sin(around), np.cross(pole, first))
    longitude, latitude = _place(np.cos(angle) * pole + np.sin(angle) * ring)
    # no line across the map where the circle crosses its edge
    jumps = np.flatnonzero(np.abs(np.diff(longitude)) > np.pi) + 1
    for place in zip(np.split(longitude, jumps), np.split(latitude, jumps), strict=True):
        axes.plot(*place, color=BAND, lw=2.5)
