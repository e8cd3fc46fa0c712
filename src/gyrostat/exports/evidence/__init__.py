"""Evidence about emitted code: files of the flight folder that check it, and their results."""

from gyrostat.exports.evidence.content import Content, read_content
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.evidence.folder import KINDS, evidence_files, evidence_notes
from gyrostat.exports.evidence.results import Figure, Outcome, Result, read_results
from gyrostat.exports.evidence.results_text import results_text
from gyrostat.exports.evidence.run import run_evidence

__all__ = [
    "KINDS",
    "Content",
    "EvidenceKind",
    "Figure",
    "Outcome",
    "Result",
    "Subject",
    "evidence_files",
    "evidence_notes",
    "read_content",
    "read_results",
    "results_text",
    "run_evidence",
]
