"""Warnings of compilers."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled


class Warnings(EvidenceKind):
    """No warnings by GCC, its static analysis and clang, nor for the header in C++17."""

    name = "warnings"
    title = "no warnings by compilers, header in C++17"
    tools: ClassVar[Mapping[str, str]] = {"cc": "gcc clang-19 clang cc"}

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        return filled("evidence/warnings.sh")
