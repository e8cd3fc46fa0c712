"""Trace from the equations of a law to the lines of C and to the steps that execute them."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.codegen.flight.measure import FLAGS
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.evidence.trace import Group, Requirement, table, trace, traced
from gyrostat.exports.template import filled


class Trace(EvidenceKind):
    """Steps of the test run that execute the statements of each equation."""

    name = "trace"
    title = "equations, their lines of C and the steps that execute them"
    tools: ClassVar[Mapping[str, str]] = {"cc": "cc gcc clang"}

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        return filled("evidence/trace.sh", flags=FLAGS)

    @classmethod
    def files(cls, subject: Subject) -> dict[str, str]:
        """See `EvidenceKind.files`."""
        requirements, groups = trace(subject.module)
        return {
            "trace/requirements.csv": table(Requirement, requirements),
            "trace/groups.csv": table(Group, groups),
            "trace/traced.c": traced(subject.module, groups, subject.target.steps[0].name),
            "trace/recorder.c": filled("evidence/trace/recorder.c", count=len(groups)),
        }
