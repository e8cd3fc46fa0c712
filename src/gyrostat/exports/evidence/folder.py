"""Files of the folder `evidence`."""

from collections.abc import Mapping

from gyrostat.core.classes_of import classes_of
from gyrostat.exports.evidence import kinds as folder
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled

KINDS: Mapping[str, type[EvidenceKind]] = {
    kind.name: kind for kind in sorted(classes_of(folder, EvidenceKind), key=lambda k: k.name)
}
"""Name -> kind of evidence."""


def evidence_files(subject: Subject) -> dict[str, str]:
    """Scripts and other files of all kinds of evidence: name in the flight folder -> text."""
    files = {
        "run.sh": filled("evidence/run.sh", kinds=" ".join(KINDS)),
        "common.sh": filled("evidence/common.sh", module=subject.module.name),
    }
    for kind in KINDS.values():
        files |= kind.files(subject)
        files[f"{kind.name}.sh"] = _script(kind, subject)
    return {f"evidence/{name}": text for name, text in files.items()}


def _script(kind: type[EvidenceKind], subject: Subject) -> str:
    lines = [f"# {kind.title}", ". ./common.sh", f"begin {kind.name}"]
    for variable, programs in kind.tools.items():
        lines.append(f"need {variable} {programs}")
    return "\n".join([*lines, "", kind.script(subject)])


def evidence_notes(subject: Subject) -> str:
    """Section of the README of the flight folder about evidence."""
    lines = ["| evidence | needs |", "|---|---|"]
    for kind in KINDS.values():
        programs = ", ".join(programs.replace(" ", " or ") for programs in kind.tools.values())
        lines.append(f"| `{kind.name}`: {kind.title} | {programs} |")
    for kind in KINDS.values():
        notes = kind.notes(subject)
        if notes:
            lines += ["", f"### {kind.title}", "", *notes]
    return "\n".join(lines)
