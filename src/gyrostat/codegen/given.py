"""Operands of a function that it reads where the caller of the entry has them.

An entry of flight code gets structs of which it changes some. A function inside the module that
needs many numbers of those that no entry changes gets the whole struct: a call then has few
arguments, and large arrays need no copy.
"""

import math
import re
from collections import Counter
from collections.abc import Collection, Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import SMALL, Array, Data, is_plain
from gyrostat.codegen.dependencies import read_by, stored
from gyrostat.codegen.program import (
    Assign,
    Call,
    Function,
    Name,
    Number,
    Operand,
    Store,
    Table,
    statements,
)
from gyrostat.codegen.row_tables import has_rows
from gyrostat.codegen.rows import operand_key

MANY = 16
"""Largest number of scalars of an argument of the entry that are passed one by one."""


def argument(item: Operand | Table | None) -> str | None:
    """Argument of the entry that a scalar or a table is part of; None if there is none."""
    if isinstance(item, Table):
        path = item.hint if item.shape else ""
    else:
        path = item.hint if isinstance(item, Name) and item.fixed else ""
    name = re.match(r"\w+", path)
    return name[0] if name else None


def read_in_place(operands: Sequence[Array], unchanged: Collection[str]) -> list[bool]:
    """Whether a function reads each operand where the caller has it.

    Args:
        operands: Operands of a call.
        unchanged: Arguments that no entry changes.
    """
    parts = [_arguments(array, unchanged) for array in operands]
    scalars: Counter[str] = Counter()
    whole: set[str] = set()
    for array, names in zip(operands, parts, strict=True):
        for name in names or ():
            scalars[name] += array.size
            whole |= {name} if isinstance(array, Data) or scalars[name] > MANY else set()
    return [
        names is not None and (isinstance(array, Data) or names <= whole)
        for array, names in zip(operands, parts, strict=True)
    ]


def are_scalars(arrays: Sequence[Array]) -> bool:
    """Whether arrays can be passed to a function number by number."""
    return all(_is_of_few(a) or (isinstance(a, np.ndarray) and is_plain(a)) for a in arrays) and (
        not any(has_rows(a) for a in arrays)
    )


def are_small(variables: Sequence[Any]) -> bool:
    """Whether variables can be results of a function; C has no arrays as results."""
    return all(math.prod(variable.aval.shape) <= SMALL for variable in variables)


def key(array: Array, unchanged: Mapping[str, Hashable]) -> Hashable:
    """Equal for operands that are the same numbers of arguments of the same types.

    Args:
        array: Operand that is read in place.
        unchanged: Type of each argument that the entry does not change.
    """

    def part(item: Operand | Table) -> Hashable:
        name = argument(item)
        if name is not None:
            return item.hint, unchanged[name]  # pyright: ignore[reportAttributeAccessIssue]
        return item if isinstance(item, Table) else operand_key(item)

    if isinstance(array, Data):
        return part(array.table), array.places.tobytes(), array.shape
    assert isinstance(array, np.ndarray)
    return tuple(map(part, array.flat)), array.shape


def arguments_used(function: Function) -> set[str]:
    """Arguments of the entry that a function reads or sets, also in functions that it calls."""
    names: set[str | None] = set(map(argument, function.results))
    for statement in statements(function.body):
        names.update(map(argument, read_by(statement)))
        if isinstance(statement, Assign | Store):
            names.add(argument(statement.table))
        if isinstance(statement, Call):
            names |= arguments_used(statement.function)
    return {name for name in names if name is not None}


def arguments_set(function: Function) -> set[str]:
    """Arguments of the entry that a function sets elements of, also in functions that it calls."""
    return {name for name in map(argument, stored(function.body)) if name is not None}


def functions_called(function: Function) -> set[Function]:
    """Functions that a function calls, also through others."""
    called: set[Function] = set()
    waiting = [function]
    while waiting:
        body = statements(waiting.pop().body)
        found = {each.function for each in body if isinstance(each, Call)} - called
        called |= found
        waiting += found
    return called


def _is_of_few(array: Array) -> bool:
    """Whether an array is a small part of a table."""
    return isinstance(array, Data) and array.size <= SMALL and not array.table.changes


def _are_all_alike(array: NDArray[Any]) -> bool:
    """Whether several constants are logical, and all true or all false.

    Branches are left out of a function with such flags. A function for each choice of other
    constants would repeat more than it leaves out.
    """
    values = {(each.kind, each.value) for each in array.flat}
    return array.size > 1 and len(values) == 1 and next(iter(values))[0] == "logical"


def _arguments(array: Array, unchanged: Collection[str]) -> set[str] | None:
    """Arguments of the entry that an array is from, none for constants that a function may have.

    None if it is from anything else.
    """
    items: list[Any]
    match array:
        case Data(table=table, base=None):
            items = [] if table.values else [table]
        case np.ndarray():
            items = [each for each in array.flat if not isinstance(each, Number)]
            if not items:
                return set() if _are_all_alike(array) else None
        case _:
            return None
    names = {argument(item) for item in items}
    return {name for name in names if name} if names <= {*unchanged} else None
