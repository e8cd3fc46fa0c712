"""C text of the functions of a module."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from gyrostat.codegen.dependencies import stored
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import parameter, prototype, wrapped
from gyrostat.codegen.flight.identifiers import comment
from gyrostat.codegen.flight.module import Entry, Port
from gyrostat.codegen.flight.moves import moves
from gyrostat.codegen.flight.pointers import pointers_of
from gyrostat.codegen.flight.write import Writer
from gyrostat.codegen.program import Function, Name, Operand, Table


@dataclass(frozen=True)
class Root:
    """Entry as a function of scalars.

    Attributes:
        entry: The entry.
        function: Its function.
        ports: Its arguments in C.
        stores: C expression of the destination of each result.
    """

    entry: Entry
    function: Function
    ports: tuple[Port, ...]
    stores: tuple[str, ...]


@dataclass(frozen=True)
class ModuleWriter:
    """Writer of the functions of a module.

    Attributes:
        dialect: Type of real numbers.
        reserved: Names of structs, functions and tables of the module.
        tables: Constant tables that several functions read, with their names.
        helpers: Operations that need a helper function, of the functions written so far.
    """

    dialect: Dialect
    reserved: set[str]
    tables: Mapping[Table, str]
    helpers: set[str] = field(default_factory=set)

    def _writer(self, taken: Iterable[str]) -> Writer:
        """Writer of a function that has arguments of some names."""
        return Writer(self.dialect, {*self.reserved, *taken}, self.tables)

    def inner(self, function: Function, ports: Sequence[Port]) -> str:
        """C text of an internal function of the module."""
        writer = self._writer(function.given)
        parameters = [parameter(port, self.dialect) for port in ports]
        parameters += [
            f"{self.dialect.type_of(p.kind)} {writer.name(p, p.hint)}" for p in function.parameters
        ]
        changed = stored(function.body)
        parameters += [
            f"{'' if table in changed else 'const '}{self.dialect.type_of(table.kind)} "
            f"{writer.name(table, (table.hint or 'value') + '_table')}[{table.size}]"
            for table in function.tables
        ]
        single = len(function.results) == 1
        outs = [] if single else [writer.free(_out(result)) for result in function.results]
        parameters += [
            f"{self.dialect.type_of(result.kind)} *{out}"
            for result, out in zip(function.results, outs, strict=False)
        ]
        kind = self.dialect.type_of(function.results[0].kind) if single else "void"
        writer.pointers = pointers_of(function, (), ports, writer.free)
        lines = writer.body(function.body, function.results)
        for result, out in zip(function.results, outs, strict=False):
            writer.line(f"*{out} = {writer.text(result).text};")
        if single:
            writer.line(f"return {writer.text(function.results[0]).text};")
        lines += writer.taken_lines()
        self.helpers.update(writer.helpers)
        head = wrapped(f"static {kind} {function.name}({', '.join(parameters)})")
        lines = [*_pointer_lines(writer), *lines]
        return "\n".join([f"/* {comment(str(function.source))} */", head, "{", *lines, "}", ""])

    def entry(self, root: Root) -> str:
        """C text of an entry point."""
        writer = self._writer([port.name for port in root.ports])
        writer.pointers = pointers_of(root.function, root.stores, root.ports, writer.free)
        lines = writer.body(root.function.body, root.function.results, root.stores)
        assignments = [
            (
                writer.pointers.path(destination),
                writer.text(result).text,
                self.dialect.type_of(result.kind),
            )
            for destination, result in zip(root.stores, root.function.results, strict=True)
            if destination not in writer.done
        ]
        for text in moves(assignments, writer.free):
            writer.line(text)
        lines += ["", *writer.taken_lines()]
        lines = [*_pointer_lines(writer), *lines]
        read = re.sub(r"/\*.*?\*/", "", "\n".join(lines), flags=re.DOTALL)
        # ignore a member of another argument with the same name
        unread = [p.name for p in root.ports if not re.search(rf"(?<![.>])\b{p.name}\b", read)]
        lines += [f"    (void){name};" for name in unread]
        lines.append("    return 0;")
        self.helpers.update(writer.helpers)
        return "\n".join(
            [prototype(root.entry.name, root.ports, self.dialect), "{", *lines, "}", ""]
        )


def _pointer_lines(writer: Writer) -> list[str]:
    """Lines that declare the pointers of the lines written so far."""
    for text in writer.pointers.declarations():
        writer.line(text)
    return writer.taken_lines()


def _out(result: Operand) -> str:
    return f"{result.hint or 'value'}_out" if isinstance(result, Name) else "constant_out"
