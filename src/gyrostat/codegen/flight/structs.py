"""C structs for trees of Python objects, with the same names."""

import dataclasses
import inspect
import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Data
from gyrostat.codegen.flight.identifiers import comment, free_name, member_names, public_identifier
from gyrostat.codegen.flight.reserved import LIBRARY
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Kind, Name, Table
from gyrostat.codegen.scope import LARGEST, TYPES, kind_of
from gyrostat.core.checked import declared_units
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.units import SI_UNIT


@dataclass(frozen=True)
class Leaf:
    """Number or array of numbers."""

    kind: Kind
    shape: tuple[int, ...]


@dataclass(frozen=True)
class Member:
    """Field of a struct.

    Attributes:
        name: Name in C.
        content: Type of the field.
        meaning: Description from the Python docstring, with the unit; "" if there is none.
    """

    name: str
    content: "Leaf | Struct"
    meaning: str


@dataclass(frozen=True)
class Struct:
    """Struct named after the Python class."""

    name: str
    members: tuple[Member, ...]
    meaning: str


class Structs:
    """Structs of a set of functions, each defined after those that it contains.

    Args:
        taken: Names of entries and arguments, which no struct has.

    Attributes:
        every: Structs.
        enums: Name -> enumeration used for values of struct members.
    """

    def __init__(self, taken: Iterable[str]) -> None:
        self._taken = frozenset(taken)
        self.every: list[Struct] = []
        self.enums: dict[str, type[IntEnum]] = {}

    def of(self, tree: Any, name: str) -> Leaf | Struct | None:
        """C type of a tree; None if it contains no numbers.

        Args:
            tree: Tree of equinox modules, named tuples, tuples, lists, dicts and numbers.
            name: Name of the struct if its class has none, as for a tuple.

        Raises:
            InputError: The tree contains anything else.
        """
        if not any(np.size(leaf) for leaf in jax.tree.leaves(tree)):
            return None
        if not _is_node(tree):
            return _leaf(tree, name)
        title = type(tree).__name__
        label = title if title not in ("tuple", "list", "dict") else name
        self.enums |= {e.__name__: e for e in getattr(tree, "ENUMS", {}).values()}
        units, meanings = declared_units(type(tree)), documented(type(tree))
        members: list[Member] = []
        for field, value, metadata in _fields(tree):
            content = self.of(value, f"{label}_{field}")
            if content is None:
                continue
            unit = units.get(field) or SI_UNIT.get(metadata.get("dimension", ""), "")
            members.append(Member(field, content, meanings.get(field) or unit))
        types = [m.content.name for m in members if isinstance(m.content, Struct)]
        names = member_names([member.name for member in members], types)
        members = [dataclasses.replace(m, name=n) for m, n in zip(members, names, strict=True)]
        meaning = (inspect.getdoc(type(tree)) or "").partition("\n")[0] if label == title else ""
        kind = public_identifier(label)
        kind = f"{kind}_" if kind in LIBRARY else kind
        struct = Struct(kind, tuple(members), comment(meaning + _static_fields(tree)))
        return self._register(struct)

    def _register(self, struct: Struct) -> Struct:
        for entry in self.every:
            names = (entry.name, re.sub(r"_\d+$", "", entry.name))
            if entry.members == struct.members and struct.name in names:
                return entry
        name = free_name(struct.name, {*self._taken, *(entry.name for entry in self.every)})
        struct = dataclasses.replace(struct, name=name)
        self.every.append(struct)
        return struct


def scalars(content: Leaf | Struct, path: str, pointer: bool = True) -> list[Scalars]:
    """C expressions for the numbers of a type; see `arrays_of`."""
    arrays = arrays_of(content, path, pointer)
    return [array.scalars() if isinstance(array, Data) else array for array in arrays]


def arrays_of(content: Leaf | Struct, path: str, pointer: bool = True) -> list[Scalars | Data]:
    """Leaves of a type in JAX's order: names of single numbers, and tables.

    Args:
        content: Type, as returned by `Structs.of`.
        path: C expression for the variable.
        pointer: Whether `path` is a pointer to a struct.
    """
    if isinstance(content, Leaf):
        if not content.shape:
            return [np.array(Name(content.kind, path, fixed=True), dtype=object)]
        size = int(np.prod(content.shape))
        table = Table(content.kind, size, path, shape=content.shape)
        return [Data(table, np.arange(size).reshape(content.shape))]
    step = "->" if pointer else "."
    return [
        array
        for member in content.members
        for array in arrays_of(member.content, f"{path}{step}{member.name}", False)
    ]


def _is_node(tree: Any) -> bool:
    return isinstance(tree, tuple | list | dict) or dataclasses.is_dataclass(tree)


def _fields(tree: Any) -> list[tuple[str, Any, Any]]:
    """Name, value and metadata of each field that JAX flattens, in its order."""
    if isinstance(tree, dict):
        return [(str(key), tree[key], {}) for key in sorted(tree)]
    if hasattr(tree, "_fields"):
        return [(name, getattr(tree, name), {}) for name in tree._fields]
    if dataclasses.is_dataclass(tree):
        return [
            (f.name, getattr(tree, f.name), f.metadata)
            for f in dataclasses.fields(tree)
            if not f.metadata.get("static", False)
        ]
    return [(f"item_{k}", value, {}) for k, value in enumerate(tree)]


def _leaf(tree: Any, name: str) -> Leaf:
    shape, dtype = getattr(tree, "shape", None), getattr(tree, "dtype", None)
    kind = None if dtype is None else kind_of(dtype)
    if shape is None or kind is None or np.prod(shape) > LARGEST:
        if shape is None:
            raise InputError(
                f"{name}: found {type(tree).__name__}, expected numbers and arrays in dataclasses, "
                "equinox modules, named tuples, tuples, lists and dicts"
            )
        raise InputError(
            f"{name}: found {dtype}{list(shape)}, expected {TYPES} arrays of at most {LARGEST} "
            "elements"
        )
    return Leaf(kind, tuple(shape))


def _static_fields(tree: Any) -> str:
    """Sentence that lists the static fields, which are compiled in and not struct members."""
    fixed = [
        f"{f.name} = {getattr(tree, f.name)!r}"
        for f in (dataclasses.fields(tree) if dataclasses.is_dataclass(tree) else ())
        if f.metadata.get("static", False)
        and isinstance(getattr(tree, f.name), bool | int | float | str)
    ]
    return f" Compiled in: {', '.join(fixed)}." if fixed else ""


def documented(kind: type) -> dict[str, str]:
    """Field -> its description in the Attributes section of a class's docstring."""
    descriptions: dict[str, str] = {}
    _, _, text = (inspect.getdoc(kind) or "").partition("Attributes:\n")
    name = ""
    for line in text.splitlines():
        start = re.fullmatch(r"    (\w+): (.*)", line)
        if start:
            name = start[1]
            descriptions[name] = start[2]
        elif line.startswith("        ") and name:
            descriptions[name] += " " + line.strip()
        else:
            break
    return {name: comment(text) for name, text in descriptions.items()}
