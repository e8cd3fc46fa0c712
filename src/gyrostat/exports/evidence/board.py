"""Program for a board with a Cortex-M that counts the instructions and the stack of functions."""

import re
from collections.abc import Sequence

from gyrostat.exports.template import filled


def board_files() -> dict[str, str]:
    """Start of a program and its memory: file name -> text."""
    return {name: board_file(name) for name in ("board.c", "board.ld")}


def board_file(file: str, **values: str) -> str:
    """Text of a file of the program with its placeholders replaced; see `filled`."""
    return filled(f"evidence/resources/{file}", **values)


def counting_code(include: str, prototypes: Sequence[str]) -> str:
    """C that counts the calls of functions, whose names the linker wraps (ld --wrap=NAME).

    Args:
        include: Lines of C before it, which declare the types.
        prototypes: Prototypes of the functions, which return int.
    """
    names = [head[4 : head.index("(")] for head in prototypes]
    return board_file(
        "count.c",
        include=include,
        calls="\n".join(map(_counted, prototypes)),
        every=", ".join(f"&count_{name}" for name in names),
    )


def _counted(prototype: str) -> str:
    """C that counts the calls of one function, with copies of its arguments in static variables."""
    words = re.fullmatch(r"int (\w+)\((.*)\)", " ".join(prototype.split()))
    assert words is not None
    name, arguments, copies = words[1], list[str](), list[str]()
    for argument in words[2].split(", "):
        parts = re.fullmatch(r"(.*?)(\w+)((?:\[\d+\])*)", argument)
        assert parts is not None
        # an argument that is an array is the address of its first row
        rows = re.sub(r"^\[\d+\]", "", parts[3])
        copy = f"{name}_{parts[2]}"
        copies.append(f"static {parts[1]}{f'(*{copy})' if parts[3] else copy}{rows};")
        arguments.append(parts[2])
    return board_file(
        "count_call.c",
        name=name,
        copies="\n".join(copies),
        parameters=words[2],
        values=", ".join(f"{name}_{argument}" for argument in arguments),
        stores="\n".join(f"    {name}_{argument} = {argument};" for argument in arguments),
    )
