"""Figures of the budgets: what each source contributes, and the size of the whole error."""

from collections.abc import Mapping

import numpy as np

from gyrostat.papers.ecss_control_performance.budget import Budget
from gyrostat.papers.ecss_control_performance.setup import AXES, FACTOR, LEVEL, REQUIRED, SOURCES
from gyrostat.papers.figures import GREY, INK, Drawing
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels

COLOURS = MODEL, MARK, MEASURED
"""Colours of the axes."""


def figures(budgets: Mapping[str, Budget]) -> tuple[Drawing, ...]:
    """All figures."""
    return contributions(budgets), sizes(budgets)


def contributions(budgets: Mapping[str, Budget]) -> Drawing:
    """Standard deviation of each source and of the whole about each axis."""
    names = [*SOURCES, "whole"]
    labels = [*(source.label for source in SOURCES.values()), "all sources"]
    places = np.arange(len(names))[::-1]
    with panels(1, 2, height=3.8, sharey=True) as (figure, row):
        for axes, (index, budget) in zip(row, budgets.items(), strict=True):
            sigmas = np.array([*(budget.sigmas[name] for name in SOURCES), budget.sigma])
            for k, (axis, colour) in enumerate(zip(AXES, COLOURS, strict=True)):
                axes.barh(places + 0.26 * (1 - k), sigmas[:, k], 0.24, color=colour, label=axis)
            axes.set(xlabel=f"standard deviation of {index} (arcsec)")
        row[0].set_yticks(places, labels)
        row[1].legend(loc="center right", title="axis")
    caption = "Over time and members. In the RPE, what does not change within 30 s is left out."
    return Drawing("Contributions to the budgets (tables C-3 and C-4)", figure, caption)


def sizes(budgets: Mapping[str, Budget]) -> Drawing:
    """Share of time and members in which the whole error exceeds a size."""
    with panels(1, 2, height=3.6, sharey=True) as (figure, row):
        for axes, (index, budget) in zip(row, budgets.items(), strict=True):
            grid = np.linspace(0.0, 1.1 * max(REQUIRED[index]), 300)
            for k, (axis, colour) in enumerate(zip(AXES, COLOURS, strict=True)):
                size = np.sort(np.abs(budget.whole[:, k]))
                above = 1.0 - np.searchsorted(size, grid, side="right") / len(size)
                axes.plot(grid, 100.0 * above, color=colour, lw=1.4, label=axis)
                axes.plot(FACTOR * budget.sigma[k], 100.0 * (1.0 - LEVEL), "o", ms=5, color=colour)
                axes.axvline(REQUIRED[index][k], color=colour, lw=0.9, ls=":")
            axes.axhline(100.0 * (1.0 - LEVEL), color=GREY, lw=0.9, ls="--")
            axes.set(xlabel=f"size of {index} (arcsec)", ylim=(0.0, 40.0))
        row[0].set_ylabel("time and members above it (%)", color=INK)
        row[0].legend(loc="center", title="axis")
    return Drawing(
        "Size of the whole error",
        figure,
        "Dotted, the required values (y and z alike); dashed, 5 %; dots, two standard deviations, "
        "which the annex takes for the size in 95 %. Where a requirement holds, its line is below "
        "the dashed one at the required value.",
    )
