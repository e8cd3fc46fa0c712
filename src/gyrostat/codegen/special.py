"""Rules for primitives that need more than one operation for each element."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np

from gyrostat.codegen.builder import Builder
from gyrostat.codegen.data import Data
from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Number, Operand
from gyrostat.core.jax64 import jax

ONE = np.array(Number("real", 1.0), dtype=object)
ZERO = Number("real", 0.0)
LOOPED = 1000
"""Number of products from which a matrix product is a loop over rows."""


def _power(build: Builder, base: Scalars) -> Scalars:
    """Integer power, by repeated squaring as in XLA."""
    exponent = build.params["y"]
    left, total = abs(exponent), None
    while left:
        if left & 1:
            total = base if total is None else build.apply("mul", total, base)
        left >>= 1
        if left:
            base = build.apply("mul", base, base)
    if total is None:
        return np.broadcast_to(ONE, build.shape)
    return total if exponent > 0 else build.apply("div", ONE, total)


def _logistic(build: Builder, array: Scalars) -> Scalars:
    power = build.apply("exp", build.apply("neg", array))
    return build.apply("div", ONE, build.apply("add", ONE, power))


def _select(build: Builder, which: Scalars, *cases: Scalars) -> Scalars:
    """Select one of several cases by a condition or an index."""
    kind = build.scope.kind(build.equation.invars[0])
    if kind == "logical":
        return build.apply("select", which, cases[1], cases[0])
    chosen = cases[-1]
    for k in range(len(cases) - 2, -1, -1):
        group, number = next(build.groups), Number(kind, k)
        here = one_by_one(
            which.shape,
            lambda operand: build.compute("le", operand, number, group=group),  # noqa: B023
            which,
        )
        chosen = build.apply("select", here, cases[k], chosen)
    return chosen


def _clamp(build: Builder, low: Scalars, array: Scalars, high: Scalars) -> Scalars:
    if build.scope.kind(build.target) == "integer":
        filled = (np.broadcast_to(each, build.shape) for each in (array, low, high))
        return one_by_one(build.shape, build.clamp, *filled)
    return build.apply("min", build.apply("max", low, array), high)


def _convert(build: Builder, array: Scalars) -> Scalars:
    """Type conversion as in XLA: integers wrap around, real numbers saturate."""
    source, target, scope = build.equation.invars[0], build.target, build.scope
    before, after = source.aval.dtype, target.aval.dtype
    kind, narrow = scope.kind(target), scope.narrow.get(after)
    if (before, after) == (np.uint32, np.int32):
        narrow = "to_half"
    if kind == scope.kind(source) and (narrow is None or before == after):
        return array
    if kind == "logical":
        return build.apply("ne", array, np.array(Number(scope.kind(source), 0)))
    if before != np.float64 and all(isinstance(operand, Number) for operand in array.flat):
        values = np.vectorize(lambda operand: operand.value, otypes=[before])(array)
        return scope.numbers(values.astype(after))
    if before not in (np.float64, np.bool_) and narrow is not None:
        return build.apply(narrow, array)
    converted = build.apply(f"to_{kind}", array)
    if before == np.float64 and np.issubdtype(after, np.integer) and after.itemsize < 8:
        limits = np.iinfo(after)
        converted = build.apply("max", converted, np.array(Number(kind, int(limits.min))))
        converted = build.apply("min", converted, np.array(Number(kind, int(limits.max))))
    return converted


def _round(build: Builder, array: Scalars) -> Scalars:
    to_even = int(build.params["rounding_method"]) == 1
    return build.apply("rint" if to_even else "round", array)


def _iota(build: Builder) -> Scalars:
    every = np.indices(build.params["shape"])[build.params["dimension"]]
    return build.scope.numbers(every.astype(build.params["dtype"]))


def _dot(build: Builder, first: Scalars, second: Scalars) -> Scalars | Sequence[Scalars | Data]:
    """Sums of products, added from first to last, without those with a constant zero.

    A zero of a matrix means that two quantities have nothing to do with each other: NaN and
    infinity do not spread through it.
    """
    (left_axes, right_axes), (left_batch, right_batch) = build.params["dimension_numbers"]
    if any(operand.aval.dtype != np.float64 for operand in build.equation.invars):
        raise build.refused("operands of other types", "float64 ones")

    def rows(array: Scalars, batch: Sequence[int], axes: Sequence[int]) -> Scalars:
        free = [k for k in range(array.ndim) if k not in (*batch, *axes)]
        counts = [int(np.prod([array.shape[k] for k in group])) for group in (batch, free, axes)]
        return array.transpose([*batch, *free, *axes]).reshape(counts)

    left, right = rows(first, left_batch, left_axes), rows(second, right_batch, right_axes)
    passes = left.shape[1] if len(left) == 1 else 0
    is_large = 1 < passes <= build.scope.longest and passes * right.size > LOOPED
    if is_large and not _has_numbers(left, right):
        shapes = [jax.ShapeDtypeStruct(each.shape[1:], np.float64) for each in (left, right)]
        (product,) = build.lower(_product(*shapes), [left[0], right[0]], build.block, build.where)
        return build.scalars(product).reshape(build.shape)
    sums = np.empty((len(left), left.shape[1], right.shape[1]), dtype=object)
    group = next(build.groups)
    for b, i, j in np.ndindex(sums.shape):
        terms: list[Operand] = [
            build.compute("mul", *pair, group=group)
            for pair in zip(left[b, i], right[b, j], strict=True)
            if ZERO not in pair
        ]
        sums[b, i, j] = build.fold("add", terms) if terms else ZERO
    return sums.reshape(build.shape)


def _has_numbers(*arrays: Scalars) -> bool:
    """Whether some elements are constants, which save operations where all are written out."""
    return any(isinstance(operand, Number) for array in arrays for operand in array.flat)


@cache
def _product(left: jax.ShapeDtypeStruct, right: jax.ShapeDtypeStruct) -> Any:
    """Closed jaxpr of the product of two arrays of rows, a loop over those of the first."""

    def product(left: Any, right: Any) -> Any:
        return jax.lax.scan(lambda _, row: (None, right @ row), None, left)[1]

    return jax.make_jaxpr(product)(left, right)


def _reduction(operation: str) -> Callable[..., Scalars]:
    """Rule for a reduction along some axes, from the first element to the last."""

    def rule(build: Builder, array: Scalars) -> Scalars:
        axes = build.params["axes"]
        kept = [axis for axis in range(array.ndim) if axis not in axes]
        count = int(np.prod([array.shape[k] for k in axes]))
        rows = array.transpose([*kept, *axes]).reshape([*(array.shape[k] for k in kept), count])
        made = np.empty(rows.shape[:-1], dtype=object)
        for place in np.ndindex(made.shape):
            made[place] = build.fold(operation, list(rows[place]))
        return made

    return rule


def _platform(build: Builder, *_: Any) -> Scalars:
    """Index of the branch for the processor, otherwise of the default branch."""
    platforms = build.params["platforms"]
    for number, names in enumerate(platforms):
        if names is None or "cpu" in names:
            return np.array(Number("integer", number), dtype=object)
    raise build.refused(f"code for {platforms} alone", "code for a processor")


def _shifted(build: Builder, *given: Scalars) -> Scalars:
    """Logical right shift: zeros are shifted in."""
    if build.target.aval.dtype == np.int32:
        raise build.refused("a shift of int32", "one of int64 or an unsigned type")
    return build.apply("shift_right", *given)


RULES: dict[str, Callable[..., Scalars | Sequence[Scalars | Data]]] = {
    "clamp": _clamp,
    "convert_element_type": _convert,
    "dot_general": _dot,
    "integer_pow": _power,
    "iota": _iota,
    "logistic": _logistic,
    "platform_index": _platform,
    "reduce_and": _reduction("and"),
    "reduce_max": _reduction("max"),
    "reduce_min": _reduction("min"),
    "reduce_or": _reduction("or"),
    "reduce_prod": _reduction("mul"),
    "reduce_sum": _reduction("add"),
    "reduce_xor": _reduction("xor"),
    "round": _round,
    "rsqrt": lambda build, array: build.apply("div", ONE, build.apply("sqrt", array)),
    "select_n": _select,
    "shift_right_logical": _shifted,
    "square": lambda build, array: build.apply("mul", array, array),
}
"""Primitive -> (builder, operands) -> result."""
