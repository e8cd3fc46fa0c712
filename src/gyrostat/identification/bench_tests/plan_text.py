"""Plan of bench tests as text and as JSON."""

from collections.abc import Mapping

from gyrostat.core.text import aligned, plain
from gyrostat.core.views import lines as text_view
from gyrostat.identification.bench_tests.plan import PlannedTest, TestPlan
from gyrostat.identification.bench_tests.rehearsal import Prediction

RECORDS = ("record", "duration", "rate", "largest current", "to do")
PREDICTIONS = ("determines", "expected", "predicted sigma", "scatter", "sigma/scatter", "unit")
FEWEST = 20
"""Smallest number of simulated tests for a scatter: 20 know it to 16 %."""


def record_rows(planned: PlannedTest) -> list[tuple[str, ...]]:
    """Rows of the records of a test."""
    return [
        (
            record.name,
            f"{record.duration:.0f} s",
            f"{1.0 / (record.time[1] - record.time[0]):.4g} Hz",
            f"{abs(record.current).max():.3g} A",
            record.remark,
        )
        for record in planned.records
    ]


def prediction_rows(planned: PlannedTest) -> list[tuple[str, ...]]:
    """Rows of what a test determines; the scatter only from enough simulated tests."""
    if planned.rehearsal is None:
        return []
    return [_row(each) for each in planned.rehearsal.predictions]


def _row(each: Prediction) -> tuple[str, ...]:
    unit, scatter, ratio = each.measured.unit, "", ""
    if each.scatter and each.count >= FEWEST:
        scatter = plain(each.scatter / unit.factor, 3)
        ratio = f"{each.sigma / each.scatter:.2f}"
    value, sigma = each.measured.value / unit.factor, each.sigma / unit.factor
    return each.title, plain(value), plain(sigma, 3), scatter, ratio, unit.symbol


def failures(planned: PlannedTest) -> str:
    """How many simulated tests gave no result, and why; empty if all did."""
    rehearsal = planned.rehearsal
    if rehearsal is None or not rehearsal.failures:
        return ""
    count = len(rehearsal.failures)
    return f"{count} of {rehearsal.runs} simulated tests gave no result: {rehearsal.failures[0]}"


@text_view.register
def table(plan: TestPlan) -> list[str]:
    """Lines that the command line prints."""
    lines = [f"{plan.sheet.wheel.name}: {len(plan.tests)} tests, {plan.duration / 3600.0:.2f} h"]
    for planned in plan.tests:
        lines += ["", f"{planned.test.name}: {planned.test.purpose}"]
        lines += [f"  {line}" for line in aligned(record_rows(planned), RECORDS)]
        rows = prediction_rows(planned)
        lines += [f"  {line}" for line in (aligned(rows, PREDICTIONS) if rows else [])]
        text = failures(planned)
        lines += [f"  warning: {text}"] if text else []
    return lines


def content(plan: TestPlan) -> dict[str, object]:
    """Content of plan.json, SI."""
    return {
        "wheel": plan.sheet.wheel.name,
        "duration": plan.duration,
        "seed": plan.seed,
        "tests": [_test(each) for each in plan.tests],
    }


def _test(planned: PlannedTest) -> Mapping[str, object]:
    rehearsal = planned.rehearsal
    return {
        "name": planned.test.name,
        "title": planned.test.title,
        "determines": planned.test.purpose,
        "records": [
            {
                "name": record.name,
                "duration": record.duration,
                "samples": len(record.time),
                "columns": list(record.columns),
                "to_do": record.remark,
            }
            for record in planned.records
        ],
        "simulated": 0 if rehearsal is None else rehearsal.runs,
        "failures": [] if rehearsal is None else list(rehearsal.failures),
        "predictions": []
        if rehearsal is None
        else [
            {
                "quantity": each.measured.quantity,
                "title": each.title,
                "sense": each.measured.sense,
                "conditions": dict(each.measured.conditions),
                "value": each.measured.value,
                "sigma": each.sigma,
                "scatter": each.scatter,
                "count": each.count,
                "unit": each.unit,
            }
            for each in rehearsal.predictions
        ],
    }
