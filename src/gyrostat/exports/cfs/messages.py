"""Payloads of messages, generated from the structs of a flight module."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.exports.message_fields import Field, fields_of


@dataclass(frozen=True)
class Payload:
    """Payload of a message: fields without gaps, the largest elements first.

    Attributes:
        head: Fields before those of the flight module.
        fields: Fields of the flight module, with their offsets.
        spare: Bytes between the fields and the checksum, which is at a multiple of 8.
        crc: Offset of the checksum, bytes.
        size: Size, bytes.
        real: Type of real numbers.
    """

    head: tuple[Field, ...]
    fields: tuple[Field, ...]
    spare: int
    crc: int
    size: int
    real: str

    @classmethod
    def of(cls, content: Leaf | Struct, name: str, head: Sequence[Field], real: str) -> "Payload":
        """Payload with the content of a struct.

        Args:
            content: Type in the flight module.
            name: Name of the field if the content is a number or an array.
            head: Fields before those of the struct; their size is a multiple of 8 bytes.
            real: Type of real numbers.
        """
        taken = {field.name for field in head} | {"Spare", "Crc", "Reserved"}
        fields = sorted(fields_of(content, name, taken), key=lambda each: -each.size(real))
        placed, offset = [], sum(field.size(real) for field in head)
        for field in fields:
            placed.append(replace(field, offset=offset))
            offset += field.count * field.size(real)
        spare = -offset % 8
        return cls(tuple(head), tuple(placed), spare, offset + spare, offset + spare + 8, real)

    def declarations(self) -> str:
        """Members of the payload in C."""
        lines = [
            f"    {field.kind_in_c(self.real)} {field.name}{field.brackets};"
            for field in (*self.head, *self.fields)
        ]
        lines += [f"    uint8 Spare[{self.spare}];"] if self.spare else []
        return "\n".join([*lines, "    uint32 Crc;", "    uint32 Reserved;"])


def read_lines(fields: Sequence[Field], source: str, struct: str) -> list[str]:
    """C that copies a payload to a struct of the flight module.

    Args:
        fields: Fields of the payload.
        source: Pointer to the payload.
        struct: C expression for the struct.
    """
    lines = []
    for field in fields:
        member = field.member(struct)
        if field.kind == "logical":
            lines += [f"{member}{k} = ({source}->{field.name}{k} != 0U);" for k in field.elements()]
        elif field.shape:
            lines.append(f"(void)memcpy(&{member}, &{source}->{field.name}, sizeof({member}));")
        else:
            lines.append(f"{member} = {source}->{field.name};")
    return lines


def written_lines(fields: Sequence[Field], target: str, struct: str) -> list[str]:
    """C that copies a struct of the flight module to a payload.

    Args:
        fields: Fields of the payload.
        target: Pointer to the payload.
        struct: C expression for the struct.
    """
    lines = []
    for field in fields:
        member = field.member(struct)
        if field.kind == "logical":
            lines += [
                f"{target}->{field.name}{k} = (uint8)({member}{k} ? 1U : 0U);"
                for k in field.elements()
            ]
        elif field.shape:
            lines.append(f"(void)memcpy(&{target}->{field.name}, &{member}, sizeof({member}));")
        else:
            lines.append(f"{target}->{field.name} = {member};")
    return lines
