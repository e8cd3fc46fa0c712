"""Verdict on bench tests as text and as JSON."""

from collections.abc import Mapping
from dataclasses import replace

from gyrostat.core.source_digest import source_digest
from gyrostat.core.text import aligned, plain
from gyrostat.core.units import Unit
from gyrostat.core.views import lines as text_view
from gyrostat.identification.bench_tests.bench_test import Measured
from gyrostat.identification.bench_tests.verdict import BenchVerdict, TestResult
from gyrostat.identification.judge.acceptance_lines import Acceptance, Line
from gyrostat.identification.judge.acceptance_text import HEADER, acceptance_rows

INTERVAL = 1.959964
"""Half of a 95 % interval, in standard deviations."""
LINES = ("no", "quantity", "limits", "unit", "value ± sigma", "95 % interval", "test", "verdict")
VALUES = ("quantity", "value ± sigma", "95 % interval", "unit")
FILES = ("record", "date", "operator", "samples", "SHA-256")
INSTRUMENTS = (
    "measures",
    "instrument",
    "serial",
    "uncertainty",
    "calibrated",
    "due",
    "certificate",
)


def interval(line: Line) -> str:
    """95 % interval of a line in the unit of its limit; empty without a value."""
    if line.measured is None or line.sigma is None:
        return ""
    factor, half = line.limit.unit.factor, INTERVAL * line.sigma
    # no quantity of a sheet is negative
    ends = (max(line.measured - half, 0.0), line.measured + half)
    return " to ".join(plain(each / factor) for each in ends)


def line_rows(verdict: BenchVerdict) -> list[tuple[str, ...]]:
    """Rows of the acceptance table of the report."""
    rows = []
    pairs = zip(verdict.acceptance.lines, verdict.sources, strict=True)
    texts = acceptance_rows(verdict.acceptance)
    for number, ((line, source), text) in enumerate(zip(pairs, texts, strict=True), 1):
        title, limits, unit, value, _, result = text
        rows.append((str(number), title, limits, unit, value, interval(line), source, result))
    return rows


def units_of(verdict: BenchVerdict) -> dict[str, Unit]:
    """Quantity -> unit of the sheet, for those on which the sheet has a limit."""
    return {line.limit.quantity: line.limit.unit for line in verdict.acceptance.lines}


def value_rows(result: TestResult, units: Mapping[str, Unit]) -> list[tuple[str, ...]]:
    """Rows of all values that a test measured, in the units of the sheet where it has one."""
    outcome = result.outcome
    if outcome is None:
        return []
    judged = [line for line in outcome.lines if line.measured is not None]
    stated = {line.limit.quantity for line in judged}
    values: list[Measured] = [v for v in outcome.values if v.quantity not in stated]
    rows = []
    for line in [*judged, *(each.line() for each in values)]:
        unit = units.get(line.limit.quantity, line.limit.unit)
        shown = replace(line, limit=replace(line.limit, unit=unit))
        (text,) = acceptance_rows(Acceptance("", (shown,)))
        rows.append((text[0], text[3], interval(shown), text[2]))
    return rows


def file_rows(verdict: BenchVerdict) -> list[tuple[str, ...]]:
    """Rows of the records with their digests."""
    return [
        (
            file.name,
            file.remark("date"),
            file.remark("operator"),
            str(len(file.record.time)),
            file.digest,
        )
        for file in verdict.files
    ]


def instrument_rows(verdict: BenchVerdict) -> list[tuple[str, ...]]:
    """Rows of the instruments with their calibration."""
    return [
        (
            each.quantity,
            each.name,
            each.serial,
            f"{100.0 * each.uncertainty:.3g} %",
            str(each.calibrated or ""),
            str(each.due or ""),
            each.certificate,
        )
        for each in verdict.sheet.instruments
    ]


def software() -> str:
    """Version of the package with the digest of its code."""
    return f"gyrostat {source_digest()}"


@text_view.register
def table(verdict: BenchVerdict) -> list[str]:
    """Lines that the command line prints."""
    lines = [f"wheel {verdict.serial or 'without serial number'}, {verdict.sheet.wheel.name}"]
    lines += aligned(acceptance_rows(verdict.acceptance), HEADER)
    for result in verdict.results:
        if result.why:
            lines.append(f"{result.test.name}: {result.why}")
        elif result.outcome is not None:
            lines += [f"{result.test.name}: {note}" for note in result.outcome.notes]
    lines += [f"note: {note}" for note in verdict.acceptance.notes]
    return [*lines, verdict.acceptance.verdict]


def content(verdict: BenchVerdict) -> dict[str, object]:
    """Content of acceptance.json, SI."""
    rows = verdict.acceptance.to_dict()
    lines = rows.pop("lines")
    assert isinstance(lines, list)
    return {
        "serial": verdict.serial,
        "software": software(),
        **rows,
        "lines": [
            {**line, "test": source} for line, source in zip(lines, verdict.sources, strict=True)
        ],
        "instruments": [
            dict(zip(INSTRUMENTS, row, strict=True)) for row in instrument_rows(verdict)
        ],
        "records": [
            {"name": f.name, "sha256": f.digest, "samples": len(f.record.time)}
            for f in verdict.files
        ],
        "tests": [_test(result) for result in verdict.results],
    }


def _test(result: TestResult) -> dict[str, object]:
    outcome = result.outcome
    return {
        "name": result.test.name,
        "why": result.why,
        "notes": [] if outcome is None else list(outcome.notes),
        "values": []
        if outcome is None
        else [
            {
                "quantity": each.quantity,
                "sense": each.sense,
                "conditions": dict(each.conditions),
                "value": each.value,
                "sigma": each.sigma,
                "guard": each.sigma if each.guard is None else each.guard,
            }
            for each in outcome.values
        ],
    }
