"""Table of rules that lower each primitive of JAX; batches have additional rules."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen import control_flow, indexing, ordering, special
from gyrostat.codegen.data import Data
from gyrostat.codegen.primitives import ALIKE, ELEMENTWISE, MOVES, Scalars

Rule = Callable[..., Scalars | Sequence[Scalars | Data]]
"""(builder, operands) -> result, or results."""


def _elementwise(operation: str) -> Rule:
    return lambda build, *operands: build.apply(operation, *operands)


def _move(move: Callable[..., Sequence[Any]]) -> Rule:
    return lambda build, *operands: [
        np.asarray(array, dtype=object) for array in move(build.params, *operands)
    ]


RULES: Mapping[str, Rule] = {
    **{name: _elementwise(operation) for name, operation in ELEMENTWISE.items()},
    **{name: _move(move) for name, move in MOVES.items()},
    **dict.fromkeys(ALIKE, lambda build, *operands: operands),
    **special.RULES,
    **control_flow.RULES,
    **indexing.RULES,
    **ordering.RULES,
}
"""Primitive -> rule."""
