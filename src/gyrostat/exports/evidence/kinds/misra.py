"""MISRA C:2012, by the addon of cppcheck."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled

STATUS = "the constants of SampleStatus are for the caller, who compares a status with them"


class Misra(EvidenceKind):
    """No finding of a rule without a recorded deviation, and no deviation without a finding."""

    name = "misra"
    title = "MISRA C:2012, no finding without a recorded deviation (cppcheck)"
    tools: ClassVar[Mapping[str, str]] = {"cppcheck": "cppcheck"}

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        return filled("evidence/misra.sh")

    @classmethod
    def files(cls, subject: Subject) -> dict[str, str]:
        """See `EvidenceKind.files`."""
        rows = [f"{rule}\t{reason}" for rule, reason in _deviations(subject).items()]
        return {"misra/deviations.tsv": "\n".join(["rule\treason", *rows, ""])}

    @classmethod
    def notes(cls, subject: Subject) -> list[str]:
        """See `EvidenceKind.notes`."""
        lines = [
            f"- Deviation from rule {r}: {reason}." for r, reason in _deviations(subject).items()
        ]
        return lines or ["There is no deviation."]


def _deviations(subject: Subject) -> dict[str, str]:
    """Rule -> reason for a deviation."""
    own = {"2.4": STATUS} if "\nenum {" in subject.module.header else {}
    return {**own, **subject.deviations}
