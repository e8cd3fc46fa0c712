"""Figure of Matplotlib from charts of a page: the same marks, for papers and to edit."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.reports.chart import Chart
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import WIDTH, literal, panels

ROW = 2.3
"""Height of a row of panels, inches."""
TICKS = 6
"""Largest number of intervals between ticks."""
FURTHER = ("#d9822b", "#3a9a5b", "#a05bb5", "#b8413c", "#3fa7b5", "#8a7a3c", "#8a8f98")
"""Colours of further curves, those of the classes s1 to s7."""
COLOURS = {"s0": MODEL, **{f"s{k}": each for k, each in enumerate(FURTHER, 1)}}
COLOURS |= {"measured": MEASURED, "required": MARK, "event": MARK, "thin": MODEL, "zero": MEASURED}
COLOURS |= {"percentile": MEASURED, "narrow": BAND, "wide": BAND, "unknown": MEASURED}
COLOURS |= {"avoided": MARK}
DOTTED = {"event": ":", "percentile": ":", "required": "--"}


def figure_of(charts: Sequence[Chart], columns: int = 2) -> Figure:
    """Draw charts as the panels of a figure.

    Args:
        charts: Charts with the marks of runs and campaigns: curves, bands, bars, points, stays,
            cells and levels.
        columns: Number of columns of panels.
    """
    rows = -(-len(charts) // columns)
    wide = WIDTH if columns > 1 else 0.7 * WIDTH
    options: dict[str, Any] = {"width": wide, "squeeze": False}
    with panels(rows, columns, height=max(rows, 1) * ROW, **options) as (figure, grid):
        for axes in grid.flat[len(charts) :]:
            axes.set_visible(False)
        for axes, chart in zip(grid.flat, charts, strict=False):
            for name, arguments, given in chart.drawn:
                _MARKS[name](axes, *arguments, **given)
            _frame(axes, chart)
        for axes in grid.flat:
            handles, names = axes.get_legend_handles_labels()
            if len(names) > 1:
                axes.legend(handles, names, fontsize=7.5, ncols=2)
                break
    return figure


def _frame(axes: Axes, chart: Chart) -> None:
    axes.set_title(literal(chart.title), fontsize=9, loc="left")
    axes.set_xlabel(literal(chart.x.label))
    axes.set_xscale("log" if chart.x.is_log else "linear")
    axes.set_yscale("log" if chart.y.is_log else "linear")
    scales: tuple[tuple[Literal["x", "y"], bool], ...] = (
        ("x", chart.x.is_log),
        ("y", chart.y.is_log),
    )
    for axis, is_log in scales:
        if not is_log:
            axes.ticklabel_format(axis=axis, scilimits=(-4, 5), useOffset=False)
            axes.locator_params(axis=axis, nbins=TICKS)
    axes.set_xlim(chart.x.low, chart.x.high)
    axes.set_ylim(chart.y.low, chart.y.high)
    if chart.rows:
        axes.set_yticks(range(len(chart.rows)), [literal(name) for name in chart.rows])


def _colour(kind: str) -> str:
    return next((COLOURS[part] for part in kind.split() if part in COLOURS), MODEL)


def _line(axes: Axes, x: Vector, y: Vector, name: str, kind: str = "s0") -> None:
    axes.plot(x, y, lw=1.1, color=_colour(kind), label=literal(name) or None)


def _band(axes: Axes, x: Vector, low: Vector, high: Vector, kind: str) -> None:
    opacity = 0.4 if kind == "wide" else 0.8
    axes.fill_between(x, low, high, color=_colour(kind), alpha=opacity, lw=0)


def _bars(axes: Axes, edges: Vector, counts: Vector) -> None:
    axes.stairs(counts, edges, fill=True, color=MODEL, alpha=0.75)


def _spans(axes: Axes, x: Vector, low: Vector, high: Vector, kind: str) -> None:
    axes.vlines(x, low, high, colors=_colour(kind), lw=0.8)


def _points(axes: Axes, x: Vector, y: Vector, kind: str = "") -> None:
    axes.plot(x, y, ".", ms=2.5, color=_colour(kind), alpha=0.6, rasterized=True)


def _stays(axes: Axes, begins: Vector, ends: Vector, value: float, text: str, kind: str) -> None:
    axes.hlines(np.full(len(begins), value), begins, ends, colors=_colour(kind), lw=5)


def _level(axes: Axes, value: float, name: str, kind: str, *, across: bool = True) -> None:
    style: dict[str, Any] = {"color": _colour(kind), "lw": 0.9, "ls": DOTTED.get(kind, "-")}
    (axes.axhline if across else axes.axvline)(value, **style)
    if not name:
        return
    label: dict[str, Any] = {"color": _colour(kind), "fontsize": 7.5, "clip_on": True}
    if across:
        place = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "bottom"}
        axes.text(1.0, value, literal(name), **place, **label)
    else:
        place = {"transform": axes.get_xaxis_transform(), "ha": "left", "va": "top"}
        axes.text(value, 1.0, f" {literal(name)}", **place, **label)


def _cells(axes: Axes, x: Vector, y: Vector, chosen: NDArray[np.bool_], kind: str) -> None:
    filled = np.where(chosen, 1.0, np.nan)
    colours = ListedColormap([_colour(kind)])
    axes.pcolormesh(x, y, filled, cmap=colours, alpha=0.3, lw=0, rasterized=True)


_MARKS = {
    **{"line": _line, "band": _band, "bars": _bars, "spans": _spans, "points": _points},
    **{"stays": _stays, "level": _level, "cells": _cells},
}
