"""Page of a comparison of fits."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.figure import Figure

from gyrostat.identification import Comparison
from gyrostat.identification.judge.comparison_text import shared_text, tables, verdict
from gyrostat.identification.judge.fit_changes import DAY
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import WIDTH, literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.page_units import bench_unit, labelled
from gyrostat.reports.template import render

POINTS = 60
"""Points of a trend line."""
CHARACTER = 0.075
"""Width of a character of the labels, inches."""


def comparison_page(comparison: Comparison, *, command: str) -> str:
    """HTML report of a comparison.

    Args:
        comparison: Result of the comparison.
        command: Command line that produced it.
    """
    return render(
        "comparison.html",
        comparison=comparison,
        command=command,
        shared=shared_text(comparison),
        verdict=verdict(comparison),
        figure=figure_charts(comparison_figure(comparison)),
        tables=tables(comparison, _shown_units(comparison)),
    )


def _shown_units(comparison: Comparison) -> dict[str, tuple[float, str]]:
    """Parameter -> factor from SI and unit in which the page has it."""
    values: dict[str, list[float]] = {}
    units: dict[str, str] = {}
    for fit in comparison.fits:
        for name, value, unit in zip(fit.names, fit.values, fit.units, strict=True):
            values.setdefault(name, []).append(abs(float(value)))
            units[name] = unit
    return {name: bench_unit(units[name], max(values[name])) for name in comparison.parameters}


def comparison_figure(comparison: Comparison) -> Figure:
    """Plot every parameter with its 95 % interval over date, or over the wheels of a batch."""
    names = comparison.parameters
    over_time = comparison.same_wheel and comparison.days is not None
    labels = [] if over_time else [literal(label) for label in comparison.labels]
    longest = max(map(len, labels), default=0)
    upright = longest * CHARACTER > 0.84 * WIDTH / max(len(labels), 1)
    below = 0.5 + (longest * CHARACTER if upright else 0.2)
    height = below + 1.9 * len(names)
    options = {"sharex": True, "squeeze": False}
    with panels(len(names), height=height, layout=None, **options) as (figure, grid):
        figure.subplots_adjust(left=0.14, right=0.98, top=0.95, bottom=below / height)
        rows = grid[:, 0]
        units = _shown_units(comparison)
        for axes, name in zip(rows, names, strict=True):
            _parameter_axes(axes, comparison, name, *units[name], over_time=over_time)
        if over_time:
            locator = AutoDateLocator()
            rows[-1].xaxis.set_major_locator(locator)
            rows[-1].xaxis.set_major_formatter(ConciseDateFormatter(locator))
        else:
            rows[-1].set_xticks(range(len(labels)), labels, rotation=90 if upright else 0)
            rows[-1].set_xlim(-0.5, len(labels) - 0.5)
        figure.align_ylabels(rows)
    return figure


def _parameter_axes(
    axes: Axes, comparison: Comparison, name: str, factor: float, unit: str, *, over_time: bool
) -> None:
    """Plot one parameter in a unit; significant differences are marked."""
    significant = {c.fit for c in comparison.changes if c.parameter == name and c.significant}
    for k, (label, fit) in enumerate(zip(comparison.labels, comparison.fits, strict=True)):
        if name not in fit.names:
            continue
        number = fit.names.index(name)
        x = fit.date if over_time else k
        variance = fit.covariance[number, number]
        tolerances = [fit.tolerances[n] for n in comparison.shared if n in fit.tolerances]
        common = sum(float(tolerance.errors[number]) ** 2 for tolerance in tolerances)
        color = MARK if label in significant else MODEL
        for part, line in ((variance, 0.9), (max(variance - common, 0.0), 2.5)):
            axes.errorbar(
                [x],  # pyright: ignore[reportArgumentType]
                [factor * fit.values[number]],
                2.0 * factor * np.sqrt(part),
                fmt="o",
                ms=4,
                lw=line,
                color=color,
                capsize=3,
            )
    first_date = min((fit.date for fit in comparison.fits if fit.date is not None), default=None)
    for trend in comparison.trends if over_time and first_date is not None else ():
        if trend.parameter == name and comparison.days is not None:
            time = np.linspace(0.0, comparison.days.max(), POINTS)
            rows = np.column_stack([np.ones(POINTS), time])
            middle = factor * (trend.start + trend.slope * time)
            width = 2.0 * factor * np.sqrt(np.einsum("mi,ij,mj->m", rows, trend.covariance, rows))
            when = np.datetime64(first_date) + (time * DAY).astype("timedelta64[s]")
            axes.fill_between(when, middle - width, middle + width, color=BAND, alpha=0.4, lw=0)
            axes.plot(when, middle, color=MODEL, lw=1.0)
    for spread in comparison.spreads:
        if spread.parameter == name:
            axes.axhline(factor * spread.mean, color=MEASURED, lw=1.0)
            ends = (factor * (spread.mean + 2.0 * side * spread.spread) for side in (-1.0, 1.0))
            axes.axhspan(*ends, color=BAND, alpha=0.3, lw=0)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3), useOffset=False)
    axes.set_ylabel(labelled(literal(name), unit).replace(" (", "\n("))
