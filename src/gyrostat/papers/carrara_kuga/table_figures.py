"""Figures of the air-bearing table, corresponding to the paper's figures 7, 8, 10 and 11."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from gyrostat.papers.figures import INK, Drawing
from gyrostat.reports.colours import MARK, MODEL
from gyrostat.reports.drawing import panels

if TYPE_CHECKING:
    import xarray as xr

LAST = 400.0
"""End of the time axis, s."""
SPAN = (-15.0, 60.0)
"""Time span around the crossing, s."""
CROSSING = (
    "One run each: 5 rpm tachometer noise, gyro noise, one period of delay, c 10 % and T_s 20 % "
    "too large in the controller's model. Top, the whole error; middle, its small values; bottom, "
    "the current of the two compensators."
)


def attitude(title: str, flown: "xr.Dataset", crossing: float) -> Drawing:
    """Plot the attitude error over time, with the time of the crossing, s."""
    run = flown.isel(run=0)
    with panels(height=2.8) as (figure, axes):
        window = run.sel(time=slice(None, LAST))
        axes.plot(window.time, np.degrees(window.attitude), color=MODEL, lw=1.2)
        axes.axvline(crossing, color=MARK, lw=0.8, label="wheel reaches zero speed")
        axes.set(xlabel="time (s)", ylabel="attitude error (deg)")
        axes.legend(loc="upper right")
    largest = np.degrees(np.max(np.abs(run.attitude.values)))
    return Drawing(title, figure, f"Constant fan torque; largest error {largest:.3g} deg.")


def current(title: str, flown: "xr.Dataset", *, parts: bool) -> Drawing:
    """Plot the commanded current over time, optionally with its parts for attitude and friction."""
    lines = [("commanded_current", INK, "commanded", 1.2)]
    if parts:
        lines.append(("friction_current", MARK, "for the friction", 1.0))
        lines.append(("attitude_current", MODEL, "of the PID", 1.0))
    with panels(height=2.8) as (figure, axes):
        window = flown.isel(run=0).sel(time=slice(None, LAST))
        for name, colour, label, width in lines:
            axes.plot(window.time, 1e3 * window[name], color=colour, lw=width, label=label)
        axes.set(xlabel="time (s)", ylabel="current (mA)")
        axes.legend(loc="upper left")
    caption = "The PID part is nearly constant: it only balances the fan." if parts else ""
    return Drawing(title, figure, caption)


def crossing(lines: Mapping[str, tuple[str, str]], flights: Mapping[str, "xr.Dataset"]) -> Figure:
    """Plot attitude error and current around the crossing for several controllers.

    Args:
        lines: Name and colour of each controller.
        flights: Histories of each controller by the same key, with time relative to the crossing.
    """
    heights = [1.3, 1.3, 1.0]
    with panels(3, height=5.6, sharex=True, height_ratios=heights) as (figure, rows):
        wide, close, current = rows
        for key, (name, colour) in lines.items():
            span = flights[key].isel(run=0).sel(time=slice(*SPAN))
            for axes in (wide, close):
                axes.plot(span.time, np.degrees(span.attitude), color=colour, lw=1.3, label=name)
                axes.set_ylabel("attitude\nerror (deg)")
            if key in ("dmc_raw", "compensator"):
                current.plot(span.time, 1e3 * span.commanded_current, color=colour, lw=0.9)
        close.set_ylim(-0.25, 0.25)
        wide.legend(loc="upper right")
        current.set(xlabel="time from the crossing (s)", ylabel="current (mA)")
    return figure
