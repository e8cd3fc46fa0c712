"""Trace from the requirements of a law to the lines of C.

A requirement is a function or class in Python, of which the docstring says what it must compute and
from which source. Its equations are lines of Python, which comments in the C code name.
"""

import csv
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields

from gyrostat.codegen.flight.module import Module
from gyrostat.codegen.program import statements
from gyrostat.codegen.source import NOWHERE, Source

_COMMENT = re.compile(r" +/\* (\S+\.py):(\d+)(?:: | \*/)")
_SECTION = re.compile(r"^(?:Args|Attributes|Raises|Returns):", re.MULTILINE)
_REFERENCE = re.compile(r"\beqs?\. \(|\b(?:19|20)\d\d\b|\bECSS-|\bIEEE\b|\bNASA\b", re.ASCII)


@dataclass(frozen=True)
class Requirement:
    """What a function or class in Python must compute.

    Attributes:
        identifier: Name in tables, R1 and so on, in the order of the C code.
        name: Name of the function or class.
        file: Python file, from its package on.
        statement: First paragraph of its docstring, or of that of what is around it.
        reference: Paragraph of a docstring that names a source; "" if there is none.
    """

    identifier: str
    name: str
    file: str
    statement: str
    reference: str


@dataclass(frozen=True)
class Group:
    """Statements of C that come from one line of Python.

    Attributes:
        requirement: Identifier of its requirement.
        line: Line of Python.
        equation: Text of that line.
        first: First line in C, that of the comment.
        body: First line after the comment.
        last: Last line.
    """

    requirement: str
    line: int
    equation: str
    first: int
    body: int
    last: int


def trace(module: Module) -> tuple[list[Requirement], list[Group]]:
    """Requirements of a module, and its groups of statements, in the order of the C code."""
    sources = {
        (source.file, source.line): source
        for function in module.functions
        for source in (statement.source for statement in statements(function.body))
    }
    requirements: dict[tuple[str, str], Requirement] = {}
    groups = []
    for file, line, first, body, last in _places(module.source.splitlines()):
        source = sources.get((file, line), NOWHERE)
        name = source.definition.name or file.rpartition("/")[2]
        texts = _texts(source)
        requirement = requirements.setdefault(
            (file, name), Requirement(f"R{len(requirements) + 1}", name, file, *texts)
        )
        groups.append(Group(requirement.identifier, line, source.text, first, body, last))
    return list(requirements.values()), groups


def _places(rows: Sequence[str]) -> Iterable[tuple[str, int, int, int, int]]:
    """Python file and line of each group; first line, line after the comment and last line in C."""
    starts = [(k, match) for k, row in enumerate(rows) if (match := _COMMENT.match(row))]
    for (start, match), (following, _) in zip(
        starts, [*starts[1:], (len(rows), None)], strict=True
    ):
        body = next(k for k in range(start, following) if rows[k].endswith("*/")) + 1
        end = next((k for k in range(body, following) if rows[k] == "}"), following)
        while end > body and rows[end - 1].strip() in ("", "}"):
            end -= 1
        yield match[1], int(match[2]), start + 1, body + 1, end


def _texts(source: Source) -> tuple[str, str]:
    """Statement and reference of the requirement of a line."""
    texts = [_SECTION.split(text)[0].strip() for text in source.definition.docstrings]
    paragraphs = [[" ".join(part.split()) for part in text.split("\n\n")] for text in texts]
    heads = [each[0] for each in paragraphs if each[0] and not each[0].startswith("See `")]
    references = [each for every in paragraphs for each in every if _REFERENCE.search(each)]
    return (heads or [""])[0], (references or [""])[0]


def table(kind: type, rows: Iterable[Requirement | Group]) -> str:
    """Table of requirements or groups as CSV, with the names of the attributes as its header."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([each.name for each in fields(kind)])
    writer.writerows(map(astuple, rows))
    return text.getvalue()


def traced(module: Module, groups: Sequence[Group], step: str) -> str:
    """C of a module that notes which groups are executed in which steps.

    Args:
        module: Module.
        groups: Its groups.
        step: Entry with which a step begins.
    """
    rows = module.source.splitlines()
    for number, group in reversed(list(enumerate(groups))):
        rows.insert(group.body - 1, f"    trace_reached({number});")
    head = next(k for k, row in enumerate(rows) if row.startswith(f"int {step}("))
    rows.insert(rows.index("{", head) + 1, "    trace_step();")
    declared = ["void trace_step(void);", "void trace_reached(int group);"]
    first = next(k for k, row in enumerate(rows) if row.startswith("#include"))
    return "\n".join([*rows[: first + 1], *declared, *rows[first + 1 :], ""])
