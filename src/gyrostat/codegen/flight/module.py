"""Inputs and output of the C emitter: entry points, ports and the module."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.codegen.given import arguments_set, arguments_used, functions_called
from gyrostat.codegen.program import Function

Precision = Literal["double", "float"]


@dataclass(frozen=True)
class Entry:
    """Function that other C code can call.

    Attributes:
        name: Name in C.
        function: Function of trees of numbers, without side effects.
        arguments: Name in C -> example value. The first ones, in order, are the arguments of
            `function`.
        results: Names of the results. A result with the name of an argument overwrites it.
    """

    name: str
    function: Callable[..., Any]
    arguments: Mapping[str, Any]
    results: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names in C of the entry, its arguments and its results."""
        return self.name, *self.arguments, *self.results

    def named(self, returned: Any) -> dict[str, Any]:
        """Name -> result, of what the function returns: the result, or a tuple of several."""
        several = returned if len(self.results) > 1 else (returned,)
        return dict(zip(self.results, several, strict=True))


@dataclass(frozen=True)
class Port:
    """Argument of an entry in C.

    Attributes:
        name: Name in C.
        content: Type. A struct is passed by address, a number by value, or by address if C sets it.
        given: Whether C reads it.
        set: Whether C writes it.
    """

    name: str
    content: Leaf | Struct
    given: bool
    set: bool


@dataclass(frozen=True)
class Module:
    """Emitted C module.

    Attributes:
        name: Base name of the files.
        header: Text of NAME.h.
        source: Text of NAME.c.
        structs: Structs, each after those that it contains.
        ports: Entry -> its arguments in C.
        functions: Functions of the program, for the operation count; the entries come last.
    """

    name: str
    header: str
    source: str
    structs: tuple[Struct, ...]
    ports: Mapping[str, tuple[Port, ...]]
    functions: tuple[Function, ...]


def ports_of(module: Module) -> dict[str, Port]:
    """Arguments of all functions of a module, by name, in the order of the header."""
    return {port.name: port for ports in module.ports.values() for port in ports}


def ports_used(
    entries: Iterable[tuple[Function, Sequence[Port]]],
) -> dict[Function, list[Port]]:
    """Arguments of the entry that each function called by it reads or sets.

    Entries may have arguments of the same name and of different types.

    Args:
        entries: Function and arguments of each entry.
    """
    ports: dict[Function, list[Port]] = {}
    for entry, arguments in entries:
        for function in functions_called(entry):
            names, changed = arguments_used(function), arguments_set(function)
            read = [
                replace(port, set=port.name in changed) for port in arguments if port.name in names
            ]
            # entries share a function only if these arguments are of the same types
            assert {*ports.setdefault(function, read)} == {*read}
    return ports


def by_address(port: Port) -> bool:
    """Whether an argument is passed by address: a struct, or a number that C sets."""
    return isinstance(port.content, Struct) or (not port.content.shape and port.set)


def call(module: Module, entry: str, place: str = "") -> str:
    """C expression that calls an entry, with variables named after its arguments.

    Args:
        module: Module with the entry.
        entry: Name of the entry.
        place: Prefix of the variables, such as "values->" for members of a struct.
    """
    arguments = (f"{'&' if by_address(p) else ''}{place}{p.name}" for p in module.ports[entry])
    return f"{entry}({', '.join(arguments)})"
