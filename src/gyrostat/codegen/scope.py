"""What may be lowered: flight code, or a larger set."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Kind, Number
from gyrostat.core.errors import InputError

LARGEST = 1024
"""Largest number of elements of an array in flight code."""


def kind_of(dtype: Any) -> Kind | None:
    """The kind of number of an array type; None for one that flight code does not have."""
    if dtype == np.float64:
        return "real"
    if dtype == np.bool_:
        return "logical"
    return "integer" if dtype in (np.int32, np.int64) else None


@dataclass(frozen=True)
class Scope:
    """What may be lowered; the defaults are those of flight code.

    Attributes:
        kind_of: The kind of number of an array type; None for one that is refused.
        rules: Rules beside or in place of `gyrostat.codegen.rules.RULES`.
        largest: Largest number of elements of an array.
        in_place: Whether what would be a function is lowered where it is called.
        unbounded: Whether a loop may have no bound of its passes.
        array: A constant of JAX as an array of numbers.
        narrow: Operation that keeps numbers of less than 64 bits within their range, by type.
        longest: Passes of a scan whose rows are scalars; those of a longer one are kept tables.
    """

    kind_of: Callable[[Any], Kind | None] = kind_of
    rules: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    largest: int = LARGEST
    in_place: bool = False
    unbounded: bool = False
    array: Callable[[Any], Any] = np.asarray
    narrow: Mapping[Any, str] = field(default_factory=dict)
    longest: float = np.inf

    def kind(self, atom: Any) -> Kind:
        """The kind of number of a variable, which is one that may be lowered."""
        kind = self.kind_of(atom.aval.dtype)
        assert kind is not None  # `Lowering` has refused the others
        return kind

    def numbers(self, array: Any) -> Scalars:
        """An array of constants.

        Raises:
            InputError: It is too large or of a type that is refused.
        """
        array = self.array(array)
        kind = self.kind_of(array.dtype)
        if kind is None or array.size > self.largest:
            raise InputError(
                f"constant: found {array.dtype}{list(array.shape)}, expected float64, integer or "
                f"logical arrays of at most {self.largest} elements"
            )
        return one_by_one(array.shape, lambda value: Number(kind, value.item()), array)


FLIGHT = Scope()
