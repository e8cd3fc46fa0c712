"""Picture of the directions that `place` finds: the map of its page as a figure to edit."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from gyrostat.reports.body_sky_map import (
    AXES,
    HEAD,
    PRESENT,
    SURFACE,
    blind_shares,
    found_directions,
    paths,
)
from gyrostat.reports.colours import BAND, MARK, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.sky_map import INK, angles
from gyrostat.runs.placement_result import Placement

STYLES = {HEAD: ("o", MODEL), SURFACE: ("s", INK), PRESENT: ("x", MARK)}
"""Kind of a direction -> marker and colour."""
_SHARES = LinearSegmentedColormap.from_list("blind", ["white", BAND])


def placement_figure(result: Placement) -> Figure:
    """Draw the body directions (Mollweide projection): longitude about body z, from x.

    The darker an area, the longer a head that looks there is blind.

    Args:
        result: Directions that were found.
    """
    longitude, latitude, blind = blind_shares(result)
    with panels(width=7.4, height=4.6, subplot_kw={"projection": "mollweide"}) as (figure, axes):
        image = axes.pcolormesh(
            longitude, latitude, 100.0 * blind, cmap=_SHARES, vmin=0.0, vmax=100.0, rasterized=True
        )
        figure.colorbar(image, ax=axes, label="blind (% of the time)", shrink=0.6)
        for name, colour, directions in paths(result):
            across, up = np.array([angles(each) for each in directions]).T
            axes.plot(across, up, ".", ms=3, color=colour, label=name)
        for name, axis in AXES.items():
            axes.text(*angles(np.array(axis)), name, ha="center", va="bottom", fontsize=8)
        for name, kind, directions in found_directions(result):
            places = np.array([angles(each) for each in directions])
            marker, colour = STYLES[kind]
            style = {"marker": marker, "color": colour, "ls": "none", "mfc": "none", "mew": 1.6}
            axes.plot(*places.T, ms=8, label=name, **style)
            for number, place in enumerate(places if kind == HEAD else [], 1):
                axes.annotate(str(number), place, ha="center", va="center", fontsize=6.5)
        axes.tick_params(labelsize=7)
        axes.set_title(literal(f"{result.scenario}: {result.time_that_counts}"), fontsize=9, pad=12)
        figure.legend(loc="outside lower center", ncols=3, fontsize=7.5)
    return figure
