"""Page of a lot of wheels."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.core.skewed_normal import score_of, value_at
from gyrostat.core.types import Vector
from gyrostat.identification import Lot
from gyrostat.identification.lot.lot_text import best_text, outliers_text, tables
from gyrostat.identification.lot.over_dates import CUSUM_LIMIT, SHEWHART_LIMIT
from gyrostat.identification.lot.result import LotParameter
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.template import render

POINTS = 300
HEIGHT = 2.1
"""Height of a row of panels, inches."""


def lot_page(lot: Lot, *, command: str) -> str:
    """HTML report of a lot.

    Args:
        lot: Result of the analysis.
        command: Command line that produced it.
    """
    return render(
        "lot.html",
        lot=lot,
        command=command,
        verdict=outliers_text(lot),
        best=best_text(lot),
        histograms=figure_charts(histograms(lot)),
        charts=figure_charts(control_charts(lot), "control"),
        tables=tables(lot),
    )


def histograms(lot: Lot) -> Figure:
    """Histogram of the estimates of each parameter, density of the lot, and tolerance limits."""
    columns = 2
    rows = -(-len(lot.parameters) // columns)
    with panels(rows, columns, height=1.2 * HEIGHT * rows, squeeze=False) as (figure, grid):
        for axes in grid.flat[len(lot.parameters) :]:
            axes.set_axis_off()
        for axes, parameter in zip(grid.flat, lot.parameters.values(), strict=False):
            _histogram(axes, parameter)
        grid.flat[0].legend(fontsize=7.5)
    return figure


def _histogram(axes: Axes, parameter: LotParameter) -> None:
    values, limits = parameter.values, parameter.limits
    bins = int(np.clip(2.0 * np.sqrt(len(values)), 8, 40))
    axes.hist(values, bins=bins, density=True, color=MEASURED, alpha=0.45, label="estimates")
    typical = parameter.draws.typical()
    x = value_at(np.linspace(-3.5, 3.5, POINTS), *typical)
    axes.plot(x, _density(x, typical), color=MODEL, lw=1.6, label="wheels")
    normal = np.exp(-0.5 * ((x - values.mean()) / parameter.sigma_estimates) ** 2)
    naive = normal / (parameter.sigma_estimates * np.sqrt(2.0 * np.pi))
    axes.plot(x, naive, color=MEASURED, lw=1.0, ls="--", label="normal, errors included")
    for k, end in enumerate((limits.low, limits.high)):
        axes.axvline(end, color=MARK, lw=1.0, label=None if k else "tolerance interval")
    axes.ticklabel_format(axis="both", scilimits=(-2, 3), useOffset=False)
    axes.set_yticks([])
    axes.set_xlabel(f"{literal(parameter.name)} ({parameter.unit})")


def _density(x: Vector, lot: tuple[float, float, float]) -> Vector:
    """Density of a skewed normal lot."""
    score = score_of(x, *lot)
    return np.exp(-0.5 * score**2 - lot[2] * score) / (lot[1] * np.sqrt(2.0 * np.pi))


def control_charts(lot: Lot) -> Figure:
    """Shewhart chart and CUSUM of each parameter in the order of production."""
    rows, number = len(lot.parameters), np.arange(1, len(lot.fits) + 1)
    height = HEIGHT * rows
    with panels(rows, 2, height=height, sharex=True, squeeze=False) as (figure, grid):
        for (single, sums), parameter in zip(grid, lot.parameters.values(), strict=True):
            chart = parameter.chart
            single.axhspan(-SHEWHART_LIMIT, SHEWHART_LIMIT, color=BAND, alpha=0.25, lw=0)
            single.plot(number, chart.scores, color=MEASURED, lw=0.7, marker="o", ms=2.5)
            marked = sorted({*chart.beyond, *(suspect.wheel for suspect in parameter.outliers)})
            single.plot(number[marked], chart.scores[marked], "o", color=MARK, ms=4.5)
            single.set_ylabel(literal(parameter.name))
            sums.axhspan(-CUSUM_LIMIT, CUSUM_LIMIT, color=BAND, alpha=0.25, lw=0)
            for curve in (chart.above, -chart.below):
                sums.plot(number, curve, color=MODEL, lw=1.2)
            for place in chart.shifts:
                sums.axvline(number[place], color=MARK, lw=1.0)
        grid[0, 0].set_title("Shewhart chart, sigma of the lot", fontsize=9)
        grid[0, 1].set_title("CUSUM of sigma above 0.5", fontsize=9)
        for axes in grid[-1]:
            axes.set_xlabel("wheel, in the order of production")
    return figure
