"""Header of an emitted module: documented structs and prototypes."""

import inspect
import re
import textwrap
from collections.abc import Mapping, Sequence
from enum import IntEnum

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.identifiers import comment
from gyrostat.codegen.flight.module import Entry, Port, by_address
from gyrostat.codegen.flight.structs import Struct, documented
from gyrostat.codegen.flight.write import WIDTH


def prototype(entry: str, ports: Sequence[Port], dialect: Dialect) -> str:
    """How an entry is declared."""
    parameters = []
    for port in ports:
        content, constant = port.content, "" if port.set else "const "
        if isinstance(content, Struct):
            parameters.append(f"{constant}{content.name} *{port.name}")
        elif content.shape:
            size = "".join(f"[{count}]" for count in content.shape)
            parameters.append(f"{constant}{dialect.type_of(content.kind)} {port.name}{size}")
        else:
            address = "*" if by_address(port) else ""
            parameters.append(f"{dialect.type_of(content.kind)} {address}{port.name}")
    return wrapped(f"int {entry}({', '.join(parameters)})")


def wrapped(text: str) -> str:
    """Lines of C that are not too long."""
    return "\n".join(textwrap.wrap(text, WIDTH, subsequent_indent="    "))


def header(
    name: str,
    structs: Sequence[Struct],
    enums: Mapping[str, type[IntEnum]],
    entries: Sequence[tuple[Entry, Sequence[Port]]],
    dialect: Dialect,
) -> str:
    """Text of a header.

    Args:
        name: of the module.
        structs: all, each after those that it holds.
        enums: Name -> enumeration that members of structs take their values from.
        entries: with their arguments in C.
        dialect: type of real numbers.
    """
    guard = f"GYROSTAT_{name.upper()}_H"
    lines = [
        "/* Made by gyrostat from Python; structs and fields have Python's names. SI units. */",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        "#include <stdbool.h>",
        "#include <stdint.h>",
        "",
    ]
    for name, enum in enums.items():
        lines += [*_enum(name, enum), ""]
    for struct in structs:
        lines += _comment(struct.meaning, "")
        lines.append("typedef struct {")
        for member in struct.members:
            content = member.content
            kind = content.name if isinstance(content, Struct) else dialect.type_of(content.kind)
            shape = () if isinstance(content, Struct) else content.shape
            size = "".join(f"[{count}]" for count in shape)
            lines += _comment(member.meaning, "    ")
            lines.append(f"    {kind} {member.name}{size};")
        lines += [f"}} {struct.name};", ""]
    for entry, ports in entries:
        lines += _comment(
            (inspect.getdoc(entry.function) or "").partition("\n")[0]
            + " Returns 0, or 1 where a loop has reached its bound.",
            "",
        )
        lines += [prototype(entry.name, ports, dialect) + ";", ""]
    return "\n".join([*lines, "#endif", ""])


def _enum(name: str, enum: type[IntEnum]) -> list[str]:
    """An enumeration, its constants named NAME_MEMBER."""
    meanings = documented(enum)
    first = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).upper()
    meaning = (inspect.getdoc(enum) or "").partition("\n")[0]
    lines = [*_comment(f"{name}: {meaning}", ""), "enum {"]
    for number, member in enumerate(enum):
        lines += _comment(meanings.get(member.name, ""), "    ")
        comma = "," if number < len(enum) - 1 else ""
        lines.append(f"    {first}_{member.name} = {member.value}{comma}")
    return [*lines, "};"]


def _comment(text: str, indent: str) -> list[str]:
    if not text:
        return []
    return textwrap.wrap(
        f"/* {comment(text)} */", WIDTH, initial_indent=indent, subsequent_indent=indent + "   "
    )
