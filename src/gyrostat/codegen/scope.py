"""Limits on what may be lowered: array types, sizes and primitives, for flight code or batches."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import SMALL
from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Kind, Number
from gyrostat.codegen.source import UnsupportedError

TYPES = "float64, int32, int64, uint32 or logical"
"""Types of the numbers of flight code, for messages."""
LARGEST = 1024
"""Largest number of elements of an array in flight code."""


@lru_cache
def kind_of(dtype: Any) -> Kind | None:
    """Kind of number of an array type; None if flight code does not support it."""
    if dtype == np.float64:
        return "real"
    if dtype == np.bool_:
        return "logical"
    return "integer" if dtype in (np.int32, np.int64, np.uint32) else None


@dataclass(frozen=True)
class Scope:
    """Limits on what may be lowered; the defaults are those of flight code.

    Attributes:
        kind_of: Function that gives the kind of number of an array type; None for a refused type.
        rules: Rules that extend or replace `gyrostat.codegen.rules.RULES`.
        largest: Largest number of elements of an array.
        in_place: Whether functions are lowered where they are called (inlined).
        unbounded: Whether a loop may have an unbounded number of passes.
        array: Function that converts a constant of JAX to an array of numbers.
        narrow: Type -> operation that keeps integers of less than 64 bits within their range.
        longest: Largest number of passes of a scan whose rows are scalars; the rows of a longer
            scan are kept as tables.
        few: Largest number of elements of a part of a table that is one of scalars.
        known: The same for a table that is an input or a constant.
        written: Largest number of operations on elements of tables that are written out.
        rows: Ranges of rows of constants that become passes of one loop, beside those found, each
            with the number of arrays of rows that are in tables by then; None if no rows become
            passes of a loop, see `row_loops`.
    """

    kind_of: Callable[[Any], Kind | None] = kind_of
    rules: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    largest: int = LARGEST
    in_place: bool = False
    unbounded: bool = False
    array: Callable[[Any], Any] = np.asarray
    narrow: Mapping[Any, str] = field(default_factory=dict)
    longest: float = np.inf
    few: int = 8
    known: int = SMALL
    written: int = 64
    rows: tuple[tuple[int, int, int], ...] | None = ()

    def kind(self, atom: Any) -> Kind:
        """Kind of number of a variable that may be lowered."""
        kind = self.kind_of(atom.aval.dtype)
        assert kind is not None  # `Lowering` refuses unsupported types
        return kind

    def numbers(self, array: Any) -> Scalars:
        """Array of constants.

        Raises:
            UnsupportedError: The array is too large or its type is not supported.
        """
        array = self.array(array)
        kind = self.kind_of(array.dtype)
        if kind is None or array.size > self.largest:
            found = f"{array.dtype}{list(array.shape)}"
            raise UnsupportedError(
                f"constant: found {found}, expected {TYPES} arrays of at most {self.largest} "
                "elements",
                f"a constant {found}",
            )
        return one_by_one(array.shape, lambda value: Number(kind, value.item()), array)


NARROW = {np.dtype(np.uint32): "to_word", np.dtype(np.int32): "to_half"}
"""Operations that keep 32-bit numbers within their range."""
FLIGHT = Scope(narrow=NARROW)
