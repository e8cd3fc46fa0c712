"""Fields of messages, from the structs of a flight module."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np

from gyrostat.codegen.flight.identifiers import free_name
from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.exports.unit_text import unit_of

_KINDS = {
    "integer": "int64",
    "logical": "uint8",
    "count": "uint32",
    "time": "CFE_TIME_SysTime_t",
}
_SIZES = {"double": 8, "int64": 8, "CFE_TIME_SysTime_t": 8, "float": 4, "uint32": 4, "uint8": 1}


@dataclass(frozen=True)
class Field:
    """Field of a payload.

    Attributes:
        name: Name in the payload.
        path: Member of the struct of the flight module, such as "rate" or "turn.rate"; "" if the
            struct is a number or an array.
        kind: Kind of number: "real", "integer", "logical", "count" or "time".
        shape: Shape of an array; () for one number.
        meaning: Description.
        offset: Offset in the payload, bytes.
    """

    name: str
    path: str
    kind: str
    shape: tuple[int, ...]
    meaning: str
    offset: int = 0

    def kind_in_c(self, real: str) -> str:
        """Type of an element in the message; a logical value is a byte."""
        return {"real": real, **_KINDS}[self.kind]

    def size(self, real: str) -> int:
        """Size of an element, bytes."""
        return _SIZES[self.kind_in_c(real)]

    @property
    def count(self) -> int:
        """Number of elements."""
        return prod(self.shape)

    @property
    def brackets(self) -> str:
        """Shape as C text, such as [3]."""
        return "".join(f"[{n}]" for n in self.shape)

    @property
    def unit(self) -> str:
        """SI unit, or ""."""
        return unit_of(self.meaning)

    def elements(self) -> list[str]:
        """C text of the index of each element, [""] for one number."""
        indices = np.ndindex(self.shape)
        return ["".join(f"[{k}]" for k in index) for index in indices]

    def member(self, struct: str) -> str:
        """C expression for the member of a struct of the flight module."""
        return f"{struct}.{self.path}" if self.path else struct


def fields_of(content: Leaf | Struct, name: str, taken: set[str]) -> Iterator[Field]:
    """Fields with the numbers of a type, in JAX's order.

    Args:
        content: Type.
        name: Name of the field if the type is a number or an array.
        taken: Names that the fields must not have; theirs are added.
    """
    for path, leaf, meaning in leaves(content):
        label = free_name(path.replace(".", "_") or name, taken)
        taken.add(label)
        yield Field(label, path, leaf.kind, leaf.shape, meaning)


def leaves(
    content: Leaf | Struct, path: str = "", meaning: str = ""
) -> Iterator[tuple[str, Leaf, str]]:
    """Path, type and description of each number or array of a type, in JAX's order."""
    if isinstance(content, Leaf):
        yield path, content, meaning
        return
    for member in content.members:
        below = f"{path}.{member.name}" if path else member.name
        yield from leaves(member.content, below, member.meaning)


def missing_lines(fields: Sequence[Field], struct: str) -> list[str]:
    """C that makes a measurement one that the guard rejects: NaN, with every flag set.

    Args:
        fields: Fields of the measurement.
        struct: C expression for the struct.
    """
    lines = []
    for field in fields:
        member = field.member(struct)
        if field.kind == "logical":
            lines += [f"{member}{k} = true;" for k in field.elements()]
        elif field.kind == "real" and field.shape:
            first = "".join("[0]" for _ in field.shape)
            lines.append(f"SetNotANumber(&{member}{first}, {field.count}U);")
        elif field.kind == "real":
            lines.append(f"{member} = NAN;")
    return lines
