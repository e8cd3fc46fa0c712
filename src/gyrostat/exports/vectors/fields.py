"""Numbers that a flight module reads and writes, by their names in C."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from gyrostat.codegen.flight.module import Module, Port, ports_of
from gyrostat.codegen.flight.structs import scalars
from gyrostat.codegen.program import Kind
from gyrostat.core.jax64 import jax
from gyrostat.exports.target import Target

Role = Literal["parameter", "constant", "state", "input", "output"]


@dataclass(frozen=True)
class Field:
    """Number that a test vector may set, or that the functions compute.

    Attributes:
        name: C expression of it in a test program, such as memory.guard.last.rate[0].
        port: Argument that contains it.
        path: Members below the argument, with dots between them.
        indices: Indices behind them.
        kind: Kind of number.
        role: "parameter" if the first function sets it, "constant" if no function sets it and it is
            the same in every step, "state" if a function replaces it, "input" if it is new in every
            step, "output" if no function reads it.
    """

    name: str
    port: str
    path: str
    indices: tuple[int, ...]
    kind: Kind
    role: Role


def fields_of(target: Target, module: Module) -> tuple[Field, ...]:
    """All numbers of a module, argument by argument in the order of the header."""
    return tuple(
        field
        for name, port in ports_of(module).items()
        for field in _fields(port, _role(target, module, name))
    )


def arrays_of(fields: Sequence[Field]) -> list[list[int]]:
    """Indices of the fields of each array or number."""
    arrays: dict[tuple[str, str], list[int]] = {}
    for k, field in enumerate(fields):
        arrays.setdefault((field.port, field.path), []).append(k)
    return list(arrays.values())


def _role(target: Target, module: Module, name: str) -> Role:
    if name in target.inputs:
        return "input"
    if name in target.begin[0].results:
        return "parameter"
    every = [port for ports in module.ports.values() for port in ports if port.name == name]
    if not any(port.set for port in every):
        return "constant"
    return "state" if any(port.given for port in every) else "output"


def _fields(port: Port, role: Role) -> Iterator[Field]:
    for array in scalars(port.content, port.name, pointer=False):
        for scalar in array.flat:
            name = scalar.hint
            path = re.sub(r"\[.*", "", name.partition(".")[2])
            indices = tuple(map(int, re.findall(r"\[(\d+)\]", name)))
            yield Field(name, port.name, path, indices, scalar.kind, role)


def whole(values: np.ndarray) -> np.ndarray:
    """Integers of 64 bits. As a real number, the largest one is rounded up: it is limited again."""
    is_large = values >= 2.0**63
    small = np.nan_to_num(np.where(is_large, 0.0, values)).astype(np.int64)
    return np.where(is_large, np.iinfo(np.int64).max, small)


def values_of(fields: tuple[Field, ...], trees: Mapping[str, Any]) -> np.ndarray:
    """Values of fields in trees of Python, one for each argument; NaN for other arguments."""
    numbers = {
        name: iter([x for leaf in jax.tree.leaves(tree) for x in np.ravel(leaf).tolist()])
        for name, tree in trees.items()
    }
    return np.array([float(next(numbers[f.port])) if f.port in numbers else np.nan for f in fields])
