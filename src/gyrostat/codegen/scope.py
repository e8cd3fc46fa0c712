"""What may be lowered: flight code, or a larger set."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gyrostat.codegen.program import Kind

LARGEST = 1024
"""Elements of an array: what is larger is no scalar code."""


def kind_of(dtype: Any) -> Kind | None:
    """The kind of number of an array type; None for one that flight code has no use for."""
    if dtype == np.float64:
        return "real"
    if dtype == np.bool_:
        return "logical"
    return "integer" if dtype in (np.int32, np.int64) else None


@dataclass(frozen=True)
class Scope:
    """What may be lowered; unless it says more, what belongs in flight code.

    Attributes:
        kind_of: the kind of number of an array type; None for one that is refused.
        lowered: more primitives, or other ways: name -> (lowering, equation, operands, block,
            source) -> results.
        largest: elements of an array.
        in_place: whether what would be a function is lowered where it is called.
        unbounded: whether a loop may have no bound of its passes.
        array: a constant of JAX as an array of numbers.
        narrow: what keeps numbers of less than 64 bits within theirs: type -> operation.
        longest: passes of a scan whose rows are scalars; those of a longer one are kept tables.
    """

    kind_of: Callable[[Any], Kind | None] = kind_of
    lowered: Mapping[str, Callable[..., Sequence[Any]]] = field(default_factory=dict)
    largest: int = LARGEST
    in_place: bool = False
    unbounded: bool = False
    array: Callable[[Any], Any] = np.asarray
    narrow: Mapping[Any, str] = field(default_factory=dict)
    longest: float = np.inf


FLIGHT = Scope()
