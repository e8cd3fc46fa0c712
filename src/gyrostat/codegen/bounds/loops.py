"""Natural loops of a control-flow graph (Aho, Lam, Sethi, Ullman: Compilers, 9.6)."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .graph import Block


@dataclass(frozen=True)
class NaturalLoop:
    """Loop of a control-flow graph.

    Attributes:
        header: Block through which alone it is entered.
        blocks: Its blocks, with those of loops inside it.
        ends: Blocks from which it returns to the header.
    """

    header: int
    blocks: frozenset[int]
    ends: tuple[int, ...]


def reverse_postorder(graph: Mapping[int, Block], entry: int) -> list[int]:
    """Blocks, each before those that follow it, but for the edges that close a loop."""
    order, met, ahead = [], {entry}, [(entry, iter(graph[entry].successors))]
    while ahead:
        block, successors = ahead[-1]
        for successor in successors:
            if successor not in met:
                met.add(successor)
                ahead.append((successor, iter(graph[successor].successors)))
                break
        else:
            order.append(block)
            ahead.pop()
    return order[::-1]


def natural_loops(graph: Mapping[int, Block], order: Sequence[int]) -> list[NaturalLoop] | None:
    """Loops of a graph, each after those that contain it; None if a loop has several entries.

    Args:
        graph: Blocks.
        order: Reverse postorder of the blocks.
    """
    number = {block: k for k, block in enumerate(order)}
    before: dict[int, list[int]] = defaultdict(list)
    for block in order:
        for successor in graph[block].successors:
            before[successor].append(block)
    dominator = _dominators(order, number, before)
    ends: dict[int, list[int]] = defaultdict(list)
    for block in order:
        for successor in graph[block].successors:
            if number[successor] <= number[block]:
                if not _dominates(dominator, successor, block):
                    return None
                ends[successor].append(block)
    loops = []
    for header, last in ends.items():
        blocks, ahead = {header}, list(last)
        while ahead:
            block = ahead.pop()
            if block not in blocks:
                blocks.add(block)
                ahead += before[block]
        loops.append(NaturalLoop(header, frozenset(blocks), tuple(last)))
    return sorted(loops, key=lambda loop: -len(loop.blocks))


def _dominators(
    order: Sequence[int], number: Mapping[int, int], before: Mapping[int, list[int]]
) -> dict[int, int]:
    """Immediate dominators (Cooper, Harvey, Kennedy: A simple, fast dominance algorithm)."""
    entry, changed = order[0], True
    dominator = {entry: entry}
    while changed:
        changed = False
        for block in order[1:]:
            known = [each for each in before[block] if each in dominator]
            common = known[0]
            for other in known[1:]:
                while common != other:
                    while number[other] > number[common]:
                        other = dominator[other]
                    while number[common] > number[other]:
                        common = dominator[common]
            if dominator.get(block) != common:
                dominator[block], changed = common, True
    return dominator


def _dominates(dominator: Mapping[int, int], above: int, block: int) -> bool:
    while block != above and dominator[block] != block:
        block = dominator[block]
    return block == above
