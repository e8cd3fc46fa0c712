"""Results of evidence, and their files."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from gyrostat.exports.evidence.folder import KINDS

Outcome = Literal["passed", "failed", "not run"]
OUTCOMES = ("passed", "failed", "not run")


@dataclass(frozen=True)
class Figure:
    """Figure of a result; all are texts as the script wrote them.

    Attributes:
        name: What was counted or measured.
        value: Its value.
        unit: Its unit; "" without one.
    """

    name: str
    value: str
    unit: str


@dataclass(frozen=True)
class Result:
    """Result of a kind of evidence.

    Attributes:
        name: Name of the kind.
        title: Its title.
        outcome: Whether the check passed, failed or was not run.
        reason: Why it failed or was not run; "" if it passed.
        code: SHA-256 digest of the code that was checked, header and source.
        tools: Versions of the tools.
        figures: Figures, in the order of the script.
    """

    name: str
    title: str
    outcome: Outcome
    reason: str
    code: str
    tools: tuple[str, ...]
    figures: tuple[Figure, ...]

    def __str__(self) -> str:
        """One line for the user."""
        return f"{self.name}: {self.outcome}{': ' * bool(self.reason)}{self.reason}"


def read_results(folder: Path) -> tuple[Result, ...]:
    """Read the results of a flight folder, in the order of `KINDS`.

    Args:
        folder: Flight folder.

    Returns:
        One result for each kind of evidence. A kind was not run if it has no result file, or one
        of other code than the folder has.
    """
    return tuple(_read(folder, name) for name in KINDS)


def _read(folder: Path, name: str) -> Result:
    path = folder / "evidence" / "results" / f"{name}.txt"
    text = "outcome\tnot run\nreason\tthere is no result"
    if path.is_file():
        text = path.read_text(encoding="utf-8", errors="replace")
    values: dict[str, str] = {"outcome": "failed", "reason": "", "code": ""}
    tools: list[str] = []
    figures: list[Figure] = []
    for line in text.splitlines():
        key, *fields = line.split("\t")
        if key == "figure" and len(fields) == 3:
            figures.append(Figure(*fields))
        elif key == "tool" and fields:
            tools.append(fields[0])
        elif key in values and fields:
            values[key] = fields[0]
    outcome, reason, code = values.values()
    if outcome not in OUTCOMES:
        outcome, reason = "failed", f"found the outcome {outcome!r}"
    if code not in ("", _digest(folder)):
        outcome, reason = "not run", "the result is that of other code"
    return Result(name, KINDS[name].title, outcome, reason, code, tuple(tools), tuple(figures))


def _digest(folder: Path) -> str:
    """Digest of header and source of a flight folder, as the scripts compute it."""
    code = [path for suffix in "hc" for path in folder.glob(f"*.{suffix}")]
    code = [path for path in code if not path.stem.endswith(("_test", "_vectors"))]
    return hashlib.sha256(b"".join(path.read_bytes() for path in code)).hexdigest()
