"""Extraction of a definition from a script or a notebook, with the names that it uses."""

import ast
import symtable
import sys
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import UserPartError
from gyrostat.scenario_files.python.definitions import Definition, Definitions, bound, text_of
from gyrostat.scenario_files.python.literals import LARGEST, PLAIN, NoLiteralError, literal

DATA = (*PLAIN, tuple, list, dict, set, frozenset)
"""Types whose values are copied."""
RESULTS = (
    "xarray",
    *(f"gyrostat.{room}" for room in ("scenario", "runs", "campaigns", "search", "simulation")),
)
"""Modules of results: what makes them is not executed again."""


class Extract(NamedTuple):
    """Definition of a script with the names that it uses.

    Attributes:
        file: Name of its file.
        text: Text of this file.
        folder: Folder of the script.
        chosen: Name -> number of its definition that was chosen, of the likeliest first.
        counts: Name -> number of its definitions.
    """

    file: str
    text: str
    folder: Path
    chosen: Mapping[str, int]
    counts: Mapping[str, int]

    def other(self, names: tuple[str, ...]) -> Mapping[str, int] | None:
        """Next choice of definitions if one of these names, the last first, has another one."""
        for name in reversed(names):
            number = self.chosen.get(name, 0) + 1
            if number < self.counts.get(name, 0):
                return {**self.chosen, name: number}
        return None


def extracted(place: str, made: Any, chosen: Mapping[str, int] | None = None) -> Extract:
    """Definition of `__main__` as a text of its own.

    Imports and definitions that it uses are copied as text; numbers, texts and arrays by their
    values at this time.

    Args:
        place: Name of the part, for messages.
        made: Class or function.
        chosen: Name -> number of its definition, if it has several.

    Raises:
        UserPartError: The definition, or a name that it uses, cannot be extracted.
    """
    script = _Script(place, vars(sys.modules["__main__"]), chosen or {})
    script.take(made.__name__)
    file = script.known.get("__file__")
    name = Path(file).stem if file else "notebook"
    folder = Path(file).resolve().parent if file else Path.cwd()
    plain = "".join(c if c.isalnum() else "_" for c in name)
    text = "\n".join([*script.definitions.future, *script.lines, ""])
    # two classes of a script need different names, and each has what it uses
    return Extract(f"{plain}_{made.__name__}.py", text, folder, script.chosen, script.counts)


class _Script:
    """Names of `__main__` that were needed so far.

    Attributes:
        known: Names of `__main__` with their values.
        definitions: Their definitions.
        lines: Text of imports and definitions, each after those that it needs.
        chosen: See `Extract`.
        counts: See `Extract`.
    """

    def __init__(self, label: str, namespace: dict[str, Any], chosen: Mapping[str, int]) -> None:
        self.known, self.definitions, self.chosen = namespace, Definitions(namespace), chosen
        self.lines: list[str] = []
        self.counts: dict[str, int] = {}
        self._place, self._taken = label, set()

    def take(self, name: str) -> None:
        """Add a name, after the names that it needs.

        Raises:
            UserPartError: It cannot be extracted.
        """
        if name in self._taken:
            return
        self._taken.add(name)
        value = self.known[name]
        definitions = self.definitions.of(name)
        # a statement such as K = K + 1 does not give a value again
        definitions = [each for each in definitions if not _refers_to(each.node, name)]
        definition = definitions[self.chosen.get(name, 0)] if definitions else None
        node = definition.node if definition else None
        if isinstance(node, ast.Import | ast.ImportFrom):
            alias = node.names[bound(node).index(name)]
            names = ast.Import([alias])
            if isinstance(node, ast.ImportFrom):
                names = ast.ImportFrom(node.module, [alias], node.level)
            self.lines.append(ast.unparse(names))
        elif type(value) in DATA or isinstance(value, np.ndarray | np.generic | jax.Array):
            self._assign(name, value, definition)
        elif not self._import(name, value):
            self.counts[name] = len(definitions)
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                self._copy(definition)
            else:
                self._assign(name, value, definition)

    def _import(self, name: str, value: Any) -> bool:
        """Add an import of what is of another module; returns whether it is."""
        if isinstance(value, types.ModuleType) and sys.modules.get(value.__name__) is value:
            self.lines.append(f"import {value.__name__} as {name}")
            return value.__name__ != "__main__"
        home, original = getattr(value, "__module__", None), getattr(value, "__name__", "")
        if not isinstance(home, str) or home == "__main__" or not isinstance(original, str):
            return False
        if not original or getattr(sys.modules.get(home), original, None) is not value:
            return False
        self.lines.append(f"from {home} import {original} as {name}")
        return True

    def _assign(self, name: str, value: Any, definition: Definition | None) -> None:
        """Add a value: by its content, or by its text."""
        node = definition.node if definition else None
        is_text = isinstance(node, ast.Assign | ast.AnnAssign)
        # a named tuple, a lambda, or a function made by a call
        if is_text and isinstance(value, type | types.FunctionType):
            self._copy(definition)
            return
        count = len(self.lines)
        try:
            line = f"{name} = {literal(value, self)}"
        except NoLiteralError:
            del self.lines[count:]
            if not is_text or type(value).__module__.startswith(RESULTS):
                raise UserPartError(
                    f"{self._place}: found {name}, a {type(value).__name__} of the script, expected"
                    f" numbers, arrays of at most {LARGEST} numbers or of one statement, functions"
                    ", classes and imports; or put the class into a file of its own and import it"
                ) from None
            self._copy(definition)
        else:
            self.lines.append(line)

    def _copy(self, definition: Definition | None) -> None:
        """Add the text of a definition, after the names that it needs."""
        assert definition is not None
        for dependency in _dependencies(definition.node):
            if dependency in self.known:
                self.take(dependency)
        self.lines.append(text_of(definition))

    def import_module(self, name: str) -> None:
        """See `gyrostat.scenario_files.python.literals.Module`."""
        self.lines.append(f"import {name}")

    def global_name(self, value: Any) -> str | None:
        """See `gyrostat.scenario_files.python.literals.Module`."""
        name = value.__name__
        if self.known.get(name) is not value:
            return None
        self.take(name)
        return name


def _refers_to(node: ast.stmt, name: str) -> bool:
    """Whether an assignment to a name needs the earlier value of this name."""
    return isinstance(node, ast.Assign | ast.AnnAssign) and name in _dependencies(node)


def _dependencies(node: ast.stmt) -> list[str]:
    """Global names that a definition refers to, also in its annotations."""
    text = ast.unparse(node)
    names: dict[str, None] = {}

    def visit(table: symtable.SymbolTable) -> None:
        top = table.get_type() == "module"
        for symbol in table.get_symbols():
            if symbol.is_referenced() and (symbol.is_global() or top):
                names[symbol.get_name()] = None
        for inner in table.get_children():
            visit(inner)

    visit(symtable.symtable(text, "script", "exec"))
    for inner in ast.walk(node):
        for name in ("annotation", "returns"):
            hint = getattr(inner, name, None)
            for part in ast.walk(hint) if hint is not None else ():
                if isinstance(part, ast.Name):
                    names[part.id] = None
    own_names = {getattr(node, "name", "")}
    return [name for name in names if name not in own_names and not name.startswith("__")]
