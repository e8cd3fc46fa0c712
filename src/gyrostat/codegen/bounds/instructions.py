"""Bound of the instructions that a function executes.

A loop is replaced by its longest pass times its passes, and what remains has no cycle, so that its
longest path is the bound (Wilhelm and others: The worst-case execution-time problem, ACM TECS 7(3),
2008, path-based bound calculation).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .graph import Call, function_graph
from .library import COUNTED
from .listing import Listing, UnboundedError
from .loops import natural_loops, reverse_postorder
from .passes import CLoop
from .paths import longest_paths
from .repeats import Repeats


@dataclass(frozen=True)
class InstructionBound:
    """Bound of a function.

    Attributes:
        any: Instructions for any numbers.
        normal: Instructions if no operand is subnormal.
    """

    any: int
    normal: int


class Instructions:
    """Bounds of the functions of a program."""

    def __init__(
        self, listing: Listing, file: str, loops: Sequence[CLoop], counted: Mapping[str, int]
    ) -> None:
        """Bounds for a program.

        Args:
            listing: Program, with the lines of C.
            file: Name of the C file with the loops.
            loops: Loops of that file.
            counted: Function of `library.COUNTED` -> its largest count.
        """
        self._listing, self._counted = listing, counted
        self._repeats = Repeats(listing, file, loops)
        self._known: dict[tuple[Call, bool], int] = {}
        self._open: set[int] = set()

    def bound(self, function: str) -> InstructionBound:
        """Bound of a function with the functions that it calls.

        Raises:
            UnboundedError: There is no bound, and why.
        """
        call = Call(self._listing.address(function), None)
        return InstructionBound(self._call(call, False), self._call(call, True))

    @property
    def reached(self) -> set[str]:
        """Functions that those with a bound call."""
        return {self._listing.symbol(call.address) for call, _ in self._known}

    def _call(self, call: Call, normal: bool) -> int:
        if (call, normal) not in self._known:
            name = self._listing.symbol(call.address)
            if call.address in self._open:
                raise UnboundedError(f"{name}: recursion")
            if name in COUNTED and name not in self._counted:
                raise UnboundedError(f"{name}: its largest count is not given")
            self._open.add(call.address)
            longest = self._counted[name] if name in COUNTED else self._longest(call, normal)
            self._known[call, normal] = longest
            self._open.remove(call.address)
        return self._known[call, normal]

    def _longest(self, call: Call, normal: bool) -> int:
        graph = function_graph(self._listing, call.address)
        order = reverse_postorder(graph, call.address)
        loops = natural_loops(graph, order)
        if loops is None:
            raise UnboundedError(f"{self._listing.where(call.address)}: a loop has several entries")
        costs = {
            address: len(block.instructions) + sum(self._call(c, normal) for c in block.calls)
            for address, block in graph.items()
        }
        repeats = self._repeats.of_function(graph, loops, call.size, normal)
        lengths = longest_paths(graph, order, loops, costs, repeats)
        ends = [lengths[address] for address, block in graph.items() if block.returns]
        if not ends:
            raise UnboundedError(f"{self._listing.where(call.address)}: does not return")
        return max(ends)
