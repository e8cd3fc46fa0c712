"""Table of rules that lower each primitive of JAX; batches have additional rules."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from gyrostat.codegen import (
    control_flow,
    elimination,
    indexing,
    ordering,
    products,
    reductions,
    scatter,
    special,
)
from gyrostat.codegen.arrays import Array
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.nests import rearranged
from gyrostat.codegen.primitives import ALIKE, ELEMENTWISE, MOVES
from gyrostat.codegen.sparse import sparse_sum

Rule = Callable[..., Array | Sequence[Array]]
"""(builder, operands) -> result, or results."""


def _elementwise(operation: str) -> Rule:
    return lambda build, *operands: build.apply(operation, *operands)


def _sum(operation: str) -> Rule:
    def rule(build: Builder, first: Array, second: Array) -> Array:
        is_large = build.size > build.scope.few and build.scope.kind(build.target) == "real"
        known = sparse_sum(build, operation, first, second) if is_large else None
        return build.apply(operation, first, second) if known is None else known

    return rule


def _move(move: Callable[..., Sequence[Any]]) -> Rule:
    return lambda build, *arrays: rearranged(build, move, arrays)


OF_ARRAYS = frozenset(
    {
        *(*ELEMENTWISE, *MOVES, *ALIKE, *products.RULES, *reductions.RULES, *special.OF_ARRAYS),
        *(*control_flow.RULES, *elimination.RULES, *indexing.RULES, *scatter.RULES),
        *ordering.OF_ARRAYS,
    }
)
"""Primitives whose rules take large arrays as they are; those of others take scalars."""

ROW_BY_ROW = frozenset({*ELEMENTWISE, *MOVES, *special.ROW_BY_ROW, "dot_general", "reduce_sum"})
"""Primitives whose rules take scalars of rows, see `row_loops`."""

RULES: Mapping[str, Rule] = {
    **{name: _elementwise(operation) for name, operation in ELEMENTWISE.items()},
    "add": _sum("add"),
    "add_any": _sum("add"),
    "sub": _sum("sub"),
    **{name: _move(move) for name, move in MOVES.items()},
    **dict.fromkeys(ALIKE, lambda build, *operands: operands),
    **special.RULES,
    **control_flow.RULES,
    **elimination.RULES,
    **indexing.RULES,
    **scatter.RULES,
    **ordering.RULES,
    **products.RULES,
    **reductions.RULES,
}
"""Primitive -> rule."""
