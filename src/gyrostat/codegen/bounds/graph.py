"""Control-flow graph of a function in a disassembled program for ARM (Thumb).

A function is what its first instruction reaches without calls. Jumps into other functions (tail
calls, common endings of a library) are followed, so that a function may contain code of another.
"""

import re
from dataclasses import dataclass, field

from .library import MEMORY
from .listing import Instruction, Listing, UnboundedError

CONDITION = "(eq|ne|cs|hs|cc|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)"
_JUMP = re.compile(f"b{CONDITION}?")
_CALL = re.compile(f"blx?{CONDITION}?")
_RETURN = re.compile(f"(?:bx|pop|ldmia|ldmfd|ldm|ldr|mov){CONDITION}?")


@dataclass
class Block:
    """Instructions that are executed one after another.

    Attributes:
        instructions: The instructions, with those that a condition may skip.
        successors: Addresses of the blocks that can follow.
        calls: Address of an instruction -> address of the function that it calls.
        returns: Whether the function can end here.
    """

    instructions: list[Instruction] = field(default_factory=list)
    successors: list[int] = field(default_factory=list)
    calls: dict[int, int] = field(default_factory=dict)
    returns: bool = False


@dataclass(frozen=True)
class _Flow:
    """What can follow an instruction: addresses, a function that it calls, the function's end."""

    successors: tuple[int, ...]
    call: int | None = None
    returns: bool = False


def function_graph(listing: Listing, entry: int) -> dict[int, Block]:
    """Blocks of a function: address of the first instruction -> block.

    Args:
        listing: Program.
        entry: Address of the function.

    Raises:
        UnboundedError: A jump or call goes to an address that is computed.
    """
    flows: dict[int, _Flow] = {}
    leaders, ahead = {entry}, [entry]
    while ahead:
        address = ahead.pop()
        while address not in flows:
            flow = flows[address] = _flow(listing, address)
            following = listing.instructions[address].following
            if flow.successors != (following,) or flow.returns:
                leaders |= set(flow.successors)
                ahead += flow.successors
                break
            address = following
    return {leader: _block(listing, flows, leaders, leader) for leader in leaders}


def _block(listing: Listing, flows: dict[int, _Flow], leaders: set[int], address: int) -> Block:
    block = Block()
    while True:
        instruction, flow = listing.instructions[address], flows[address]
        if flow.call is not None:
            block.calls[address] = flow.call
        block.instructions.append(instruction)
        address = instruction.following
        if flow.successors != (address,) or flow.returns or address in leaders:
            block.successors = list(dict.fromkeys(flow.successors))
            block.returns = flow.returns
            return block


def _flow(listing: Listing, address: int) -> _Flow:
    if address not in listing.instructions:
        raise UnboundedError(f"{listing.where(address)}: no instruction")
    instruction = listing.instructions[address]
    name, operands, after = instruction.name, instruction.operands, instruction.following
    if name in ("cbz", "cbnz"):
        return _Flow((_target(listing, instruction), after))
    if name in ("tbb", "tbh"):
        return _Flow(_table(listing, instruction))
    if name in ("udf", "bkpt"):
        return _Flow(())
    if match := _JUMP.fullmatch(name):
        target = _target(listing, instruction)
        name = listing.symbols.get(target)
        if name in MEMORY and name != listing.symbol(address):
            # a call whose return is that of the caller
            return _Flow((after,) if match[1] else (), target, returns=True)
        return _Flow((target, after) if match[1] else (target,))
    if _CALL.fullmatch(name):
        return _Flow((after,), _target(listing, instruction))
    sets_counter = name.startswith("bx") or re.match(r"pc\b|.*\{.*\bpc\b.*\}", operands)
    if not sets_counter:
        return _Flow((after,))
    match = _RETURN.fullmatch(name)
    saved = name.startswith("pop") or operands.startswith("sp!, {") or "[sp]" in operands
    if match and (saved or operands in ("lr", "pc, lr")):
        return _Flow((after,) if match[1] else (), returns=True)
    by_table = name == "ldr" and re.fullmatch(r"pc, \[\w+, \w+, lsl #2\]", operands)
    if by_table and (targets := _addresses(listing, (after + 3) & ~3)):
        return _Flow(targets)
    raise UnboundedError(f"{listing.where(address)}: jump to a computed address")


def _target(listing: Listing, instruction: Instruction) -> int:
    match = re.search(r"\b([0-9a-f]+) <", instruction.operands)
    if match is None:
        raise UnboundedError(f"{listing.where(instruction.address)}: call of a computed address")
    return int(match[1], 16)


def _table(listing: Listing, instruction: Instruction) -> tuple[int, ...]:
    """Targets of a jump by a table of half distances, which follows the instruction."""
    width, base = (1 if instruction.name == "tbb" else 2), instruction.following
    table = listing.bytes_at(base)
    entries = (int.from_bytes(table[k : k + width], "little") for k in range(0, len(table), width))
    targets = sorted({base + 2 * entry for entry in entries})
    # a byte that fills the table up names its own beginning
    return tuple(target for target in targets if target in listing.instructions)


def _addresses(listing: Listing, place: int) -> tuple[int, ...]:
    """Targets of a jump by a table of addresses, whose last bit says that they are of Thumb."""
    table = listing.bytes_at(place)
    targets = []
    for k in range(0, len(table), 4):
        word = int.from_bytes(table[k : k + 4], "little")
        if not word & 1 or word - 1 not in listing.instructions:
            break
        targets.append(word - 1)
    return tuple(sorted(set(targets)))
