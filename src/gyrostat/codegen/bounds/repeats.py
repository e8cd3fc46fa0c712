"""How often the loops of a function return to their headers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .graph import Block
from .library import MEMORY, NORMALISING, REPEATS
from .listing import Listing, UnboundedError
from .loops import NaturalLoop
from .passes import CLoop

_STORED = {"strb": 1, "strh": 2, "str": 4, "strd": 8, "vstr": 8}
"""Instruction -> bytes that it writes at most."""


@dataclass(frozen=True)
class Repeats:
    """Bounds for the loops of a program.

    Attributes:
        listing: Program, with the lines of C.
        file: Name of the C file with loops.
        loops: Loops of that file.
    """

    listing: Listing
    file: str
    loops: Sequence[CLoop]

    def of_function(
        self,
        graph: Mapping[int, Block],
        loops: Sequence[NaturalLoop],
        size: int | None,
        normal: bool,
    ) -> dict[int, int]:
        """Header -> how often its loop returns to it at most, each time it is entered.

        Args:
            graph: Blocks of the function.
            loops: Its loops, each after those that contain it.
            size: Third argument of the function; None if it is not known.
            normal: Whether no operand is subnormal.

        Raises:
            UnboundedError: There is no bound for a loop.
        """
        repeats, known = dict[int, int](), dict[int, set[CLoop]]()
        for loop in reversed(loops):
            inner = [each for each in loops if each.blocks < loop.blocks]
            own = loop.blocks.difference(*(each.blocks for each in inner))
            lines = {i.line for b in own for i in graph[b].instructions if i.file == self.file}
            if not lines:
                repeats[loop.header] = self._in_library(graph, loop, loops, size, normal)
                continue
            others = set[CLoop]().union(*(known.get(each.header, ()) for each in inner))
            known[loop.header] = self._in_c(lines, others)
            if not known[loop.header]:
                where = self.listing.where(loop.header)
                raise UnboundedError(f"{where}: a loop that C does not have")
            passes = _passes(known[loop.header], merged=len(loop.ends) > 1)
            repeats[loop.header] = max(passes - _ends_at_its_end(graph, loop), 0)
        return repeats

    def _in_c(self, lines: set[int], others: set[CLoop]) -> set[CLoop]:
        """Loops of C that a loop can come from.

        It executes the header of its loop of C. It begins the loops of C inside that, and has lines
        of their headers too.

        Args:
            lines: Lines of C of the instructions outside of inner loops.
            others: Loops of C that the inner loops come from.
        """
        heads = {c for c in self.loops if any(c.first <= n <= c.body for n in lines)}
        around = {c for c in self.loops if any(c.first <= n <= c.last for n in lines)}
        return heads - others or around - others or around

    def _in_library(
        self,
        graph: Mapping[int, Block],
        loop: NaturalLoop,
        loops: Sequence[NaturalLoop],
        size: int | None,
        normal: bool,
    ) -> int:
        name = self.listing.symbol(loop.header)
        if name in NORMALISING:
            return 0 if normal else NORMALISING[name]
        if name in REPEATS:
            return REPEATS[name]
        if name in MEMORY and size is not None:
            written = {each.header: _written(graph[each.header]) for each in loops}
            passes, narrow = size // max(written[loop.header], 1), MEMORY[name]
            widest = written[loop.header] == max(written.values())
            return passes if widest or narrow is None else min(passes, narrow)
        raise UnboundedError(f"{self.listing.where(loop.header)}: a loop of unknown length")


def _ends_at_its_end(graph: Mapping[int, Block], loop: NaturalLoop) -> bool:
    """Whether the test of a loop comes after its body, so that it begins no pass that it ends."""
    leaves = {
        address
        for address in loop.blocks
        if graph[address].returns or not loop.blocks.issuperset(graph[address].successors)
    }
    return leaves == set(loop.ends) and len(leaves) == 1


def _written(block: Block) -> int:
    """Bytes that a block writes."""
    return sum(_STORED.get(instruction.name, 0) for instruction in block.instructions)


def _passes(candidates: set[CLoop], *, merged: bool) -> int:
    """Largest number of passes of a loop of C, or of several that the compiler has merged."""

    def passes(loop: CLoop) -> int:
        inside = [passes(each) for each in candidates if merged and loop.contains(each)]
        return loop.passes * max([1, *inside])

    return max(map(passes, candidates))
