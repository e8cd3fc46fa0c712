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
    """Whether a single number is passed by its address, as C sets it."""
    return isinstance(port.content, Leaf) and not port.content.shape and port.set
