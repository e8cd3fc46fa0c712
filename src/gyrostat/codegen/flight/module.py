"""Inputs and output of the C emitter: entry points, ports and the module."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.codegen.program import Function

Precision = Literal["double", "float"]


@dataclass(frozen=True)
class Entry:
    """A function that other C code calls.

    Attributes:
        name: in C.
        function: of trees of numbers, without side effects.
        arguments: name in C -> an example; the first ones in order are those of `function`.
        results: names of what it returns. A result with the name of an argument takes its place.
    """

    name: str
    function: Callable[..., Any]
    arguments: Mapping[str, Any]
    results: tuple[str, ...]


@dataclass(frozen=True)
class Port:
    """An argument of an entry in C.

    Attributes:
        name: in C.
        content: a struct is passed by its address, a number by value, or by address to be set.
        given: whether C reads it.
        set: whether C writes it.
    """

    name: str
    content: Leaf | Struct
    given: bool
    set: bool


@dataclass(frozen=True)
class Module:
    """Emitted C.

    Attributes:
        name: of the files.
        header: text of NAME.h.
        source: text of NAME.c.
        structs: all, each after those that it holds.
        ports: entry -> its arguments in C.
        functions: the program, for `effort`; the entries come last.
    """

    name: str
    header: str
    source: str
    structs: tuple[Struct, ...]
    ports: Mapping[str, tuple[Port, ...]]
    functions: tuple[Function, ...]


def by_address(port: Port) -> bool:
    """Whether an argument is passed by its address: a struct, and a number that C sets."""
    return isinstance(port.content, Struct) or (not port.content.shape and port.set)


def call(module: Module, entry: str, place: str = "") -> str:
    """A call of an entry, each argument of a variable of its name, as an expression.

    Args:
        module: Of the entry.
        entry: Its name.
        place: How C gets to the variables, "values->" for members of a struct.
    """
    given = (f"{'&' if by_address(p) else ''}{place}{p.name}" for p in module.ports[entry])
    return f"{entry}({', '.join(given)})"
