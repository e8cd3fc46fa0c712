"""Figures of the air-bearing table, like the paper's figures 7, 8, 10 and 11."""

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat._types import Vector
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import MARK, MODEL, STYLE

if TYPE_CHECKING:
    from gyrostat.papers.carrara_kuga.table import TableRun

LAST = 400.0
"""s: end of the time axis."""


def attitude_drawing(title: str, flown: "TableRun") -> Drawing:
    """Attitude error over time, the crossing marked."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 2.8), layout="constrained")
        axes = figure.subplots()
        shown = flown.time <= LAST
        axes.plot(flown.time[shown], np.degrees(flown.attitude[0, shown]), color=MODEL, lw=1.2)
        axes.axvline(flown.crossings()[0], color=MARK, lw=0.8, label="wheel reaches zero speed")
        axes.set_xlabel("time (s)")
        axes.set_ylabel("attitude error (deg)")
        axes.legend(loc="upper right")
    largest = np.degrees(np.max(np.abs(flown.attitude[0])))
    return Drawing(title, figure, f"Constant fan torque; largest error {largest:.3g} deg.")


def current_drawing(title: str, flown: "TableRun", *, parts: bool) -> Drawing:
    """Commanded current over time, with its two parts where asked."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 2.8), layout="constrained")
        axes = figure.subplots()
        shown = flown.time <= LAST
        time = flown.time[shown]
        axes.plot(time, 1e3 * flown.current[0, shown], color="#22262b", lw=1.2, label="commanded")
        if parts:
            for signal, colour, label in (
                (flown.friction_current, MARK, "for the friction"),
                (flown.attitude_current, MODEL, "of the PID"),
            ):
                axes.plot(time, 1e3 * signal[0, shown], color=colour, lw=1.0, label=label)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("current (mA)")
        axes.legend(loc="upper left")
    caption = "The PID's part stays nearly constant: it answers the fan alone." if parts else ""
    return Drawing(title, figure, caption)


def peaks_drawing(
    peaks: Mapping[str, Mapping[str, Vector]],
    colours: Mapping[str, str],
    goals: Mapping[str, float],
) -> Drawing:
    """Share of the dispersed runs below a peak, for each case and controller.

    Args:
        peaks: case -> controller -> attitude peaks, deg.
        colours: controller -> colour of its line.
        goals: case -> peak wanted in 95 % of the runs, deg.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.2), layout="constrained")
        columns = np.atleast_1d(figure.subplots(1, len(peaks), sharey=True))
        for axes, (case, controllers) in zip(columns, peaks.items(), strict=True):
            for name, values in controllers.items():
                ordered = np.sort(values)
                share = np.arange(1, len(ordered) + 1) / len(ordered)
                axes.step(
                    ordered, 100.0 * share, where="post", color=colours[name], lw=1.3, label=name
                )
            axes.axvline(goals[case], color="#22262b", lw=0.8, ls="--", label="goal for 95 %")
            axes.set_xscale("log")
            axes.set_title(textwrap.fill(case, 32), fontsize=8)
            axes.set_xlabel("attitude peak (deg)")
        columns[0].set_ylabel("runs below (%)")
        figure.legend(*columns[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return Drawing(
        "Peaks of the dispersed runs",
        figure,
        "Every run has the controller's model at a corner of its errors, its own noise and its own "
        "time of crossing.",
    )
