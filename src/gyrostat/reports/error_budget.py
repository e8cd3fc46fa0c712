"""Report of a budget of the pointing error: bars and tables by source."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from gyrostat.campaigns.summary import Estimate
from gyrostat.core.text import or_none
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.page_units import shown_unit
from gyrostat.reports.template import render
from gyrostat.search.budget_result import (
    ARCSEC,
    BIAS,
    LAG,
    REST,
    ErrorBudget,
    IndexBudget,
    Line,
    Missing,
    decimals,
    fixed,
    percent_text,
    rms_text,
    root,
    square_text,
)
from gyrostat.search.found_budget import found_budget

ROW = 0.26
"""Height of a bar, inches."""


def budget_page(folder: Path, command: str, address: str) -> tuple[dict[str, Any], str, list[str]]:
    """Content of report.json, page, and lines for a terminal, of a finished budget.

    Args:
        folder: Folder of the search.
        command: Command line that produced the report.
        address: Address of the folder for the reader.

    Raises:
        InputError: The folder has no finished search.
    """
    result = found_budget(folder)
    page = render(
        "error_budget.html",
        result=result,
        further=[*(index.size for index in result.indices), *result.metrics],
        bars=bars,
        rms_text=rms_text,
        percent_text=percent_text,
        square_text=square_text,
        missing_rows=missing_rows,
        bias_rows=bias_rows,
        folder=address,
        command=command,
    )
    return budget_content(result), page, result.text_lines()


def budget_content(result: ErrorBudget) -> dict[str, Any]:
    """Content of report.json, SI units and radians."""
    return {
        "kind": "budget",
        "scenario": result.scenario,
        "seed": result.seed,
        "runs": result.runs,
        "valid": result.valid,
        "sets": result.sets,
        "orders": result.orders,
        "failed": result.failed,
        "without": result.without,
        "not_switched": [*result.not_switched],
        "doubts": result.doubts(),
        "indices": [_index_content(index) for index in result.indices],
        "metrics": [_missing_content(each) for each in result.metrics],
    }


def _index_content(index: IndexBudget) -> dict[str, Any]:
    split = index.split
    return {
        "requirement": index.requirement.name,
        "index": index.requirement.index,
        "axis": index.requirement.axis,
        "mean_square": _numbers(split.whole),
        "lines": [_line_content(line) for line in index.lines()],
        "bias": {
            "whole": [_numbers(each) for each in split.mean],
            "lag": [_numbers(each) for each in split.lag_mean],
            "sources": {
                each.name: [_numbers(part) for part in each.bias] for each in split.sources
            },
        },
        "properties": {name: _numbers(each) for name, each in index.properties.items()},
        "size": _missing_content(index.size),
    }


def _line_content(line: Line) -> dict[str, Any]:
    content: dict[str, Any] = {
        "name": line.name,
        "mean_square": _numbers(line.mean_square),
        "share": _numbers(line.share),
    }
    if line.alone is not None and line.missing is not None:
        content |= {"alone": _numbers(line.alone), "missing": _numbers(line.missing)}
    return content


def _missing_content(each: Missing) -> dict[str, Any]:
    return {
        "metric": each.metric,
        "unit": each.unit,
        "whole": _numbers(each.whole),
        "missing_without": {name: _numbers(value) for name, value in each.without.items()},
    }


def _numbers(estimate: Estimate) -> dict[str, float | None]:
    return {name: or_none(value) for name, value in estimate._asdict().items()}


def bars(index: IndexBudget) -> list[dict[str, Any]]:
    """Rows of the bar chart: name, text, and places in percent of the width."""
    lines = index.lines()
    ends = np.array([line.share for line in lines])
    low = min(0.0, float(np.nanmin(ends)))
    scale = 100.0 / (max(float(np.nanmax(ends)), 1e-12) - low)
    rows = []
    for line in lines:
        value, first, last = (scale * (each - low) for each in line.share)
        zero = -scale * low
        rows.append(
            {
                "name": line.name,
                "kind": "other" if line.name in (BIAS, LAG, REST) else "source",
                "text": f"{rms_text(line.mean_square, index.split.whole.value)} arcsec",
                "share": f"{fixed(100.0 * line.share.value, 1)} %",
                "left": min(zero, value),
                "width": abs(value - zero),
                "first": first,
                "last": last,
            }
        )
    return rows


def missing_rows(each: Missing) -> list[tuple[str, str]]:
    """Whole, and whole minus the metric without each source, as text; the largest first."""
    scale, unit = (ARCSEC, "arcsec") if each.unit == "rad" else shown_unit(each.unit)

    digits = decimals(scale * each.whole.value)

    def text(estimate: Estimate) -> str:
        value, low, high = (fixed(scale * number, digits) for number in estimate)
        return f"{value} ({low} to {high}){'' if unit == '1' else f' {unit}'}"

    ordered = sorted(each.without.items(), key=lambda pair: -pair[1].value)
    return [("whole", text(each.whole)), *((name, text(value)) for name, value in ordered)]


def bias_rows(index: IndexBudget) -> list[tuple[str, list[str]]]:
    """Mean error of the whole, of the lag and by source, arcsec, as text."""
    split = index.split
    digits = decimals(ARCSEC * max(abs(part.value) for part in split.mean))

    def texts(parts: tuple[Estimate, ...]) -> list[str]:
        return [
            f"{fixed(ARCSEC * e.value, digits)} ± {fixed(0.5 * ARCSEC * (e.high - e.low), digits)}"
            for e in parts
        ]

    sources = sorted(split.sources, key=lambda e: -max(abs(part.value) for part in e.bias))
    rows = [("whole", texts(split.mean)), (LAG, texts(split.lag_mean))]
    return [*rows, *((each.name, texts(each.bias)) for each in sources)]


def budget_figure(result: ErrorBudget) -> Figure:
    """Draw the share of each line in the mean square of each index, with 95 % intervals."""
    counts = [len(index.lines()) for index in result.indices] or [1]
    with panels(
        len(counts),
        height=sum(ROW * count + 0.7 for count in counts),
        squeeze=False,
        gridspec_kw={"height_ratios": counts},
    ) as (figure, grid):
        for axes, index in zip(grid[:, 0], result.indices, strict=False):
            lines, whole = index.lines()[::-1], root(index.split.whole.value)
            digits = decimals(whole)
            share = 100.0 * np.array([line.share for line in lines])
            colours = [MEASURED if e.name in (BIAS, LAG, REST) else MODEL for e in lines]
            axes.barh(range(len(lines)), share[:, 0], color=colours, height=0.7)
            spread = np.abs(share[:, 1:] - share[:, :1]).T
            axes.errorbar(
                share[:, 0], range(len(lines)), xerr=spread, fmt="none", ecolor=MARK, lw=1.0
            )
            axes.set_yticks(
                range(len(lines)),
                [
                    literal(f"{e.name}: {fixed(root(e.mean_square.value), digits)} arcsec")
                    for e in lines
                ],
            )
            axes.set_xlabel("share of the mean square (%)")
            axes.set_title(literal(f"{index.title}: {fixed(whole, digits)} arcsec"), fontsize=9)
    return figure
