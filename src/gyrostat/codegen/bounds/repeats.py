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
        lines = {loop.header: self._own_lines(graph, loop, loops) for loop in loops}
        sources = self._sources([loop for loop in loops if lines[loop.header]], lines)
        repeats = dict[int, int]()
        for loop in loops:
            if loop.header in sources:
                passes = _passes(sources[loop.header], merged=len(loop.ends) > 1)
                repeats[loop.header] = max(passes - _ends_at_its_end(graph, loop), 0)
            else:
                repeats[loop.header] = self._in_library(graph, loop, loops, size, normal)
        return repeats

    def _own_lines(
        self, graph: Mapping[int, Block], loop: NaturalLoop, loops: Sequence[NaturalLoop]
    ) -> set[int]:
        """Lines of C of the instructions of a loop that are in no loop inside it."""
        own = loop.blocks.difference(*(each.blocks for each in loops if each.blocks < loop.blocks))
        return {i.line for block in own for i in graph[block].instructions if i.file == self.file}

    def _sources(
        self, loops: Sequence[NaturalLoop], lines: Mapping[int, set[int]]
    ) -> dict[int, set[CLoop]]:
        """Header of each loop -> loops of C that it can come from.

        A loop executes the header of its loop of C, so that it has a line of it. It can have those
        of others too: it begins the loops inside, and the compiler moves instructions. Of these
        remain the loops of C that are nested as the loops of the program are.

        Args:
            loops: Loops with lines of C.
            lines: Header -> lines of C that are in no loop inside it.

        Raises:
            UnboundedError: A loop has lines of no loop of C.
        """
        sources, around = dict[int, set[CLoop]](), dict[int, set[CLoop]]()
        for loop in loops:
            own = lines[loop.header]
            heads = {c for c in self.loops if any(c.first <= n <= c.body for n in own)}
            every = {c for c in self.loops if any(c.first <= n <= c.last for n in own)}
            if not every:
                where = self.listing.where(loop.header)
                raise UnboundedError(f"{where}: a loop that C does not have")
            sources[loop.header], around[loop.header] = heads or every, every
        pairs = [(a.header, b.header) for a in loops for b in loops if b.blocks < a.blocks]
        changed = True
        while changed:
            changed = False
            for outer, inner in pairs:
                outers = {o for o in sources[outer] if any(_in(i, o) for i in sources[inner])}
                inners = {i for i in sources[inner] if any(_in(i, o) for o in sources[outer])}
                for header, fits in ((outer, outers), (inner, inners)):
                    if not fits:  # the line of its own header is missing
                        fits = around.pop(header, sources[header])
                    if fits != sources[header]:
                        sources[header], changed = fits, True
        return sources

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


def _in(inner: CLoop, outer: CLoop) -> bool:
    """Whether a loop can be executed inside another: one of another function may be inlined."""
    return outer.contains(inner) or outer.function != inner.function


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
