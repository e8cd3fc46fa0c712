"""Examples of public names, taken from the code of the pages, examples, benchmarks and tests.

Each page of the interface shows the shortest statement that uses its object; for the result of a
function, that of the function. The statements of the pages run at every build of the documentation,
the others in the tests and benchmarks that contain them.
"""

import ast
import functools
import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
LONGEST = 16  # lines of an example
CODE = re.compile(r"^```(?:\{code-cell\}|python)[^\n]*\n(?::[^\n]*\n)*(.*?)^```", re.S | re.M)
SHOWN = (ast.Assign, ast.AnnAssign, ast.Expr, ast.Assert, ast.For)


class Usage(NamedTuple):
    """Statement that uses a name, the import that brings the name, and its file."""

    statement: str
    imported: str
    path: Path


def sources() -> Iterator[tuple[int, Path, str]]:
    """Rank (the smaller, the easier to follow), file, and each piece of Python in it."""
    for path in [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md"]:
        yield 0, path, "\n".join(CODE.findall(path.read_text(encoding="utf-8")))
    for rank, folder in enumerate(("examples", "benchmarks", "tests"), start=1):
        for path in sorted((ROOT / folder).rglob("*.py")):
            yield rank, path, path.read_text(encoding="utf-8")


def statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that can be shown, those in functions, classes, loops and blocks too."""
    for node in body:
        if isinstance(node, SHOWN):
            yield node
        for inner in ("body", "orelse", "finalbody"):
            yield from statements(getattr(node, inner, []))


@functools.cache
def identity(module: str, name: str) -> str | None:
    """Where a name of a module is defined; None if the module cannot be imported here."""
    try:
        return defined_in(getattr(importlib.import_module(module), name), name)
    except (ImportError, AttributeError):
        return None


def defined_in(thing: object, name: str) -> str:
    """Module and name of a function or class; of other objects, the name."""
    return f"{getattr(thing, '__module__', '')}.{getattr(thing, '__qualname__', name)}"


def imports(tree: ast.Module) -> dict[str, tuple[str, str]]:
    """Local name of each import from a room -> the module and the name there."""
    return {
        alias.asname or alias.name: (node.module or "", alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("gyrostat.")
        for alias in node.names
    }


@functools.cache
def usages() -> dict[str, Usage]:
    """Best usage of each object: of the best rank, then a call with keywords, then the shortest."""
    best: dict[str, tuple[tuple, Usage]] = {}
    for rank, path, code in sources():
        try:
            tree = ast.parse(code)
        except SyntaxError:  # shell commands in a cell
            continue
        imported, lines = imports(tree), code.splitlines()
        for node in statements(tree.body):
            text = lines[node.lineno - 1 : node.end_lineno]
            if len(text) > LONGEST:
                continue
            rest = (line[node.col_offset :] for line in text[1:])
            statement = "\n".join([text[0].strip(), *rest])
            parts = list(ast.walk(node))
            called = {
                id(part.func): not part.keywords for part in parts if isinstance(part, ast.Call)
            }
            for part in parts:
                match part:
                    case ast.Name(id=local) if local in imported:
                        module, name = imported[local]
                        line = f"from {module} import {name}"
                        line += f" as {local}" if local != name else ""
                    case ast.Attribute(value=ast.Name(id="gs"), attr=name):
                        module, line = "gyrostat", "import gyrostat as gs"
                    case _:
                        continue
                where = identity(module, name)
                order = (rank, called.get(id(part), 2), len(text), len(statement))
                if where and (where not in best or order < best[where][0]):
                    best[where] = (order, Usage(statement, line, path))
    return {where: usage for where, (_, usage) in best.items()}


@functools.cache
def returned() -> dict[str, list[str]]:
    """Name of each result -> the functions, and classes with a method, that return it."""
    found: dict[str, list[str]] = {}
    for path in sorted((ROOT / "src").rglob("*.py")):
        module = ".".join(path.relative_to(ROOT / "src").with_suffix("").parts)
        for outer in ast.parse(path.read_text(encoding="utf-8")).body:
            inside = outer.body if isinstance(outer, ast.ClassDef) else [outer]
            for node in inside:
                if isinstance(node, ast.FunctionDef) and node.returns and outer.name[0] != "_":
                    for word in set(re.findall(r"\w+", ast.unparse(node.returns))):
                        found.setdefault(word, []).append(f"{module}.{outer.name}")
    return found


def example(thing: object, name: str) -> list[str]:
    """Lines of reStructuredText with the example of an object; none if nothing uses it."""
    found = [usages().get(where) for where in (defined_in(thing, name), *returned().get(name, ()))]
    usage = next(filter(None, found), None)
    if usage is None:
        return []
    path = usage.path.relative_to(ROOT)
    where = f":doc:`/{path.stem}`" if path.parts[0] == "docs" else f"``{path}``"
    code = [usage.imported, "", *usage.statement.splitlines()]
    return [
        ".. rubric:: Example",
        "",
        f"From {where}:",
        "",
        ".. code-block:: python",
        "",
        *(f"   {line}".rstrip() for line in code),
        "",
    ]
