"""Extraction of a definition from a script or a notebook, with the names that it uses."""

import ast
import symtable
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.user_errors import OwnError

LARGEST = 100_000
"""Most numbers of an array that is copied."""
PLAIN = (bool, int, float, complex, str, bytes, type(None))


def extracted(place: str, made: Any) -> tuple[str, str, Path]:
    """File name, text and folder of a definition of `__main__`.

    Imports and definitions that it uses are copied as text; numbers, texts and arrays by their
    values at this time.

    Args:
        place: Name of the part, for messages.
        made: Class or function.

    Raises:
        OwnError: The definition, or a name that it uses, cannot be extracted.
    """
    script = _Script(place, vars(sys.modules["__main__"]))
    script.take(made.__name__)
    file = script.known.get("__file__")
    name = Path(file).stem if file else "notebook"
    folder = Path(file).resolve().parent if file else Path.cwd()
    plain = "".join(c if c.isalnum() else "_" for c in name)
    # two classes of a script need different names, and each has what it uses
    return f"{plain}_{made.__name__}.py", "\n".join([*script.future, *script.lines, ""]), folder


def _texts(known: dict[str, Any]) -> list[str]:
    """Source of `__main__`: the cells of a notebook, or the file of a script."""
    if "In" in known:
        return [*map(str, known["In"])]
    file = known.get("__file__")
    try:
        return [Path(file).read_text(encoding="utf-8")] if file else []
    except (OSError, UnicodeDecodeError):
        return []


class _Script:
    """Names of `__main__` that were needed so far.

    Attributes:
        known: Names of `__main__` with their values.
        future: Imports from `__future__`.
        lines: Text of imports and definitions, each after those that it needs.
    """

    def __init__(self, place: str, known: dict[str, Any]) -> None:
        self.known, self.lines, self.future = known, [], []
        self._place, self._taken = place, set()
        self._found: dict[str, tuple[ast.stmt, str]] = {}
        for text in _texts(known):
            try:
                tree = ast.parse(text)
            except SyntaxError:
                continue
            for node in _statements(tree.body):
                if isinstance(node, ast.ImportFrom) and node.module == "__future__":
                    self.future = [ast.unparse(node)]
                for name in _bound(node):
                    self._found[name] = node, text

    def take(self, name: str) -> None:
        """Add a name, after the names that it needs.

        Raises:
            OwnError: It cannot be extracted.
        """
        if name in self._taken:
            return
        self._taken.add(name)
        node, text = self._found.get(name, (None, ""))
        value = self.known[name]
        if isinstance(node, ast.Import | ast.ImportFrom):
            alias = next(
                a for a, bound in zip(node.names, _bound(node), strict=True) if bound == name
            )
            if isinstance(node, ast.Import):
                self.lines.append(ast.unparse(ast.Import([alias])))
            else:
                self.lines.append(ast.unparse(ast.ImportFrom(node.module, [alias], node.level)))
        elif isinstance(node, ast.FunctionDef | ast.ClassDef) or (
            # a named tuple, a lambda, or a function made by a call
            isinstance(node, ast.Assign)
            and isinstance(node.value, ast.Call | ast.Lambda)
            and callable(value)
        ):
            for needed in _needed(node):
                if needed in self.known:
                    self.take(needed)
            self.lines.append(_text_of(node, text))
        else:
            self.lines.append(f"{name} = {self._literal(name, value)}")

    def _literal(self, name: str, value: Any) -> str:
        """Expression of a value, exact to the last bit."""
        if isinstance(value, float) and not np.isfinite(value):
            return f"float({str(value)!r})"
        if type(value) in PLAIN:
            return repr(value)
        if isinstance(value, tuple | list) and type(value) in (tuple, list):
            inner = "".join(f"{self._literal(name, entry)}, " for entry in value)
            return f"({inner})" if isinstance(value, tuple) else f"[{inner}]"
        if type(value) is dict:
            pairs = [
                f"{self._literal(name, k)}: {self._literal(name, v)}" for k, v in value.items()
            ]
            return f"{{{', '.join(pairs)}}}"
        kind = type(value).__module__.partition(".")[0]
        if kind in ("numpy", "jax", "jaxlib") and getattr(value, "size", LARGEST + 1) <= LARGEST:
            array = np.asarray(value)
            if array.dtype.kind in "bif":
                library = "numpy" if kind == "numpy" else "jax.numpy"
                self.lines.append(f"import {library}")
                text = self._literal(name, array.tolist())
                return f"{library}.asarray({text}, dtype='{array.dtype}')"
        raise OwnError(
            f"{self._place}: found {name}, a {type(value).__name__} of the script, expected "
            "numbers, arrays, functions, classes and imports; or put the class into a file of its "
            "own and import it"
        )


def _statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements of a module, also those inside if, try and with."""
    for node in body:
        yield node
        for name in ("body", "orelse", "finalbody"):
            if isinstance(node, ast.If | ast.Try | ast.With):
                yield from _statements(getattr(node, name, []))
        if isinstance(node, ast.Try):
            for handler in node.handlers:
                yield from _statements(handler.body)


def _bound(node: ast.stmt) -> list[str]:
    """Names that a statement binds."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        return [alias.asname or alias.name.partition(".")[0] for alias in node.names]
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    targets = node.targets if isinstance(node, ast.Assign) else []
    return [target.id for target in targets if isinstance(target, ast.Name)]


def _text_of(node: ast.stmt, text: str) -> str:
    """Lines of a statement, with its decorators."""
    decorators = getattr(node, "decorator_list", [])
    first = min([node.lineno, *(d.lineno for d in decorators)])
    return textwrap.dedent("\n".join(text.splitlines()[first - 1 : node.end_lineno]))


def _needed(node: ast.stmt) -> list[str]:
    """Global names that a definition refers to, also in its annotations."""
    text = ast.unparse(node)
    found: dict[str, None] = {}

    def visit(table: symtable.SymbolTable) -> None:
        top = table.get_type() == "module"
        for symbol in table.get_symbols():
            if symbol.is_referenced() and (symbol.is_global() or top):
                found[symbol.get_name()] = None
        for inner in table.get_children():
            visit(inner)

    visit(symtable.symtable(text, "script", "exec"))
    for inner in ast.walk(node):
        for name in ("annotation", "returns"):
            hint = getattr(inner, name, None)
            for part in ast.walk(hint) if hint is not None else ():
                if isinstance(part, ast.Name):
                    found[part.id] = None
    own = {getattr(node, "name", "")}
    return [name for name in found if name not in own and not name.startswith("__")]
