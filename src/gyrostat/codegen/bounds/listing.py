"""Disassembly of a linked program for ARM (Thumb), as `objdump -d -l` prints it."""

import re
from bisect import bisect_right
from dataclasses import dataclass, field

_SYMBOL = re.compile(r"([0-9a-f]+) <(.+)>:")
_CODE = re.compile(r" *([0-9a-f]+):\t([0-9a-f ]+)\t(\S+)\t?(.*)")
_LINE = re.compile(r"(?:.*/)?([^/:]+\.[chS]):(\d+)")


class UnboundedError(Exception):
    """Code that has no bound; the text says where and why."""


@dataclass(frozen=True)
class Instruction:
    """Instruction of a program.

    Attributes:
        address: Its address.
        following: Address after it.
        name: Mnemonic without the suffix of its width.
        operands: Operands, without comments.
        file: File of C that it comes from; "" if that is not known.
        line: Line of that file.
    """

    address: int
    following: int
    name: str
    operands: str
    file: str
    line: int


@dataclass
class Listing:
    """Disassembled program.

    Attributes:
        instructions: Address -> instruction.
        symbols: Address -> name.
        data: Address -> bytes between instructions.
    """

    instructions: dict[int, Instruction] = field(default_factory=dict)
    symbols: dict[int, str] = field(default_factory=dict)
    data: dict[int, bytes] = field(default_factory=dict)

    def address(self, name: str) -> int:
        """Address of a symbol.

        Raises:
            UnboundedError: The program has no such symbol.
        """
        for address, symbol in self.symbols.items():
            if symbol == name:
                return address
        raise UnboundedError(f"{name}: not found in the program")

    def symbol(self, address: int) -> str:
        """Name of the last symbol up to an address."""
        starts = sorted(self.symbols)
        return self.symbols[starts[bisect_right(starts, address) - 1]]

    def where(self, address: int) -> str:
        """Text that names a place for a message."""
        instruction = self.instructions.get(address)
        line = f", line {instruction.line}" if instruction and instruction.file else ""
        return f"{self.symbol(address)} at {address:#x}{line}"

    def bytes_at(self, address: int) -> bytes:
        """Data from an address to the next instruction."""
        words = b""
        while address in self.data:
            words += self.data[address]
            address += len(self.data[address])
        return words


def read_listing(text: str) -> Listing:
    """Read the output of `objdump -d -l`."""
    listing, file, line = Listing(), "", 0
    for row in text.splitlines():
        if match := _CODE.match(row):
            address, digits, name = int(match[1], 16), match[2].replace(" ", ""), match[3]
            following = address + len(digits) // 2
            if name.startswith("."):
                # objdump prints a datum as a number, of which the last byte comes first in memory
                listing.data[address] = bytes.fromhex(digits)[::-1]
                continue
            operands = re.split("[@;]", match[4])[0].strip()
            name = re.sub(r"\.[nw]$", "", name)
            listing.instructions[address] = Instruction(
                address, following, name, operands, file, line
            )
        elif match := _SYMBOL.match(row):
            listing.symbols[int(match[1], 16)] = match[2]
            file, line = "", 0
        elif match := _LINE.match(row):
            file, line = match[1], int(match[2])
    return listing
