"""Coverage of lines, branches and conditions by the test vectors."""

import csv
import io
import re
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from gyrostat.codegen.flight.measure import FLAGS
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled
from gyrostat.exports.vectors.find import Found
from gyrostat.exports.vectors.justifications import Gap
from gyrostat.exports.vectors.report import condition_rows, shown


class Coverage(EvidenceKind):
    """Every line, branch and condition (MC/DC) is shown by the test vectors, or justified."""

    name = "coverage"
    title = "lines, branches and conditions (MC/DC) that the test vectors show"
    tools: ClassVar[Mapping[str, str]] = {
        "clang": "clang-19 clang-20 clang",
        "profdata": "llvm-profdata-19 llvm-profdata-20 llvm-profdata",
        "cov": "llvm-cov-19 llvm-cov-20 llvm-cov",
    }

    clause: ClassVar[str] = "5.8.3.6"

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        if subject.found is None:
            return f'skip "{_words(subject.refusal)}"\n'
        sizes = (each.decision.size for each in subject.found.coverage.decisions)
        # a single condition decides alone: clang counts those of larger decisions
        conditions = sum(size for size in sizes if size > 1)
        return filled("evidence/coverage.sh", flags=FLAGS, conditions=conditions)

    @classmethod
    def files(cls, subject: Subject) -> dict[str, str]:
        """See `EvidenceKind.files`."""
        found = subject.found
        if found is None:
            return {}
        return {
            "coverage/conditions.csv": _conditions(found),
            "coverage/justified.txt": _as_listed_by_clang(found.reasons),
            "coverage/confirm.txt": _as_listed_by_clang(found.possible)
            + _unevaluated_lines({**found.reasons, **found.possible}),
            "coverage/missing.awk": filled("evidence/missing.awk"),
        }

    @classmethod
    def notes(cls, subject: Subject) -> list[str]:
        """See `EvidenceKind.notes`."""
        found = subject.found
        if found is None:
            return [f"The test vectors are the test run only; {subject.refusal}."]
        return shown(found)


def _words(text: str) -> str:
    """Text for a string of a shell script."""
    return re.sub(r'["\\$`]', "'", text)


def _conditions(found: Found) -> str:
    """All conditions as CSV, with the rows of the vectors that show them."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows(condition_rows(found))
    return text.getvalue()


def _as_listed_by_clang(reasons: Mapping[Gap, str]) -> str:
    """What cannot be shown: kind and position as in the report of clang, with the reason."""
    lines = []
    for gap, reason in reasons.items():
        kind = f"condition {gap.at}" if gap.want == "alone" else f"branch {gap.at} {gap.want}"
        lines.append(f"{kind}\t{reason}\n")
    return "".join(sorted(lines))


def _unevaluated_lines(reasons: Mapping[Gap, str]) -> str:
    """Second lines of conditions that are not evaluated, if they have one: not executed."""
    found = {
        f"line {gap.at.line + 1}\t{reason}\n"
        for gap, reason in reasons.items()
        if gap.want == "true" and replace(gap, want="false") in reasons
    }
    return "".join(sorted(found))
