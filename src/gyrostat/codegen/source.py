"""Source line of each operation, and errors for operations that cannot be compiled."""

import ast
import functools
import linecache
import os
import sys
import sysconfig
import threading
from pathlib import Path
from typing import Any, NamedTuple

import equinox
import numpy as np

from gyrostat.core import traced_once
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax

_LIBRARIES = tuple(
    str(Path(folder).resolve()) + os.sep
    for folder in (
        Path(jax.__file__).parent,
        Path(equinox.__file__).parent,
        Path(np.__file__).parent,
        sysconfig.get_path("stdlib"),
    )
)


class Definition(NamedTuple):
    """Innermost function or class with a docstring that contains a line of Python.

    Without any docstring it is the outermost one.

    Attributes:
        name: Its name with those of the functions and classes around it; "" outside of all.
        docstrings: Its docstring, then those of what is around it, the module's last; those that
            exist.
    """

    name: str
    docstrings: tuple[str, ...]


class Source(NamedTuple):
    """Line of Python.

    Attributes:
        file: Path from the package on, such as gyrostat/control/attitude_pid.py, without folders
            of the machine.
        line: Line number.
        text: Text of the line, stripped.
        name: Name that the line assigns to, or function that it returns from; "" for neither.
        part: Class that contains the line, otherwise function; "" for neither.
        definition: Function or class with a docstring that contains the line.
    """

    file: str
    line: int
    text: str
    name: str
    part: str = ""
    definition: Definition = Definition("", ())

    @property
    def place(self) -> str:
        """File and line."""
        return f"{self.file}:{self.line}"

    def __str__(self) -> str:
        return f"{self.place}: {self.text}"


NOWHERE = Source("", 0, "", "")


def source(equation: Any, otherwise: Source) -> Source:
    """Innermost line of Python, outside libraries and decorators, that an equation comes from."""
    traceback = equation.source_info.traceback
    for frame in traceback.frames if traceback is not None else ():
        if frame.file_name != traced_once.__file__ and not in_library(frame.file_name):
            return source_at(frame.file_name, frame.line_num)
    return otherwise


class UnsupportedError(InputError):
    """Operation that cannot be compiled.

    Attributes:
        what: The operation.
        equations: Its equation and those that contain it, the innermost first.
    """

    def __init__(self, text: str, what: str):
        super().__init__(text)
        self.what = what
        self.equations: list[Any] = []


def refused(equation: Any, where: Source, what: str, expected: str) -> UnsupportedError:
    """Error for an equation that neither flight code nor SIMD code can contain."""
    return refusal(where, f"{what} ({equation.primitive.name})", expected)


def refusal(where: Source, what: str, expected: str) -> UnsupportedError:
    """Error that names the part of the loop and the line of Python; see `refused`."""
    part = f"{where.part}: " if where.part else ""
    return UnsupportedError(f"{part}{where}: found {what}, expected {expected}", what)


@functools.cache
def in_library(file: str) -> bool:
    """Whether a file belongs to a library, or there is no file."""
    return file.startswith("<") or str(Path(file).resolve()).startswith(_LIBRARIES)


@functools.cache
def source_at(file: str, line: int) -> Source:
    """Line of a file."""
    path = Path(file)
    short_path = path.name
    # keep the path from the outermost package on
    while (path.parent / "__init__.py").exists():
        path = path.parent
        short_path = f"{path.name}/{short_path}"
    text, name = linecache.getline(file, line).strip(), _names_at(file).get(line, "")
    inside = [d for first, last, d in _definitions(file) if first <= line <= last]
    definition = inside[-1] if inside else Definition("", ())
    return Source(short_path, line, text, name, _part_at(file).get(line, ""), definition)


@functools.cache
def _definitions(file: str) -> list[tuple[int, int, Definition]]:
    """First line, last line and definition of a file and of all in it, the innermost last."""
    tree = _syntax_tree(file)
    definitions: list[tuple[int, int, Definition]] = []

    def add(node: ast.Module | ast.ClassDef | ast.FunctionDef, around: Definition) -> None:
        text, lines = ast.get_docstring(node), (0, sys.maxsize)
        here = Definition("", (text,) if text else ())
        if not isinstance(node, ast.Module):
            lines = node.lineno, node.end_lineno or node.lineno
            here = around
            if text or not around.name:
                name = f"{around.name}.{node.name}".lstrip(".")
                here = Definition(name, (*([text] if text else []), *around.docstrings))
        definitions.append((*lines, here))
        visit(node, here)

    def visit(node: ast.AST, around: Definition) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.ClassDef | ast.FunctionDef):
                add(child, around)
            else:
                visit(child, around)

    if tree is not None:
        add(tree, Definition("", ()))
    return definitions


@functools.cache
def _part_at(file: str) -> dict[int, str]:
    """Line -> outermost class or function that contains it."""
    tree = _syntax_tree(file)
    parts: dict[int, str] = {}
    for part in tree.body if tree is not None else ():
        if isinstance(part, ast.ClassDef | ast.FunctionDef):
            lines = range(part.lineno, (part.end_lineno or part.lineno) + 1)
            parts.update(dict.fromkeys(lines, part.name))
    return parts


# CPython 3.11 counts the recursion of its parser once for all threads, and fails if two parse.
_one_at_a_time = threading.Lock()


@functools.cache
def _syntax_tree(file: str) -> ast.Module | None:
    with _one_at_a_time:
        try:
            return ast.parse("".join(linecache.getlines(file)))
        except SyntaxError:
            return None


@functools.cache
def _names_at(file: str) -> dict[int, str]:
    """Line -> name that it defines, by an assignment, a keyword argument or a function."""
    tree = _syntax_tree(file)
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
                    # constant arguments such as strict=True name no result
                    name = "" if isinstance(value, ast.Constant) else argument
            if name and isinstance(child, ast.stmt | ast.keyword):
                length = (child.end_lineno or child.lineno) - child.lineno
                spans.append((length, isinstance(child, ast.keyword), child.lineno, name))
            inner = isinstance(child, ast.FunctionDef) and child.name
            visit(child, inner or function)

    visit(tree, "")
    names: dict[int, str] = {}
    # the shortest span of lines takes precedence, and a statement over an argument
    for length, _, first, name in sorted(spans):
        for line in range(first, first + length + 1):
            names.setdefault(line, name.strip("_"))
    return names
