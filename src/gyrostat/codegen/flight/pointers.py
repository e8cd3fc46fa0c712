"""Pointers to structs inside the arguments of a function, for members with long paths."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from gyrostat.codegen.dependencies import read_by
from gyrostat.codegen.flight.module import Port
from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.codegen.program import (
    Assign,
    Function,
    Name,
    Operand,
    Store,
    Table,
    statements,
)

LEAST = 4
"""Least number of uses of a pointer."""


@dataclass
class Pointers:
    """Pointers of a function, each to a struct inside an argument.

    Attributes:
        names: Path of the struct -> name of the pointer.
        declared: Path -> declaration in C, with the paths of other pointers written out.
        used: Paths of the pointers that the text uses.
    """

    names: dict[str, str] = field(default_factory=dict)
    declared: dict[str, str] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)

    def path(self, text: str) -> str:
        """Path of a number or an array, from the pointer to its struct if there is one."""
        for outer in _outer(text):
            if outer in self.names:
                self.used.add(outer)
                return f"{self.names[outer]}->{text[len(outer) + 1 :]}"
        return text

    def declarations(self) -> list[str]:
        """Declarations of the pointers that are used, each after those that it uses."""
        lines: list[str] = []
        for path in sorted(self.names, key=len, reverse=True):
            if path in self.used:
                lines.append(f"{self.declared[path]} = &{self.path(path)};")
        return lines[::-1]


def pointers_of(
    function: Function, stores: Sequence[str], ports: Sequence[Port], free: Callable[[str], str]
) -> Pointers:
    """Pointers that make the text of a function shorter.

    Args:
        function: Function.
        stores: Path of the destination of each result; () for a function inside the module.
        ports: Arguments of the caller that it reads or sets.
        free: Function that gives an unused C name.
    """
    results, stores = _moved(function.results, stores) if stores else (function.results, ())
    structs = {port.name: port.content for port in ports}
    is_set = {port.name for port in ports if port.set}
    paths = [*_paths(function, results), *stores]
    uses = Counter(next(_outer(path), "") for path in paths)
    changed = {outer for path in _changed(function, stores) for outer in _outer(path)}
    pointers = Pointers()
    waiting = {outer for path in uses for outer in (path, *_outer(path))}
    for path in sorted(waiting, key=lambda each: (-each.count("."), each)):
        struct = _struct(path, structs)
        parent, count = next(_outer(path), ""), uses[path]
        if struct is None:
            continue
        member = path.replace("->", ".").split(".")
        name = "_".join(member[-2:]) if member[-1].startswith("item_") else member[-1]
        constant = "" if member[0] in is_set and path in changed else "const "
        declared = f"{constant}{struct.name} *const "
        saved = count * (len(path) - len(name) - 1) - len(declared) - len(name) - len(path)
        if count >= LEAST and saved > len(path):
            pointers.names[path] = free(name)
            pointers.declared[path] = declared + pointers.names[path]
            count = 1
        uses[parent] += count
    return pointers


def _outer(path: str) -> Iterator[str]:
    """Paths of the structs inside an argument that contain a path, the innermost first."""
    end = path.rfind(".")
    while end > 0:
        yield path[:end]
        end = path.rfind(".", 0, end)


def _moved(
    results: Sequence[Operand], stores: Sequence[str]
) -> tuple[list[Operand], tuple[str, ...]]:
    """Results that are not at their destination already, and the destinations of these."""
    pairs = [
        (result, place)
        for result, place in zip(results, stores, strict=True)
        if not (isinstance(result, Name) and result.fixed and result.hint == place)
    ]
    return [result for result, _ in pairs], tuple(place for _, place in pairs)


def _paths(function: Function, results: Sequence[Operand]) -> Iterator[str]:
    """Paths that the text of a function reads, one for each use."""
    for statement in statements(function.body):
        if isinstance(statement, Assign | Store) and statement.table is not None:
            yield from _table(statement.table)
        yield from _fixed(read_by(statement))
    yield from _fixed(results)


def _changed(function: Function, stores: Sequence[str]) -> Iterator[str]:
    for statement in statements(function.body):
        if isinstance(statement, Store):
            yield from _table(statement.table)
    yield from stores


def _table(table: Table) -> Iterator[str]:
    if table.shape:
        yield table.hint


def _fixed(operands: Iterable[object]) -> Iterator[str]:
    for each in operands:
        if isinstance(each, Name) and each.fixed:
            yield each.hint


def _struct(path: str, structs: dict[str, Leaf | Struct]) -> Struct | None:
    """Struct at a path; None if it is an argument itself or in none of these."""
    port, *members = path.replace("->", ".").split(".")
    content = structs.get(port)
    for name in members:
        if not isinstance(content, Struct):
            return None
        content = next((m.content for m in content.members if m.name == name), None)
    return content if members and isinstance(content, Struct) else None
