"""Definitions of the names of a script or a notebook, found in its text."""

import __future__

import ast
import contextlib
import inspect
import io
import linecache
import sys
import textwrap
import tokenize
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any, NamedTuple

from gyrostat.scenario_files.python.code_equality import nested, same_code


class Definition(NamedTuple):
    """Statement that binds a name.

    Attributes:
        node: Statement.
        text: Text that contains it.
    """

    node: ast.stmt
    text: str


class Definitions:
    """All definitions of the names of a module, also those that were not executed.

    Args:
        known: Names of the module with their values.

    Attributes:
        future: Imports from `__future__`, as text.
    """

    def __init__(self, known: Mapping[str, Any]) -> None:
        self.future: list[str] = []
        self._known = known
        self._read: set[str] = set()
        self._found: dict[str, list[Definition]] = {}
        for text in _texts(known):
            self._add(text)

    def _add(self, text: str) -> None:
        if text in self._read:
            return
        self._read.add(text)
        try:
            tree = ast.parse(text)
        except (SyntaxError, ValueError):
            return
        for node in statements(tree.body):
            if isinstance(node, ast.ImportFrom) and node.module == "__future__":
                self.future = [ast.unparse(node)]
            for inner in _magic_cells(node):
                self._add(inner)
            for name in bound(node):
                self._found.setdefault(name, []).append(Definition(node, text))

    def of(self, name: str) -> list[Definition]:
        """Definitions of a name, the likeliest one of its value first."""
        value = self._known[name]
        codes = [*_codes(value, self._known)]
        for file in {code.co_filename for code in codes}:  # also files that were executed here
            self._add("".join(linecache.getlines(file)))
        definitions = self._found.get(name, [])
        if any(_is_import(each, name, value) for each in definitions):
            return [each for each in reversed(definitions) if _is_import(each, name, value)]
        definitions = [
            each for each in definitions if not isinstance(each.node, ast.Import | ast.ImportFrom)
        ]

        def likelihood(each: tuple[int, Definition]) -> tuple[int, int, int]:
            number, definition = each  # of equal ones the last
            return *_likelihood(definition, codes), number

        return [each for _, each in sorted(enumerate(definitions), key=likelihood, reverse=True)]


def _is_import(definition: Definition, name: str, value: Any) -> bool:
    """Whether a definition is an import statement that binds the name to this value."""
    node = definition.node
    if not isinstance(node, ast.Import | ast.ImportFrom):
        return False
    alias = node.names[bound(node).index(name)]
    if isinstance(node, ast.Import):
        module = alias.name if alias.asname else alias.name.partition(".")[0]
        return sys.modules.get(module) is value
    home = sys.modules.get(node.module or "")
    submodule = sys.modules.get(f"{node.module}.{alias.name}")
    return value is not None and (getattr(home, alias.name, None) is value or submodule is value)


def bound(node: ast.stmt) -> list[str]:
    """Names that a statement binds."""
    if isinstance(node, ast.Import | ast.ImportFrom):
        return [alias.asname or alias.name.partition(".")[0] for alias in node.names]
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return [node.name]
    targets = node.targets if isinstance(node, ast.Assign) else []
    if isinstance(node, ast.AnnAssign) and node.value is not None:
        targets = [node.target]
    return [target.id for target in targets if isinstance(target, ast.Name)]


def text_of(definition: Definition) -> str:
    """Lines of a statement with its decorators, as statements of a module.

    Comments and blank lines are left out, so that they do not make another scenario.
    """
    text = _lines(definition)
    bare = _without_comments(text)
    return bare if _parses_to(bare, definition.node) else text


def _without_comments(text: str) -> str:
    """Text without comments and blank lines, which multi-line texts in it keep."""
    lines = text.splitlines()
    line_numbers: set[int] = set()
    try:
        for token in tokenize.generate_tokens(io.StringIO(text).readline):
            (first, column), (last, _) = token.start, token.end
            if token.type == tokenize.COMMENT:
                lines[first - 1] = lines[first - 1][:column].rstrip()
            elif token.type not in (tokenize.NL, tokenize.NEWLINE):
                line_numbers.update(range(first, last + 1))
    except (tokenize.TokenError, SyntaxError):
        return text
    return "\n".join(line for k, line in enumerate(lines, 1) if k in line_numbers)


def _lines(definition: Definition) -> str:
    """Lines of a statement with its decorators, with the comments in it."""
    node = definition.node
    first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
    lines = "\n".join(definition.text.splitlines()[first - 1 : node.end_lineno])
    plain = textwrap.dedent(lines)
    if _parses_to(plain, node):
        return plain
    inside = f"if True:\n{lines}"  # texts of several lines keep their indentation
    return inside if _parses_to(inside, node) else ast.unparse(node)


def _parses_to(text: str, node: ast.stmt) -> bool:
    try:
        (statement,) = ast.parse(text).body
    except (SyntaxError, ValueError):
        return False
    if isinstance(statement, ast.If) and not isinstance(node, ast.If):
        (statement,) = statement.body
    return ast.dump(statement) == ast.dump(node)


def _texts(namespace: Mapping[str, Any]) -> list[str]:
    """Source of a module: the cells of a notebook, or the file of a script."""
    if "In" in namespace:
        return [*map(str, namespace["In"])]
    file = namespace.get("__file__")
    try:
        return [Path(file).read_text(encoding="utf-8")] if file else []
    except (OSError, UnicodeDecodeError):
        return []


def statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that are executed when a module is imported, also those inside others."""
    for node in body:
        yield node
        if isinstance(node, ast.FunctionDef | ast.ClassDef | ast.AsyncFunctionDef):
            continue
        for name in ("body", "orelse", "finalbody"):
            yield from statements(getattr(node, name, []))
        for part in (*getattr(node, "handlers", ()), *getattr(node, "cases", ())):
            yield from statements(part.body)


def _magic_cells(node: ast.stmt) -> Iterator[str]:
    """Python in the cell of a magic command such as %%time, or in the line of one."""
    call = node.value if isinstance(node, ast.Expr) else None
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute):
        return
    if call.func.attr in ("run_cell_magic", "run_line_magic") and "IPython" in sys.modules:
        from IPython.core.inputtransformer2 import TransformerManager

        last = call.args[-1] if call.args else None
        if isinstance(last, ast.Constant) and isinstance(last.value, str):
            with contextlib.suppress(SyntaxError):
                yield TransformerManager().transform_cell(last.value)


def _codes(value: Any, namespace: Mapping[str, Any]) -> Iterator[CodeType]:
    """Code of the functions of a module that a value consists of."""
    stack, ids = [value], set()
    while stack and len(ids) < 1000:
        each = stack.pop()
        if id(each) in ids:
            continue
        ids.add(id(each))
        if isinstance(each, FunctionType):
            if each.__globals__ is namespace:
                yield each.__code__
            for cell in each.__closure__ or ():
                with contextlib.suppress(ValueError):
                    stack.append(cell.cell_contents)
            stack.append(getattr(each, "__wrapped__", None))
        elif isinstance(each, type):
            if each.__module__ == "__main__":
                stack.extend(vars(each).values())
        else:
            for name in ("__wrapped__", "__func__", "func", "fget", "fset"):
                stack.append(inspect.getattr_static(each, name, None))


def _compile(definition: Definition) -> list[CodeType]:
    """Code objects of a statement."""
    module = ast.Module([definition.node], [])
    flag = __future__.annotations.compiler_flag
    return [*nested(compile(module, "<script>", "exec", flag, dont_inherit=True))]


def _likelihood(definition: Definition, codes: Sequence[CodeType]) -> tuple[int, int]:
    """How many code objects have the lines of a statement, and how many are equal to its own."""
    node, lines = definition.node, definition.text.splitlines()
    first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
    inside = range(first, (node.end_lineno or first) + 1)
    at_lines = [
        code.co_firstlineno in inside
        and linecache.getline(code.co_filename, code.co_firstlineno).rstrip("\n")
        == lines[code.co_firstlineno - 1].rstrip("\n")
        for code in codes
    ]
    statement_codes = _compile(definition) if codes else []
    equal = [any(same_code(code, each) for each in statement_codes) for code in codes]
    return sum(map(all, zip(at_lines, equal, strict=True))), sum(equal)
