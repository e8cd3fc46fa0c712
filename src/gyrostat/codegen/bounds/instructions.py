"""Bound of the instructions that a function executes.

A loop is replaced by its longest pass times its passes, and what remains has no cycle, so that its
longest path is the bound (Wilhelm and others: The worst-case execution-time problem, ACM TECS 7(3),
2008, path-based bound calculation).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from .constants import third_arguments
from .graph import Block, function_graph
from .library import COUNTED, MEMORY
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


@dataclass(frozen=True)
class _Call:
    """Call of a function.

    Attributes:
        address: Address of the function.
        size: Third argument, if it is a constant: the bytes of memcpy.
        normal: Whether no operand is subnormal.
    """

    address: int
    size: int | None
    normal: bool


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
        self._writing = {address for address, name in listing.symbols.items() if name in MEMORY}
        self._known: dict[_Call, int] = {}
        self._open: set[int] = set()

    def bound(self, function: str) -> InstructionBound:
        """Bound of a function with the functions that it calls.

        Raises:
            UnboundedError: There is no bound, and why.
        """
        address = self._listing.address(function)
        return InstructionBound(*(self._call(_Call(address, None, n)) for n in (False, True)))

    @property
    def reached(self) -> set[str]:
        """Functions that those with a bound call."""
        return {self._listing.symbol(call.address) for call in self._known}

    def _call(self, call: _Call) -> int:
        if call not in self._known:
            name = self._listing.symbol(call.address)
            if call.address in self._open:
                raise UnboundedError(f"{name}: recursion")
            if name in COUNTED and name not in self._counted:
                raise UnboundedError(f"{name}: its largest count is not given")
            self._open.add(call.address)
            self._known[call] = self._counted[name] if name in COUNTED else self._longest(call)
            self._open.remove(call.address)
        return self._known[call]

    def _costs(self, graph: Mapping[int, Block], call: _Call) -> dict[int, int]:
        """Block -> instructions of one execution, with those of the functions that it calls."""
        calls = {place: callee for b in graph.values() for place, callee in b.calls.items()}
        writing = {place for place, callee in calls.items() if callee in self._writing}
        sizes = third_arguments(graph, call.address) if writing else {}
        costs = {
            place: self._call(
                _Call(callee, sizes.get(place) if place in writing else None, call.normal)
            )
            for place, callee in calls.items()
        }
        return {
            address: len(block.instructions) + sum(costs[place] for place in block.calls)
            for address, block in graph.items()
        }

    def _longest(self, call: _Call) -> int:
        graph = function_graph(self._listing, call.address)
        order = reverse_postorder(graph, call.address)
        loops = natural_loops(graph, order)
        if loops is None:
            raise UnboundedError(f"{self._listing.where(call.address)}: a loop has several entries")
        costs = self._costs(graph, call)
        repeats = self._repeats.of_function(graph, loops, call.size, call.normal)
        lengths = longest_paths(graph, order, loops, costs, repeats)
        ends = [lengths[address] for address, block in graph.items() if block.returns]
        if not ends:
            raise UnboundedError(f"{self._listing.where(call.address)}: does not return")
        return max(ends)
