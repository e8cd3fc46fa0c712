"""Bound of the stack that a function needs, with the functions that it calls."""

import re
from collections import Counter
from collections.abc import Mapping

from .graph import Block, function_graph
from .listing import Instruction, Listing, UnboundedError


def frames(text: str) -> dict[str, int]:
    """Function -> bytes of its own frame, from a file of the compiler's `-fstack-usage`.

    Raises:
        UnboundedError: A frame has no fixed size.
    """
    frames: dict[str, int] = {}
    for row in text.splitlines():
        place, size, kind = row.split("\t")
        name = place.rpartition(":")[2]
        if kind not in ("static", "dynamic,bounded"):
            raise UnboundedError(f"{name}: its frame has no fixed size")
        frames[name] = int(size)
    return frames


class Stack:
    """Bounds of the functions of a program."""

    def __init__(self, listing: Listing, frames: Mapping[str, int]) -> None:
        """Bounds for a program.

        Args:
            listing: Program.
            frames: Function -> bytes of its own frame, as the compiler says. The frames of other
                functions are read from their instructions.
        """
        self._listing, self._frames = listing, frames
        self._known: dict[int, int] = {}
        self._open: set[int] = set()

    def bound(self, function: str) -> int:
        """Bytes of stack of a function with the functions that it calls.

        Raises:
            UnboundedError: There is no bound, and why.
        """
        return self._deepest(self._listing.address(function))

    def _deepest(self, entry: int) -> int:
        if entry not in self._known:
            if entry in self._open:
                raise UnboundedError(f"{self._listing.symbol(entry)}: recursion")
            self._open.add(entry)
            graph = function_graph(self._listing, entry)
            depths = _depths(self._listing, graph, entry)
            own = self._frames.get(self._listing.symbol(entry), 0)
            at_calls = [
                max(depth, own) + self._deepest(callee)
                for block, depth in depths.items()
                for callee in graph[block].calls.values()
            ]
            self._known[entry] = max([own, *depths.values(), *at_calls])
            self._open.remove(entry)
        return self._known[entry]


def _depths(listing: Listing, graph: Mapping[int, Block], entry: int) -> dict[int, int]:
    """Block -> largest depth of the stack in it, bytes."""
    arrival, deepest, ahead = {entry: 0}, dict[int, int](), [entry]
    visits: Counter[int] = Counter()
    while ahead:
        address = ahead.pop(0)
        visits[address] += 1
        if visits[address] > len(graph):  # as in the test of Bellman and Ford for such cycles
            raise UnboundedError(f"{listing.where(address)}: a loop pushes")
        depth = largest = arrival[address]
        block = graph[address]
        for instruction in block.instructions:
            at_end = block.returns and instruction is block.instructions[-1]
            depth += 0 if at_end else _pushed(listing, instruction)
            largest = max(largest, depth)
        deepest[address] = largest
        for successor in block.successors:
            if depth > arrival.get(successor, -1):
                arrival[successor] = depth
                ahead.append(successor)
    return deepest


def _pushed(listing: Listing, instruction: Instruction) -> int:
    """Bytes by which an instruction makes the stack deeper."""
    name, operands = instruction.name, instruction.operands
    if name.startswith(("push", "vpush")):
        return _registers(operands)
    if name.startswith(("pop", "vpop")):
        return -_registers(operands)
    if operands.startswith("sp!, "):
        down = name.startswith(("stmdb", "stmfd", "vstmdb"))
        return _registers(operands) * (1 if down else -1)
    if match := re.search(r"\[sp, #(-?\d+)\]!|\[sp\], #(-?\d+)", operands):
        return -int(match[1] or match[2])
    if re.match(r"(add|sub)s?w?$", name) and operands.startswith("sp, "):
        if match := re.fullmatch(r"sp, (?:sp, )?#(\d+)", operands):
            return int(match[1]) * (-1 if name.startswith("add") else 1)
    elif not (operands.startswith("sp, ") and name.startswith(("mov", "ldr", "and", "bic"))):
        return 0
    raise UnboundedError(f"{listing.where(instruction.address)}: a frame of computed size")


def _registers(operands: str) -> int:
    """Bytes of a list of registers."""
    total = 0
    for item in operands[operands.index("{") + 1 : operands.index("}")].split(","):
        first, _, last = item.strip().partition("-")
        width = 8 if first.startswith("d") else 4
        total += width * (int(last[1:]) - int(first[1:]) + 1 if last else 1)
    return total
