"""Rules for primitives that need more than one operation for each element."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gyrostat.codegen.arrays import Array, is_plain, joined
from gyrostat.codegen.builder import Builder
from gyrostat.codegen.nests import objects
from gyrostat.codegen.primitives import Scalars, one_by_one
from gyrostat.codegen.program import Number

ONE = np.array(Number("real", 1.0), dtype=object)


def _power(build: Builder, base: Array) -> Array:
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


def _logistic(build: Builder, array: Array) -> Array:
    power = build.apply("exp", build.apply("neg", array))
    return build.apply("div", ONE, build.apply("add", ONE, power))


def _select(build: Builder, which: Array, *cases: Array) -> Array:
    """Select one of several cases by a condition or an index."""
    kind = build.scope.kind(build.equation.invars[0])
    if kind == "logical":
        if build.size > build.scope.few and which.shape and is_plain(which):
            mask = build.scalars(which)
            if all(isinstance(operand, Number) for operand in mask.flat):
                yes, no = (objects(build, each) for each in cases[::-1])
                is_yes = np.vectorize(lambda operand: operand.value, otypes=[bool])(mask)
                return joined(np.where(is_yes, yes, no))
        return build.apply("select", which, cases[1], cases[0])
    which, chosen = build.scalars(which), cases[-1]
    for k in range(len(cases) - 2, -1, -1):
        group, number = next(build.groups), Number(kind, k)
        here = one_by_one(
            which.shape,
            lambda operand: build.compute("le", operand, number, group=group),  # noqa: B023
            which,
        )
        chosen = build.apply("select", here, cases[k], chosen)
    return chosen


def _clamp(build: Builder, low: Array, array: Array, high: Array) -> Array:
    if build.scope.kind(build.target) == "integer":
        scalars = (build.scalars(each) for each in (array, low, high))
        filled = (np.broadcast_to(each, build.shape) for each in scalars)
        return one_by_one(build.shape, build.clamp, *filled)
    return build.apply("min", build.apply("max", low, array), high)


def _convert(build: Builder, array: Array) -> Array:
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
    is_known = isinstance(array, np.ndarray) and all(
        isinstance(each, Number) for each in array.flat
    )
    if before != np.float64 and is_known:
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


def _bitcast(build: Builder, array: Array) -> Array:
    """Number with the bits of another type."""
    before, after = build.equation.invars[0].aval.dtype, build.target.aval.dtype
    if before == after:
        return array
    if np.bool_ in (before, after) or before.itemsize != after.itemsize:
        raise build.refused(f"{before} as {after}", "numbers of as many bits")
    return build.apply(
        build.scope.narrow.get(after) or f"as_{build.scope.kind(build.target)}", array
    )


def _round(build: Builder, array: Array) -> Array:
    to_even = int(build.params["rounding_method"]) == 1
    return build.apply("rint" if to_even else "round", array)


def _iota(build: Builder) -> Scalars:
    every = np.indices(build.params["shape"])[build.params["dimension"]]
    return build.scope.numbers(every.astype(build.params["dtype"]))


def _platform(build: Builder, *_: Any) -> Scalars:
    """Index of the branch for the processor, otherwise of the default branch."""
    platforms = build.params["platforms"]
    for number, names in enumerate(platforms):
        if names is None or "cpu" in names:
            return np.array(Number("integer", number), dtype=object)
    raise build.refused(f"code for {platforms} alone", "code for a processor")


OF_ARRAYS = frozenset(
    {
        *(
            "bitcast_convert_type",
            "clamp",
            "convert_element_type",
            "integer_pow",
            "logistic",
            "round",
            "rsqrt",
        ),
        *("select_n", "square"),
    }
)
"""Primitives whose rules take large arrays as they are."""

ROW_BY_ROW = frozenset({"integer_pow", "logistic", "rsqrt", "select_n", "square"})
"""Primitives whose rules take scalars of rows."""

RULES: dict[str, Callable[..., Array | Sequence[Array]]] = {
    "bitcast_convert_type": _bitcast,
    "clamp": _clamp,
    "convert_element_type": _convert,
    "integer_pow": _power,
    "iota": _iota,
    "logistic": _logistic,
    "platform_index": _platform,
    "round": _round,
    "rsqrt": lambda build, array: build.apply("div", ONE, build.apply("sqrt", array)),
    "select_n": _select,
    "shift_right_logical": lambda build, *given: build.apply("shift_right", *given),
    "square": lambda build, array: build.apply("mul", array, array),
}
"""Primitive -> (builder, operands) -> result."""
