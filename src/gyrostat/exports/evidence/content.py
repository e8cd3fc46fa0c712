"""Content of the page of evidence, read from a flight folder."""

import csv
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from gyrostat.exports.evidence.folder import KINDS
from gyrostat.exports.evidence.pivot import Pivot, pivots
from gyrostat.exports.evidence.results import Figure, Result, read_results
from gyrostat.exports.evidence.trace import Group, Requirement

CLAUSES = {
    "5.8.3.5": "Verification of code",
    "5.8.3.6": "Verification of software unit testing",
    "5.8.3.12": "Technical budgets management",
}
"""Clause of ECSS-E-ST-40C (6 March 2009) -> its title, in the order of the standard."""


@dataclass(frozen=True)
class Arranged:
    """Result with its figures in tables.

    Attributes:
        result: Result of a kind of evidence.
        tables: Tables of its figures.
        figures: Its other figures.
    """

    result: Result
    tables: tuple[Pivot, ...]
    figures: tuple[Figure, ...]


@dataclass(frozen=True)
class Traced:
    """Requirement with the groups of statements that come from it.

    Attributes:
        requirement: The requirement.
        groups: Its groups; with each the first step that executes it and the number of such steps,
            0 for none, or None if it is not known.
    """

    requirement: Requirement
    groups: tuple[tuple[Group, int | None, int | None], ...]


@dataclass(frozen=True)
class Content:
    """Content of the page.

    Attributes:
        title: Title of the module.
        origin: Origin of the parameters.
        digests: What the code is made from, and its digest.
        code: SHA-256 digest of header and source, of the results; "" without results.
        source: Name of the C file, and its lines.
        clauses: Clause, its title, and its results.
        outcomes: Outcome -> number of results.
        trace: Requirements of the code.
    """

    title: str
    origin: str
    digests: tuple[tuple[str, str], ...]
    code: str
    source: tuple[str, tuple[str, ...]]
    clauses: tuple[tuple[str, str, tuple[Arranged, ...]], ...]
    outcomes: dict[str, int]
    trace: tuple[Traced, ...]


def read_content(folder: Path) -> Content:
    """Read what a flight folder says of its code: trace, digests and results of evidence."""
    results = read_results(folder)
    header = next(path for path in sorted(folder.glob("*.h")))
    source = header.with_suffix(".c").read_text(encoding="utf-8")
    title, origin = _title(folder)
    clauses = [
        (clause, text, tuple(_arranged(r) for r in results if KINDS[r.name].clause == clause))
        for clause, text in CLAUSES.items()
    ]
    return Content(
        title=title,
        origin=origin,
        digests=tuple(re.findall(r"^   (\w+): (.+?)(?: \*/)?$", source.partition("*/")[0], re.M)),
        code=next((result.code for result in results if result.code), ""),
        source=(header.with_suffix(".c").name, tuple(source.splitlines())),
        clauses=tuple(clauses),
        outcomes=dict(Counter(result.outcome for result in results)),
        trace=_trace(folder),
    )


def _arranged(result: Result) -> Arranged:
    tables, others = pivots(result.figures)
    return Arranged(result, tuple(tables), tuple(others))


def _title(folder: Path) -> tuple[str, str]:
    rows = (folder / "README.md").read_text(encoding="utf-8").splitlines()
    return rows[0].removeprefix("# "), rows[2].partition(" Made from ")[0]


def _trace(folder: Path) -> tuple[Traced, ...]:
    requirements = [Requirement(**row) for row in _rows(folder / "evidence/trace/requirements.csv")]
    groups = [
        Group(row["requirement"], int(row["line"]), row["equation"], *_numbers(row))
        for row in _rows(folder / "evidence/trace/groups.csv")
    ]
    path = folder / "evidence/results/trace.tsv"
    steps: list[tuple[int | None, int | None]] = [(None, None)] * len(groups)
    if path.is_file():
        lines = path.read_text(encoding="utf-8").splitlines()
        executed = [tuple(map(int, line.split("\t"))) for line in lines]
        if len(executed) == len(groups):
            steps = [(first, count) for first, count in executed]
    by_requirement: dict[str, list[tuple[Group, int | None, int | None]]] = {}
    for group, (first, count) in zip(groups, steps, strict=True):
        by_requirement.setdefault(group.requirement, []).append((group, first, count))
    return tuple(Traced(r, tuple(by_requirement[r.identifier])) for r in requirements)


def _numbers(row: dict[str, str]) -> tuple[int, int, int]:
    return int(row["first"]), int(row["body"]), int(row["last"])


def _rows(path: Path) -> list[dict[str, str]]:
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
