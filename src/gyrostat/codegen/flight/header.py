"""Header of an emitted module: documented structs and prototypes."""

import inspect
import re
import textwrap
from collections.abc import Mapping, Sequence
from enum import IntEnum

from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.identifiers import comment
from gyrostat.codegen.flight.module import Entry, Port, by_address
from gyrostat.codegen.flight.structs import Leaf, Struct, documented
from gyrostat.codegen.flight.write import WIDTH


def declaration(content: Leaf | Struct, name: str, dialect: Dialect) -> str:
    """C declaration of a variable, without a semicolon."""
    if isinstance(content, Struct):
        return f"{content.name} {name}"
    return dialect.type_of(content.kind) + f" {name}" + "".join(f"[{n}]" for n in content.shape)


def prototype(entry: str, ports: Sequence[Port], dialect: Dialect) -> str:
    """C prototype of an entry point."""
    parameters = []
    for port in ports:
        by_value = isinstance(port.content, Leaf) and not (port.content.shape or port.set)
        constant = "" if port.set or by_value else "const "
        address = "*" if by_address(port) else ""
        parameters.append(constant + declaration(port.content, address + port.name, dialect))
    return wrapped(f"int {entry}({', '.join(parameters)})")


def wrapped(text: str) -> str:
    """Wrap lines of C that are too long."""
    return "\n".join(textwrap.wrap(text, WIDTH, subsequent_indent="    "))


def header(
    name: str,
    structs: Sequence[Struct],
    enums: Mapping[str, type[IntEnum]],
    entries: Sequence[tuple[Entry, Sequence[Port]]],
    dialect: Dialect,
) -> str:
    """Text of the header file.

    Args:
        name: Name of the module.
        structs: Structs, each after those that it contains.
        enums: Name -> enumeration used for values of struct members.
        entries: Entry points with their arguments in C.
        dialect: Type of real numbers.
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
            lines += _comment(member.meaning, "    ")
            lines.append(f"    {declaration(member.content, member.name, dialect)};")
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
    """C text of an enumeration, with constants named NAME_MEMBER."""
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
