"""Matrix products in dense blocks of a matrix with known zeros and ones."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import Array, Data, joined, runs_of
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.nests import declared, store
from gyrostat.codegen.product_loops import (
    Factor,
    add_rows,
    columns_of,
    rows_of,
    sum_by_sum,
)
from gyrostat.codegen.program import ONE, ZERO

LEAST = 9
"""Smallest number of elements of a block; the sums of a smaller one are written out."""

Places = NDArray[np.int64]


class Block(NamedTuple):
    """Rows and columns, all elements of which are used."""

    rows: Places
    columns: Places


def blocks_of(factor: Factor) -> list[Block] | None:
    """Dense blocks of columns with the same rows; None if they are not all that is to be summed.

    Elements that are 1 do not count: they add rows of the other matrix.
    """
    if factor.known is None:
        return None
    by_rows: dict[tuple[int, ...], list[int]] = {}
    for column, is_summed in enumerate((factor.is_used & ~_ones(factor)).T):
        if is_summed.any():
            by_rows.setdefault((*np.flatnonzero(is_summed).tolist(),), []).append(column)
    blocks = [Block(np.array(rows), np.array(columns)) for rows, columns in by_rows.items()]
    return blocks if blocks and all(map(_is_dense, blocks)) else None


def _is_dense(block: Block) -> bool:
    """Whether the parts of a block with constant distances are large."""
    parts = math.prod(len([*runs_of(places)]) for places in block)
    return len(block.rows) > 1 and math.prod(map(len, block)) >= LEAST * parts


def _ones(factor: Factor) -> NDArray[np.bool_]:
    assert factor.known is not None
    ones = [each == ONE for each in factor.known.flat]
    return np.array(ones, bool).reshape(factor.known.shape)


def in_blocks(
    build: Builder, first: Factor, blocks: list[Block], right: Array, *, is_turned: bool
) -> Array:
    """Product as loops over the blocks of the left matrix.

    Args:
        build: Builder.
        first: Left matrix.
        blocks: Its blocks.
        right: Right matrix.
        is_turned: Whether it is the transposed product that is needed, row by row.
    """
    assert first.known is not None
    height, width = len(first.known), right.shape[1]
    kept = np.flatnonzero(first.is_used.any(axis=1))
    table = declared(build, "real", len(kept) * width)
    places = np.arange(table.size)
    places = places.reshape(width, -1).T if is_turned else places.reshape(-1, width)
    place = {int(row): number for number, row in enumerate(kept)}

    def part(rows: Any) -> Data:
        return Data(table, places[[place[int(row)] for row in rows]])

    ones = _ones(first)
    summed = {int(row) for block in blocks for row in block.rows}
    copied = np.array([row for row in kept if int(row) not in summed], int)
    for rows, columns in _runs(ones, copied):
        store(build, rows_of(right, columns), part(rows))
    begun: set[int] = set()
    for block in blocks:
        for columns in runs_of(block.columns):
            factors = rows_of(right, columns)
            for adds in (False, True):
                every = np.array([row for row in block.rows if (int(row) in begun) == adds], int)
                for rows in runs_of(every):
                    left = columns_of(rows_of(first.array, rows), columns)
                    sum_by_sum(build, left, factors, part(rows), adds=adds)
            begun.update(block.rows.tolist())
    for rows, columns in _runs(ones, np.array(sorted(summed))):
        factors = np.full(len(rows), ONE, dtype=object)
        add_rows(build, factors, rows_of(right, columns), part(rows))
    results = np.full((height, width), ZERO, dtype=object)
    results[kept] = Data(table, places).elements()
    return joined(results)


def _runs(ones: NDArray[np.bool_], rows: Places) -> Iterator[tuple[Places, Places]]:
    """Rows with a 1 and their columns, in runs of constant distances."""
    within, columns = np.nonzero(ones[rows]) if len(rows) else (rows, rows)
    flat = rows[within] * ones.shape[1] + columns
    for places in runs_of(flat):
        yield np.divmod(places, ones.shape[1])
