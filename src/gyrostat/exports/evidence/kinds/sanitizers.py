"""Test run with the sanitizers of a compiler."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.codegen.flight.measure import FLAGS
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled


class Sanitizers(EvidenceKind):
    """No invalid access and no undefined behaviour in the test run (ASan, UBSan)."""

    name = "sanitizers"
    title = "no invalid access and no undefined behaviour in the test run (ASan, UBSan)"
    tools: ClassVar[Mapping[str, str]] = {"cc": "gcc clang clang-19"}

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        return filled("evidence/sanitizers.sh", flags=FLAGS)
