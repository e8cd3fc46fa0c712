"""Sets, hashes and identities of a text that differ from those of this process."""

import ast
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

from gyrostat.core.user_modules import Source

_SET = f"__import__({__name__!r}, fromlist=[None]).unordered"
_COMPUTED = (
    *("__and__", "__or__", "__sub__", "__xor__", "copy", "difference", "intersection"),
    *("symmetric_difference", "union"),
)
"""Methods that return another set."""


class _AsCalls(ast.NodeTransformer):
    """Sets in a text, and results of `hash` and `id`, are made by `unordered`.

    Attributes:
        turn: Its first argument.
    """

    def __init__(self, turn: int):
        self.turn = turn

    def visit_Set(self, node: ast.Set) -> ast.AST:
        """Set display; one of numbers is the same in all processes."""
        if all(isinstance(each, ast.Constant) and _is_fixed(each.value) for each in node.elts):
            return node
        entries: Any = self.generic_visit(node)
        return _call(self.turn, ast.Name("set", ast.Load()), ast.Tuple(entries.elts, ast.Load()))

    def visit_SetComp(self, node: ast.SetComp) -> ast.AST:
        """Set comprehension."""
        return _call(self.turn, ast.Name("set", ast.Load()), self.generic_visit(node))

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Call of a class of sets, or of a function whose results other processes do not have."""
        call: Any = self.generic_visit(node)
        match call.func:
            case ast.Name(id="set" | "frozenset"):
                return _call(self.turn, call.func, *call.args)
            case ast.Name(id="hash" | "id"):
                return _call(0, call.func, *call.args)  # the same in each turn
        return call


def _call(turn: int, kind: Any, *arguments: Any) -> ast.Call:
    nodes = [ast.Constant(turn), kind, *arguments]
    return ast.Call(ast.parse(_SET, mode="eval").body, nodes, [])


def without_order(source: Source, turn: int) -> Source:
    """Module with other sets, hashes and identities; the same if it has none."""
    if not source.is_module:
        return source
    tree = _AsCalls(turn).visit(ast.parse(source.text))
    text = ast.unparse(ast.fix_missing_locations(tree))
    return replace(source, text=text) if _SET in text else source


def unordered(turn: int, kind: Any, *entries: Any) -> Any:
    """Result of `set`, `frozenset`, `hash` or `id`, different from the one here.

    What all processes have alike stays: the order of numbers in a set, and their hash. All other
    sets are sorted, and their entries moved by some places: the order of a set here is not known,
    because a display of constants, a copy and a union have orders of their own, but it can agree
    with one turn at most in any place.

    Args:
        turn: Places by which the entries are moved.
        kind: Class or function that is called.
        entries: Its arguments.
    """
    if kind in (hash, id):
        number = kind(*entries)
        return number if kind is hash and all(map(_is_fixed, entries)) else number + 1
    return _reorder(turn, kind(*map(_plain, entries)))


def _is_fixed(entry: Any) -> bool:
    """Whether all processes give a value the same hash."""
    if isinstance(entry, tuple):
        return all(map(_is_fixed, entry))
    return isinstance(entry, int | float | complex)


def _reorder(turn: int, plain: Any) -> Any:
    """Set of the entries of a plain one, in another order; anything else as it is."""
    if type(plain) not in (set, frozenset):
        return plain
    copy = _kind_of_turn(turn, type(plain))(plain)
    copy.plain = plain
    return copy


def _plain(entry: Any) -> Any:
    """Set that a moved one was made of; anything else as it is."""
    plain = getattr(entry, "plain", None) if isinstance(entry, set | frozenset) else None
    # a set that has changed since then has an order of its own
    return entry if plain is None or not frozenset.__eq__(frozenset(plain), entry) else plain


@cache
def _kind_of_turn(turn: int, kind: Any) -> Any:
    """Class of sets in another order, also of the sets computed from them."""

    def move(instance: Any) -> Iterator[Any]:
        entries = [*kind.__iter__(_plain(instance))]
        if not all(map(_is_fixed, entries)):
            entries.sort(key=lambda entry: (type(entry).__qualname__, repr(entry)))
            places = turn % len(entries)
            entries = [*entries[places:], *entries[:places]]
        return iter(entries)

    def pop(instance: Any) -> Any:
        entry = next(iter(instance))
        instance.remove(entry)
        return entry

    def method(name: str) -> Callable[..., Any]:
        def call(instance: Any, *operands: Any) -> Any:
            return _reorder(turn, getattr(kind, name)(_plain(instance), *map(_plain, operands)))

        return call

    methods = {name: method(name) for name in _COMPUTED}
    members = {"__iter__": move, "pop": pop, "plain": kind()}
    return type(kind.__name__, (kind,), methods | members)
