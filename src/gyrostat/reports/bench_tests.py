"""Pages of bench tests: the plan, and the acceptance report as HTML and PDF."""

from collections.abc import Callable, Sequence
from io import BytesIO
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.identification.bench_tests import plan_text, verdict_text
from gyrostat.identification.bench_tests.bench_test import Panel, PlannedRecord
from gyrostat.identification.bench_tests.plan import PlannedTest, TestPlan
from gyrostat.identification.bench_tests.verdict import BenchVerdict, TestResult
from gyrostat.identification.judge.acceptance_lines import FAIL, NO_LIMIT, PASS
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.page_units import bench_unit, labelled
from gyrostat.reports.paper import Paper
from gyrostat.reports.template import render

HEIGHT = 2.3
"""Height of a figure, inches."""
MOST_POINTS = 2000
"""Largest number of points of a profile in a figure."""
SIGNATURES = ("Tested by", "Quality assurance", "Accepted by the customer")


def plan_page(plan: TestPlan, *, command: str) -> str:
    """HTML page of a plan.

    Args:
        plan: Plan of tests.
        command: Command line that produced it.
    """
    tests = [
        (
            planned,
            plan_text.record_rows(planned),
            len(plan_text.RECORDS) - (not any(each.remark for each in planned.records)),
            plan_text.prediction_rows(planned),
            plan_text.failures(planned),
            figure_charts(_profiles(planned), f"test{number}"),
        )
        for number, planned in enumerate(plan.tests)
    ]
    return render(
        "test_plan.html",
        plan=plan,
        command=command,
        tests=tests,
        records=plan_text.RECORDS,
        predictions=plan_text.PREDICTIONS,
    )


def _profiles(planned: PlannedTest) -> Figure:
    """Currents of the records of a test."""
    records = planned.records[:4]
    # more than two in a row are too small on a phone
    columns = min(len(records), 2)
    rows = -(-len(records) // columns)
    with panels(rows, columns, height=1.9 * rows, squeeze=False, sharey=True) as (figure, grid):
        for axes, record in zip(grid.flat, records, strict=False):
            _profile(axes, record)
        for axes in grid[:, 0]:
            axes.set_ylabel("current (A)")
    return figure


def _profile(axes: Axes, record: PlannedRecord) -> None:
    """Current of a record over time."""
    # the ends of each step stay visible
    index = np.unique(np.linspace(0, len(record.time) - 1, MOST_POINTS).astype(int))
    axes.step(record.time[index], record.current[index], where="post", lw=0.9, color=MODEL)
    axes.set_title(record.name, fontsize=8)
    axes.set_xlabel("time (s)")


def plan_figure(plan: TestPlan) -> Figure:
    """Draw the current of the first record of each test.

    Args:
        plan: Plan of tests.
    """

    def with_unit(axes: Axes, record: PlannedRecord) -> None:
        _profile(axes, record)
        axes.set_ylabel("current (A)")

    first = [each.records[0] for each in plan.tests if each.records]
    return _beside(first, with_unit, 1.9)


def report_page(verdict: BenchVerdict, *, command: str) -> str:
    """HTML of the acceptance report.

    Args:
        verdict: Verdict on the tests.
        command: Command line that produced it.
    """
    units = verdict_text.units_of(verdict)
    tests = [
        (
            result,
            verdict_text.value_rows(result, units),
            [figure_charts(f, f"test{k}_{m}_") for m, f in enumerate(_figures(result))],
        )
        for k, result in enumerate(verdict.results)
    ]
    verdicts = [line.verdict for line in verdict.acceptance.lines]
    classes = [{PASS: "good", FAIL: "bad"}.get(each, "open") for each in verdicts]
    is_open = {*verdicts} - {NO_LIMIT} != {PASS}
    outcome = "invalid" if verdict.acceptance.failed else f"verdict {'open' if is_open else 'good'}"
    return render(
        "acceptance_report.html",
        verdict=verdict,
        command=command,
        software=verdict_text.software(),
        outcome=outcome,
        header=verdict_text.LINES,
        entries=lambda row: zip(verdict_text.LINES[2:-1], row[2:-1], strict=True),
        rows=list(
            zip(verdict_text.line_rows(verdict), verdict.acceptance.lines, classes, strict=True)
        ),
        instruments=(verdict_text.INSTRUMENTS, verdict_text.instrument_rows(verdict)),
        files=(verdict_text.FILES, verdict_text.file_rows(verdict)),
        values=verdict_text.VALUES,
        tests=tests,
        signatures=SIGNATURES,
    )


def report_pdf(verdict: BenchVerdict, *, command: str) -> bytes:
    """PDF of the acceptance report, A4.

    Args:
        verdict: Verdict on the tests.
        command: Command line that produced it.
    """
    serial = verdict.serial or "not stated"
    buffer = BytesIO()
    with Paper(buffer, f"Acceptance report, {verdict.sheet.wheel.name}, serial {serial}") as paper:
        paper.heading("Acceptance report", size=17)
        paper.table(
            ("wheel", verdict.sheet.wheel.name),
            [
                ("serial number", serial),
                ("spec sheet", verdict.sheet.path.name),
                ("software", verdict_text.software()),
                ("command", command),
                ("result", verdict.acceptance.verdict),
            ],
        )
        paper.heading("Requirements")
        rows = [
            (*row, line.limit.source)
            for row, line in zip(
                verdict_text.line_rows(verdict), verdict.acceptance.lines, strict=True
            )
        ]
        paper.table((*verdict_text.LINES, "source"), rows)
        paper.text(
            "Pass: the true value lies inside the limits with a probability of at least 95 %; "
            "fail: outside with at least 95 %; undecided: neither (JCGM 106:2012)."
        )
        for note in verdict.acceptance.notes:
            paper.text(note)
        paper.signatures(SIGNATURES)
        paper.heading("Instruments")
        paper.table(verdict_text.INSTRUMENTS, verdict_text.instrument_rows(verdict))
        paper.heading("Records")
        paper.table(verdict_text.FILES, verdict_text.file_rows(verdict))
        units = verdict_text.units_of(verdict)
        for result in verdict.results:
            paper.heading(result.test.title)
            if result.outcome is None:
                paper.text(result.why)
                continue
            paper.table(verdict_text.VALUES, verdict_text.value_rows(result, units))
            for note in result.outcome.notes:
                paper.text(note)
            for panel in result.outcome.panels:
                paper.figure(lambda axes, panel=panel: draw(axes, panel))
    return buffer.getvalue()


def verdict_figure(verdict: BenchVerdict) -> Figure:
    """Draw the first picture of each test that was run.

    Args:
        verdict: Verdict on the tests.
    """
    outcomes = [each.outcome for each in verdict.results if each.outcome is not None]
    first = [outcome.panels[0] for outcome in outcomes if outcome.panels]
    return _beside(first, draw, HEIGHT)


def _beside(parts: Sequence[Any], draw_part: Callable[[Axes, Any], None], height: float) -> Figure:
    """Draw one panel for each part, two beside each other."""
    rows = max(1, -(-len(parts) // 2))
    with panels(rows, 2, height=height * rows, squeeze=False) as (figure, grid):
        for axes in grid.flat[len(parts) :]:
            axes.set_visible(False)
        for axes, part in zip(grid.flat, parts, strict=False):
            draw_part(axes, part)
    return figure


def _figures(result: TestResult) -> list[Figure]:
    """Figure of each picture of a test."""
    figures = []
    for panel in () if result.outcome is None else result.outcome.panels:
        with panels(height=HEIGHT) as (figure, axes):
            draw(axes, panel)
        figures.append(figure)
    return figures


def draw(axes: Axes, panel: Panel) -> None:
    """Draw one picture of a test."""
    if panel.image is not None:
        image = axes.imshow(
            panel.image, aspect="auto", origin="lower", extent=panel.extent, cmap="viridis"
        )
        bar = axes.figure.colorbar(image, ax=axes)
        bar.set_label("dB")
        axes.grid(visible=False)
    name, _, unit = panel.y.rstrip(")").rpartition(" (")
    factor, unit = bench_unit(unit)
    x, y, sigma = panel.points
    if len(x):
        height = 1.96 * factor * sigma
        axes.errorbar(x, factor * y, yerr=height, fmt="o", ms=3, lw=1, color=MEASURED)
    for (along, values), colour in zip(panel.lines, (MODEL, MARK, MEASURED), strict=False):
        axes.plot(along, factor * values, color=colour, lw=1.2)
    axes.set_title(panel.title, fontsize=9)
    axes.set_xlabel(panel.x)
    axes.set_ylabel(labelled(name, unit) if name else panel.y)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3), useOffset=False)
