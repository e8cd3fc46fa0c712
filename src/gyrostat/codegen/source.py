"""The line of Python that an operation comes from, and what is said where it cannot be compiled."""

import ast
import functools
import linecache
import os
import sysconfig
from pathlib import Path
from typing import Any, NamedTuple

import equinox
import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax

_LIBRARIES = tuple(
    str(Path(place).resolve()) + os.sep
    for place in (
        Path(jax.__file__).parent,
        Path(equinox.__file__).parent,
        Path(np.__file__).parent,
        sysconfig.get_path("stdlib"),
    )
)


class Source(NamedTuple):
    """A line of Python.

    Attributes:
        file: from its package on, as gyrostat/control/attitude_pid.py; no folder of a machine.
        line: number.
        text: of the line, without blanks around it.
        name: what the line gives a value to, or the function that it returns from; "" for neither.
        part: class that the line stands in, or function where there is none; "" for neither.
    """

    file: str
    line: int
    text: str
    name: str
    part: str = ""

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


NOWHERE = Source("", 0, "", "")


def source(equation: Any, otherwise: Source) -> Source:
    """The innermost line of Python that an equation comes from and that is no library's."""
    found = equation.source_info.traceback
    for frame in found.frames if found is not None else ():
        if not in_library(frame.file_name):
            return source_at(frame.file_name, frame.line_num)
    return otherwise


def refused(equation: Any, where: Source, what: str, expected: str) -> InputError:
    """The error for an equation that compiled code has no place for, in flight or in lanes."""
    return refusal(where, f"{what} ({equation.primitive.name})", expected)


def refusal(where: Source, what: str, expected: str) -> InputError:
    """See `refused`; names the part of the loop and the line of Python."""
    part = f"{where.part}: " if where.part else ""
    return InputError(f"{part}{where}: found {what}, expected {expected}")


@functools.cache
def in_library(file: str) -> bool:
    """Whether a file is one of a library's, or of no file at all."""
    return file.startswith("<") or str(Path(file).resolve()).startswith(_LIBRARIES)


@functools.cache
def source_at(file: str, line: int) -> Source:
    """A line of a file."""
    path = Path(file)
    shown = path.name
    # from the outermost package on
    while (path.parent / "__init__.py").exists():
        path = path.parent
        shown = f"{path.name}/{shown}"
    text, name = linecache.getline(file, line).strip(), _named_at(file).get(line, "")
    return Source(shown, line, text, name, _part_at(file).get(line, ""))


@functools.cache
def _part_at(file: str) -> dict[int, str]:
    """Line -> the outermost class or function that it stands in."""
    tree = _parsed(file)
    found: dict[int, str] = {}
    for part in tree.body if tree is not None else ():
        if isinstance(part, ast.ClassDef | ast.FunctionDef):
            lines = range(part.lineno, (part.end_lineno or part.lineno) + 1)
            found.update(dict.fromkeys(lines, part.name))
    return found


@functools.cache
def _parsed(file: str) -> ast.Module | None:
    try:
        return ast.parse("".join(linecache.getlines(file)))
    except SyntaxError:
        return None


@functools.cache
def _named_at(file: str) -> dict[int, str]:
    """Line -> the name that it gives a value to: an assignment's, an argument's, a function's."""
    tree = _parsed(file)
    if tree is None:
        return {}
    spans: list[tuple[int, bool, int, str]] = []

    def visit(node: ast.AST, function: str) -> None:
        for child in ast.iter_child_nodes(node):
            name = ""
            match child:
                case ast.Assign(targets=[ast.Name(id=name)]):
                    pass
                case ast.AnnAssign(target=ast.Name(id=name)):
                    pass
                case ast.AugAssign(target=ast.Name(id=name)):
                    pass
                case ast.Return():
                    name = function
                case ast.keyword(arg=str(argument), value=value):
                    # strict=True and the like name no result
                    name = "" if isinstance(value, ast.Constant) else argument
            if name and isinstance(child, ast.stmt | ast.keyword):
                more = (child.end_lineno or child.lineno) - child.lineno
                spans.append((more, isinstance(child, ast.keyword), child.lineno, name))
            inner = isinstance(child, ast.FunctionDef) and child.name
            visit(child, inner or function)

    visit(tree, "")
    named: dict[int, str] = {}
    # the shortest span of lines wins, a statement over an argument
    for more, _, first, name in sorted(spans):
        for line in range(first, first + more + 1):
            named.setdefault(line, name.strip("_"))
    return named
