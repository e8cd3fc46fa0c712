"""Simultaneous assignment of tables, as at the end of a pass of a loop."""

from collections.abc import Sequence

import numpy as np

from gyrostat.codegen.arrays import Array, Data, Element, leaves, of_caller
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.nests import filled, store
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.program import Name, Table


def set_tables(build: Builder, changes: Sequence[tuple[Array, Data]]) -> None:
    """Append one simultaneous assignment of whole tables, which the arrays may be computed from.

    Args:
        build: Builder.
        changes: Arrays, and the tables that they become.
    """
    changes = [(new, data) for new, data in changes if not _is_same(new, data)]
    direct = [_is_direct(*change, changes) for change in changes]
    ready = [
        new if at_once else filled(build, new)
        for (new, _), at_once in zip(changes, direct, strict=True)
    ]
    for new, (_, data) in zip(ready, changes, strict=True):
        store(build, new, data)


def _is_same(array: Array, data: Data) -> bool:
    """Whether an array is what the table of some data holds, in place."""
    if isinstance(array, np.ndarray):
        array = of_caller(array)
    if not isinstance(array, Data) or array.base is not None:
        return False
    return _is(array.table, data.table) and np.array_equal(array.places, data.places)


def _is(table: Table, other: Table) -> bool:
    """Whether two tables are one; each argument and result of a caller has a table of its own."""
    return table is other or bool(
        table.shape and (table.hint, table.shape) == (other.hint, other.shape)
    )


def _is_direct(new: Array, data: Data, changes: Sequence[tuple[Array, Data]]) -> bool:
    """Whether a table may be set element by element, because nothing reads it at another place.

    Other arrays that read it are computed before, as they are not direct.
    """
    others = [leaf for leaf in leaves(new) if not _is_same(leaf, data)]
    return not any(
        table.changes or table.shape for leaf in others for table in _tables(leaf)
    ) and not any(
        _is(table, target.table)
        for leaf in others
        for table in _tables_of_scalars(leaf)
        for _, target in changes
    )


def _tables(array: Scalars | Data) -> list[Table]:
    """Tables that an array reads in a loop."""
    if isinstance(array, Data):
        return [array.table]
    return [each.table for each in array.flat if isinstance(each, Element)]


def _tables_of_scalars(array: Scalars | Data) -> set[Table]:
    """Arrays of the caller of which scalars of an array are elements."""
    if isinstance(array, Data):
        return set()
    return {each.table for each in array.flat if isinstance(each, Name) and each.table}
