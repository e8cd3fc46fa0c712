"""Pictures of the answers of `feasible` and `recover`."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.failures import Holdable, Recovery
from gyrostat.reports.chart_figure import figure_of
from gyrostat.reports.colours import BAND, MARK, MODEL
from gyrostat.reports.drawing import panels
from gyrostat.reports.feasibility import Drawn, share, sky_maps
from gyrostat.reports.recovery import recovery_charts
from gyrostat.reports.sky_map import THIN, angles, ring_of

ROWS = 180
"""Number of rows of a map from pole to pole."""
HEIGHT = 3.6
"""Height of a map, inches."""
_ONE = ListedColormap([BAND])


def holdable_figure(answer: Holdable) -> Figure:
    """Draw the inertial directions at which a boresight can be held (Mollweide projection).

    Args:
        answer: Answer of `gyrostat.feasible`; without a boresight, there is a map of each body
            axis.
    """
    maps = sky_maps(answer)
    if not maps:
        raise InputError("plot: found no sky map, expected an answer of gyrostat.feasible")
    height = HEIGHT * len(maps)
    mollweide = {"subplot_kw": {"projection": "mollweide"}, "squeeze": False}
    with panels(len(maps), width=6.4, height=height, **mollweide) as (figure, grid):
        for axes, drawn in zip(grid[:, 0], maps, strict=True):
            _sky(axes, drawn)
        grid[0, 0].legend(loc="upper right", bbox_to_anchor=(1.02, 1.08), fontsize=7.5)
    return figure


def _sky(axes: Axes, drawn: Drawn) -> None:
    """One map."""
    sky = drawn.sky
    longitude, latitude, cells = sky.grid(ROWS)
    filled = np.where(cells, 1.0, np.nan)
    axes.pcolormesh(longitude, latitude, filled, cmap=_ONE, rasterized=True)
    for low, high in sky.bands:
        if high - low < THIN:
            for piece in ring_of(sky.momentum_direction, 0.5 * (low + high)):
                axes.plot(*piece, color=BAND, lw=2.5)
    marks: list[tuple[str, Vector | None, str, str]] = [
        ("target", drawn.target, "x", MARK),
        ("nearest", drawn.nearest, "o", MODEL),
    ]
    if np.any(sky.momentum_direction):
        marks.append(("total momentum", sky.momentum_direction, "*", "k"))
    for name, direction, marker, colour in marks:
        if direction is not None:
            style = {"ms": 8, "mfc": "none", "mew": 1.6, "color": colour, "ls": "none"}
            axes.plot(*angles(direction), marker=marker, label=name, **style)
    axes.tick_params(labelsize=7)
    axes.set_axisbelow(False)  # longitudes are written within the map
    boresight = ", ".join(f"{value:g}" for value in np.round(sky.boresight, 4))
    axes.set_title(
        f"body direction {boresight}: {share(sky.fraction)} of the sky", fontsize=9, pad=12
    )


def recovery_figure(recovery: Recovery) -> Figure:
    """Draw error, body rate, wheel momenta and torques over the time since the failure.

    Args:
        recovery: Recovery with histories.

    Raises:
        InputError: No controller can reach the target, so that nothing was simulated.
    """
    histories = recovery.histories
    if histories is None:
        raise InputError(f"plot: found no histories: {recovery.reason}")
    names = [str(name) for name in np.asarray(histories.coordinates["wheel"].values)]
    return figure_of(recovery_charts(histories.arrays(), names, recovery.settle))
