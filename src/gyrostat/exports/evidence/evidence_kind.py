"""Base of the kinds of evidence, whose classes are in `kinds`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from gyrostat.codegen.flight.module import Module, Precision
from gyrostat.exports.target import Target
from gyrostat.exports.vectors.find import Found


@dataclass(frozen=True)
class Subject:
    """Emitted code that evidence is about.

    Attributes:
        target: Flight module.
        module: Its C code.
        precision: Precision of its real numbers.
        texts: Files of the flight folder without evidence: name -> text.
        found: Test vectors that were sought, and what they show; None without a search.
        refusal: Reason why there was no search.
        deviations: Rule of MISRA C:2012 -> reason of the user for a deviation.
    """

    target: Target
    module: Module
    precision: Precision
    texts: Mapping[str, str]
    found: Found | None = None
    refusal: str = ""
    deviations: Mapping[str, str] = field(default_factory=dict)


class EvidenceKind:
    """Kind of evidence: files for the folder `evidence`, and the script that makes the result.

    The README of this package names the functions and variables of scripts.

    Attributes:
        name: Name of its script and result, an identifier.
        title: One-line title.
        tools: Variable of the script -> programs, separated by spaces. The variable is the first
            one that is installed; without any of them the evidence is not run.
        clause: Clause of ECSS-E-ST-40C to which it contributes, a key of `content.CLAUSES`.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    tools: ClassVar[Mapping[str, str]] = {}
    clause: ClassVar[str] = "5.8.3.5"

    @classmethod
    def script(cls, subject: Subject) -> str:
        """Statements of sh that produce the result, run in the folder `evidence`."""
        raise NotImplementedError

    @classmethod
    def files(cls, subject: Subject) -> dict[str, str]:
        """Further files, such as a harness: name below the folder `evidence` -> text."""
        return {}

    @classmethod
    def notes(cls, subject: Subject) -> list[str]:
        """Lines of Markdown for the README of the flight folder."""
        return []
