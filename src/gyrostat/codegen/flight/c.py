"""Emit a C module from Python functions."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import header, prototype, wrapped
from gyrostat.codegen.flight.identifiers import comment, free_name, identifier
from gyrostat.codegen.flight.module import Entry, Module, Port, Precision
from gyrostat.codegen.flight.moves import moves
from gyrostat.codegen.flight.structs import Leaf, Struct, Structs, scalars
from gyrostat.codegen.flight.write import Writer, may_stop_early
from gyrostat.codegen.lower import Lowering
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Block, Function, Name, Operand
from gyrostat.codegen.prune import prune
from gyrostat.codegen.tracing import as_arrays, trace
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax


@dataclass(frozen=True)
class _Root:
    entry: Entry
    function: Function
    ports: tuple[Port, ...]
    stores: tuple[str, ...]


def emit(name: str, entries: Sequence[Entry], precision: Precision = "double") -> Module:
    """Emit functions as C99 that needs only math.h.

    Args:
        name: Name of the module.
        entries: Entry points.
        precision: Precision of real numbers.

    Returns:
        The module. The same functions give the same module, byte by byte. Every entry returns 0,
        or 1 if a loop has reached its largest number of passes.

    Raises:
        InputError: An entry has a side effect, an unbounded loop, a shape that depends on data, an
            array of more than `scope.LARGEST` elements or a primitive that flight code does not
            support; the message names the line of Python.
    """
    dialect, structs, lowering = Dialect(precision), Structs(), Lowering()
    roots = [_lowered(entry, structs, lowering) for entry in entries]
    tops = [root.function for root in roots]
    inner = [f for f in prune([*lowering.functions, *tops], tops) if f not in tops]
    reserved = {identifier(struct.name) for struct in structs.every} | {f.name for f in tops}
    for function in inner:
        function.name = free_name(identifier(function.name), reserved)
        reserved.add(function.name)
    helpers: set[str] = set()
    texts = [_inner(function, dialect, reserved, helpers) for function in inner]
    texts += [_entry(root, dialect, reserved, helpers) for root in roots]
    used = [dialect.helper(each) for each in sorted(helpers)]
    source = "\n".join(
        [
            _TOP.format(name=name, memory=_MEMORY if "finite" in helpers else ""),
            *used,
            *texts,
        ]
    )
    declared = header(
        name, structs.every, structs.enums, [(root.entry, root.ports) for root in roots], dialect
    )
    ports = {root.entry.name: root.ports for root in roots}
    return Module(name, declared, source, tuple(structs.every), ports, (*inner, *tops))


_TOP = """\
/* Made by gyrostat from Python; the comments name the line of Python that each group of
   statements comes from. No heap, no recursion, no globals; nothing is linked but math.h. */
#include "{name}.h"

#include <math.h>
{memory}
#ifdef __FAST_MATH__
#error "fast-math changes results and what becomes of NaN: leave it off"
#endif
"""
_MEMORY = "#include <string.h>\n"


def _lowered(entry: Entry, structs: Structs, lowering: Lowering) -> _Root:
    """Entry as a function of scalars, which are fields of structs."""
    for name in (entry.name, *entry.arguments, *entry.results):
        if identifier(name) != name:
            raise InputError(f"{entry.name}: found the name {name!r}, expected a free name of C")
    arguments = {name: as_arrays(tree) for name, tree in entry.arguments.items()}
    traced = trace(entry.function, list(arguments.values()), entry.name)
    contents = {n: structs.of(tree, f"{entry.name}_{n}") for n, tree in arguments.items()}
    inputs: list[Scalars] = []
    for name, tree in arguments.items():
        inputs += _scalars(name, contents[name], name in entry.results, tree)
    body: Block = []
    made = lowering.graph(traced.jaxpr, inputs, body)
    trees = traced.results if len(entry.results) > 1 else (traced.results,)
    if not isinstance(trees, tuple) or len(trees) != len(entry.results):
        raise InputError(
            f"{entry.name}: found {len(entry.results)} names of results, expected as many as the "
            "function returns"
        )
    stores: list[str] = []
    for name, tree in zip(entry.results, trees, strict=True):
        content = structs.of(tree, f"{entry.name}_{name}")
        if contents.setdefault(name, content) != content:
            raise InputError(
                f"{entry.name}: found a result {name} of another shape than the argument, "
                "expected it to take its place"
            )
        places = _scalars(name, content, True, tree)
        stores += [place.hint for array in places for place in array.flat]
    ports = tuple(
        Port(name, content, name in arguments, name in entry.results)
        for name, content in contents.items()
        if content is not None
    )
    flat: list[Operand] = [operand for array in made for operand in array.flat]
    return _Root(entry, Function(entry.name, [], body, flat), ports, tuple(stores))


def _scalars(name: str, content: Leaf | Struct | None, is_set: bool, tree: Any) -> list[Scalars]:
    """C expressions for the leaves of an argument, in JAX's order."""
    empty = [np.empty(leaf.shape, dtype=object) for leaf in jax.tree.leaves(tree)]
    if content is None:
        return empty
    address = isinstance(content, Leaf) and not content.shape and is_set
    filled = iter(scalars(content, f"(*{name})" if address else name))
    return [next(filled) if array.size else array for array in empty]


def _inner(function: Function, dialect: Dialect, reserved: set[str], helpers: set[str]) -> str:
    """C text of an internal function of the module."""
    writer = Writer(dialect, reserved)
    stops = may_stop_early(function)
    parameters = [
        f"{dialect.type_of(p.kind)} {writer.name(p, p.hint)}" for p in function.parameters
    ]
    single = len(function.results) == 1 and not stops
    outs = [] if single else [writer.free(_out(result)) for result in function.results]
    parameters += [
        f"{dialect.type_of(result.kind)} *{out}"
        for result, out in zip(function.results, outs, strict=False)
    ]
    kind = dialect.type_of(function.results[0].kind) if single else "int" if stops else "void"
    if stops:
        writer.line("int status = 0;")
    lines = writer.body(function.body, function.results)
    for result, out in zip(function.results, outs, strict=False):
        writer.line(f"*{out} = {writer.text(result).text};")
    if single or stops:
        value = writer.text(function.results[0]).text if single else "status"
        writer.line(f"return {value};")
    lines += writer.taken_lines()
    helpers |= writer.helpers
    head = wrapped(f"static {kind} {function.name}({', '.join(parameters)})")
    return "\n".join([f"/* {comment(str(function.source))} */", head, "{", *lines, "}", ""])


def _out(result: Operand) -> str:
    return f"{result.hint or 'value'}_out" if isinstance(result, Name) else "constant_out"


def _entry(root: _Root, dialect: Dialect, reserved: set[str], helpers: set[str]) -> str:
    """C text of an entry point."""
    names = {port.name for port in root.ports}
    writer = Writer(dialect, reserved | names)
    stops = may_stop_early(root.function)
    if stops:
        writer.line("int status = 0;")
    lines = writer.body(root.function.body, root.function.results, root.stores)
    wanted = [
        (place, writer.text(result).text, dialect.type_of(result.kind))
        for place, result in zip(root.stores, root.function.results, strict=True)
        if place not in writer.done
    ]
    for text in moves(wanted, writer.free):
        writer.line(text)
    lines += ["", *writer.taken_lines()]
    read = re.sub(r"/\*.*?\*/", "", "\n".join(lines), flags=re.DOTALL)
    # ignore a member of another argument with the same name
    unread = [p.name for p in root.ports if not re.search(rf"(?<![.>])\b{p.name}\b", read)]
    lines += [f"    (void){name};" for name in unread]
    lines.append("    return status;" if stops else "    return 0;")
    helpers |= writer.helpers
    return "\n".join([prototype(root.entry.name, root.ports, dialect), "{", *lines, "}", ""])
