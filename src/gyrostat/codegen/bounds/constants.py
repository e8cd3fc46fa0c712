"""Constants in registers, by their propagation through the control-flow graph of a function."""

import re
from collections.abc import Mapping

from .graph import CONDITION, Block
from .listing import Instruction

_ARITHMETIC = re.compile(
    r"(?:add|adc|sub|sbc|rsb|mov|mvn|and|orr|orn|eor|bic|lsl|lsr|asr|ror|mul|mla|mls|clz|ldr"
    r"|[us]bfx|[us]div|[us]xt[bh])[swbh]?"
)
"""Instructions that write their first operand, and an address that they move on."""
_READING = re.compile(
    rf"cmp|cmn|tst|teq|str[bhd]?|push|cbn?z|it[te]*|nop|bx?{CONDITION}?|tb[bh]|(?:vstr|vldr|vcmp).*"
)
"""Instructions that write nothing else than an address that they move on."""
_CLOBBERED = ("r0", "r1", "r2", "r3", "ip", "lr")
"""Registers that a call may change (procedure call standard for the Arm architecture)."""


def third_arguments(graph: Mapping[int, Block], entry: int) -> dict[int, int]:
    """Address of a call -> its third argument, which is in r2, where it is a constant.

    Args:
        graph: Blocks of a function.
        entry: Its first block.
    """
    known: dict[int, dict[str, int]] = {entry: {}}
    arguments: dict[int, int] = {}
    ahead = [entry]
    while ahead:
        address = ahead.pop()
        block, registers = graph[address], dict(known[address])
        for instruction in block.instructions:
            if instruction.address in block.calls:
                arguments.pop(instruction.address, None)  # it may be known of one path alone
                if "r2" in registers:
                    arguments[instruction.address] = registers["r2"]
            _execute(instruction, registers, is_call=instruction.address in block.calls)
        for successor in block.successors:
            before = known.get(successor)
            common = registers
            if before is not None:
                common = {r: v for r, v in before.items() if registers.get(r) == v}
            if common != before:
                known[successor] = dict(common)
                ahead.append(successor)
    return arguments


def _execute(instruction: Instruction, registers: dict[str, int], *, is_call: bool) -> None:
    """Update the known registers."""
    operands = re.findall(r"#?-?\w+", instruction.operands)
    written: list[str] | tuple[str, ...] = operands
    if is_call:
        written = _CLOBBERED
    elif _ARITHMETIC.fullmatch(instruction.name):
        written = operands[:1]
    elif _READING.fullmatch(instruction.name):
        written = ()
    if moved := re.search(r"\[(\w+)\], #|\[(\w+).*\]!|^(\w+)!", instruction.operands):
        written = [*written, *filter(None, moved.groups())]
    value = None
    if re.fullmatch("mov[sw]?", instruction.name) and len(operands) == 2:
        source = operands[1]
        value = int(source[1:]) if source.startswith("#") else registers.get(source)
    for register in written:
        registers.pop(register, None)
    if value is not None:
        registers[operands[0]] = value
