"""Rule for matrix products: written out, or loops where that is shorter and no slower."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.arrays import (
    Array,
    Data,
    Deferred,
    is_plain,
    joined,
    moved,
    spread,
    used,
)
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.nests import filled, objects, settled
from gyrostat.codegen.primitives import Scalars
from gyrostat.codegen.product_blocks import blocks_of, in_blocks
from gyrostat.codegen.product_loops import (
    Factor,
    looped,
    over_columns,
    row_of,
    rows_of,
    sum_of_products,
    transposed,
    turned,
)
from gyrostat.codegen.program import ONE, ZERO, Number
from gyrostat.codegen.row_loops import along, are_parallel
from gyrostat.codegen.row_tables import has_rows, settled_rows

LONGEST = 1000
"""Largest number of products of scalars that are written out."""
WRITTEN_ROWS = 128
"""Largest number of products in the body of a loop over the columns of a matrix."""


def _factor(build: Builder, array: Array) -> Factor:
    is_known = is_plain(array) or isinstance(array, np.ndarray)
    known = objects(build, array) if is_known else None
    if known is None:
        return Factor(array, None, np.ones(array.shape, bool))
    return Factor(array, known, used(known))


def _dot(build: Builder, first: Array, second: Array) -> Array | Sequence[Array]:
    """Sums of products, added from first to last, without those with a constant zero.

    A zero of a matrix means that two quantities have nothing to do with each other: NaN and
    infinity do not spread through it.
    """
    (left_axes, right_axes), (left_batch, right_batch) = build.params["dimension_numbers"]
    if any(operand.aval.dtype != np.float64 for operand in build.equation.invars):
        raise build.refused("operands of other types", "float64 ones")

    def rows(array: Array, batch: Sequence[int], axes: Sequence[int], *, last: bool) -> Array:
        free = [k for k in range(array.ndim) if k not in (*batch, *axes)]
        order = [*batch, *free, *axes] if last else [*batch, *axes, *free]
        counts = [int(np.prod([array.shape[k] for k in group])) for group in (batch, free, axes)]
        sizes = counts if last else [counts[0], counts[2], counts[1]]
        return moved(lambda _, each: [each.transpose(order).reshape(sizes)], {}, array)[0]

    left = rows(first, left_batch, left_axes, last=True)
    right = rows(second, right_batch, right_axes, last=False)
    results = [_product(build, row_of(left, b), row_of(right, b)) for b in range(left.shape[0])]
    if len(results) == 1:
        return _shaped(build, results[0])
    stacked = np.stack([objects(build, each) for each in results])
    return _shaped(build, joined(stacked))


def _shaped(build: Builder, array: Array) -> Array:
    return settled(build, moved(lambda _, each: [each.reshape(build.shape)], {}, array)[0])


def _product(build: Builder, left: Array, right: Array) -> Array:
    """Product of two matrices."""
    if not left.size or not right.size:
        raise build.refused("a sum of no elements", "one or more")
    # an operation on each element is computed once, not in each sum
    left, right = (filled(build, a) if isinstance(a, Deferred) else a for a in (left, right))
    left, right = _by_row(build, left, right)
    first, second = _factor(build, left), _factor(build, right)
    terms = first.is_used.astype(int) @ second.is_used.astype(int)
    products = int(terms.sum())
    if all(isinstance(each, np.ndarray) and is_plain(each) for each in (left, right)):
        is_written = products <= LONGEST
    else:
        is_written = _operations(first, second, terms) <= build.scope.written
    if is_written:
        return _written(build, first, second, terms.shape)
    height, width = terms.shape
    used_left, used_right = int(first.is_used.sum()), int(second.is_used.sum())
    dense = first.is_used.size * width
    if 2 * used_left * width <= dense and used_left <= WRITTEN_ROWS and width > 1:
        return _sparse(build, first, right, is_turned=False)
    if 2 * used_right * height <= dense and used_right <= WRITTEN_ROWS and height > 1:
        return turned(_sparse(build, transposed(second), turned(left), is_turned=True))
    return looped(build, first, second)


def _by_row(build: Builder, left: Array, right: Array) -> tuple[Array, Array]:
    """Factors with scalars of rows where each sum of products is of one row."""
    if not (is_plain(left) and is_plain(right)):
        return settled_rows(build, left), settled_rows(build, right)
    first, second = objects(build, left), objects(build, right)
    is_number = [
        np.vectorize(lambda each: isinstance(each, Number), otypes=[bool])(each)
        for each in (first, second)
    ]
    # a row is combined with all columns, and a column with all rows
    pair = (
        along(build, first, 0, ~is_number[1].all(axis=1)[None, :]),
        along(build, second, 1, ~is_number[0].all(axis=0)[:, None]),
    )
    if not any(map(has_rows, pair)):
        return left, right
    if are_parallel(*pair):
        return pair
    return settled_rows(build, pair[0]), settled_rows(build, pair[1])


def _sparse(build: Builder, first: Factor, right: Array, *, is_turned: bool) -> Array:
    """Product with a left matrix of few used elements."""
    if first.known is not None and (first.is_used.sum(axis=1) == 1).all():
        columns = first.is_used.argmax(axis=1)
        factors: Any = np.take_along_axis(first.known, columns[:, None], 1)
        right = rows_of(right, columns)
        return build.elementwise("mul", "real", right.shape, spread(factors, right.shape), right)
    blocks = blocks_of(first)
    if blocks is None:
        return over_columns(build, first, right)
    return in_blocks(build, first, blocks, right, is_turned=is_turned)


def _operations(first: Factor, second: Factor, terms: NDArray[Any]) -> int:
    """Number of products and sums, without products with 1."""
    count = int(terms.sum()) + int(np.maximum(terms - 1, 0).sum())
    for factor, times in (
        (first, second.is_used.sum(axis=1)),
        (second, first.is_used.sum(axis=0)[:, None]),
    ):
        if factor.known is not None:
            is_one = np.array([each == ONE for each in factor.known.flat], bool)
            count -= int((is_one.reshape(factor.known.shape) * times).sum())
    return count


def _written(
    build: Builder, first: Factor, second: Factor, shape: tuple[int, ...]
) -> Scalars | Data:
    left, right = (objects(build, factor.array) for factor in (first, second))
    sums, group = np.empty(shape, dtype=object), next(build.groups)
    for i, j in np.ndindex(shape):
        pairs = [(a, b) for a, b in zip(left[i], right[:, j], strict=True)]
        sums[i, j] = sum_of_products(build, [pair for pair in pairs if ZERO not in pair], group)
    return joined(sums)


RULES: dict[str, Callable[..., Array | Sequence[Array]]] = {"dot_general": _dot}
"""Primitive -> (builder, operands) -> result."""
