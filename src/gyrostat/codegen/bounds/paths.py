"""Longest paths in a control-flow graph whose loops have bounds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .graph import Block
from .loops import NaturalLoop


def longest_paths(
    graph: Mapping[int, Block],
    order: Sequence[int],
    loops: Sequence[NaturalLoop],
    costs: Mapping[int, int],
    repeats: Mapping[int, int],
) -> dict[int, int]:
    """Block -> length of the longest path from the first block to its end.

    Args:
        graph: Blocks.
        order: Reverse postorder of the blocks.
        loops: All loops.
        costs: Block -> length of one execution.
        repeats: Header of a loop -> how often the loop returns to it at most, each time it is
            entered.
    """
    headers = {loop.header: loop for loop in loops}
    start = order[0]
    return _Paths(graph, order, headers, costs, repeats).within(start, frozenset(order), None)


@dataclass(frozen=True)
class _Paths:
    """Arguments of `longest_paths`."""

    graph: Mapping[int, Block]
    order: Sequence[int]
    loops: Mapping[int, NaturalLoop]
    costs: Mapping[int, int]
    repeats: Mapping[int, int]

    def within(self, start: int, blocks: frozenset[int], around: int | None) -> dict[int, int]:
        """Longest paths from a block through some others.

        Args:
            start: First block.
            blocks: Blocks of the paths.
            around: Header of the loop that consists of these blocks; None for a function. The paths
                do not return to it.
        """
        arrival, lengths = {start: 0}, dict[int, int]()
        for block in self.order:
            if block not in arrival or block in lengths or block not in blocks:
                continue
            part = {block: self.costs[block]}
            if block in self.loops and block != around:
                loop = self.loops[block]
                part = self.within(block, loop.blocks, block)
                repeated = self.repeats[block] * max(part[end] for end in loop.ends)
                part = {each: repeated + length for each, length in part.items()}
            for each, length in part.items():
                lengths[each] = arrival[block] + length
            for each in part:
                for successor in self.graph[each].successors:
                    if successor in blocks and successor not in part and successor != around:
                        arrival[successor] = max(arrival.get(successor, 0), lengths[each])
        return lengths
