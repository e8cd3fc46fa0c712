"""Primitives of JAX that stand for several simpler operations."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from gyrostat.codegen import jacobi, linear_algebra
from gyrostat.core.jax64 import jax, jnp


def _polynomial(x: Any, *coefficients: Any, **_: Any) -> Any:
    total = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        total = total * x + coefficient
    return total


def _below(x: Any, y: Any) -> Any:
    """Order of numbers with NaN last, for which JAX's sorting has made zeros and NaN alike."""
    if not jnp.issubdtype(x.dtype, jnp.floating):
        return x < y
    return (x < y) | ((x == x) & (y != y))


def _shifted_right(x: Any, bits: Any) -> Any:
    """Arithmetic right shift, which C leaves to the compiler: division, rounded down."""
    if not jnp.issubdtype(x.dtype, jnp.signedinteger):
        raise NotImplementedError
    size = 8 * x.dtype.itemsize
    quotient = jnp.floor_divide(x, jnp.left_shift(jnp.ones_like(x), jnp.clip(bits, 0, size - 2)))
    beyond = (bits < 0) | (bits > size - 2)
    return jnp.where(beyond, jnp.where(x < 0, -1, 0).astype(x.dtype), quotient)


def _next_after(x: Any, y: Any) -> Any:
    """Neighbouring number towards another one."""
    bits = jax.lax.bitcast_convert_type(x, jnp.int64)
    outwards = (x < y) == (x > 0.0)
    step = jax.lax.bitcast_convert_type(bits + jnp.where(outwards, 1, -1), x.dtype)
    least = jnp.where(y > 0.0, 5e-324, -5e-324)
    step = jnp.where(x == 0.0, least, step)
    return jnp.where(x == y, y, jnp.where((x != x) | (y != y), x + y, step))


def _mantissa_and_exponent(x: Any, **_: Any) -> tuple[Any, Any]:
    """Mantissa from 0.5 to 1 and exponent of 2; both 0 for subnormal numbers, as in JAX 0.12."""
    bits = jax.lax.bitcast_convert_type(x, jnp.int64)
    exponent = jnp.right_shift(bits, 52) & 2047
    is_zero, is_number = exponent == 0, exponent < 2047
    normal = (bits & ~(2047 << 52)) | (1022 << 52)
    zero = bits & -(1 << 63)
    mantissa = jax.lax.bitcast_convert_type(jnp.where(is_zero, zero, normal), x.dtype)
    exponent = jnp.where(is_zero | jnp.logical_not(is_number), 0, exponent - 1022)
    return jnp.where(is_number, mantissa, x), exponent.astype(jnp.int32)


def _shifted_logically(x: Any, bits: Any) -> Any:
    """Right shift of int32 that moves in zeros, by 64 bits; that of other types is a rule."""
    if x.dtype != jnp.int32:
        raise NotImplementedError
    word = x.astype(jnp.int64) & (2**32 - 1)
    shifted = jax.lax.shift_right_logical(word, jnp.clip(bits, -1, 32).astype(jnp.int64))
    return shifted.astype(jnp.int32)


def _convolved(x: Any, kernel: Any, **params: Any) -> Any:
    """Convolution along one axis, as of `jnp.convolve`: sums of products, from first to last."""
    layout = params["dimension_numbers"]
    ones = *params["lhs_dilation"], *params["rhs_dilation"]
    groups = params["feature_group_count"], params["batch_group_count"]
    if any(spec != (0, 1, 2) for spec in layout) or {*ones, *groups} != {1}:
        raise NotImplementedError
    (stride,), (padding,) = params["window_strides"], params["padding"]
    x = jax.lax.pad(x, jnp.zeros((), x.dtype), ((0, 0, 0), (0, 0, 0), (*padding, 0)))
    width = kernel.shape[-1]
    starts = range(0, x.shape[-1] - width + 1, stride)
    if not starts:
        raise NotImplementedError
    windows = jnp.stack([x[:, :, k : k + width] for k in starts], axis=2)
    return jnp.einsum("nctk,ock->not", windows, kernel)


def _power(x: Any, y: Any) -> Any:
    """Real power with an exponent that is an integer and not constant."""
    if not jnp.issubdtype(y.dtype, jnp.integer):
        raise NotImplementedError
    return jax.lax.pow(x, y.astype(x.dtype))


def _as_double(x: Any, *, exponent_bits: int, mantissa_bits: int) -> Any:
    """A number in a format that holds all of double precision."""
    if exponent_bits < 11 or mantissa_bits < 52:
        raise NotImplementedError
    return x


def _running_logarithm(x: Any, *, axis: int, reverse: bool) -> Any:
    return jax.lax.associative_scan(jnp.logaddexp, x, axis=axis, reverse=reverse)


def _preferred(candidates: Any, better: Any) -> Any:
    """Those candidates along the first axis that are better; all of them if none is."""
    both = candidates & better
    return jnp.where(jnp.any(both, axis=0), both, candidates)


def _largest(x: Any, *, k: int, axis: int = -1, **_: Any) -> tuple[Any, Any]:
    """The k largest elements and their indices, one after the other; the first of equal ones.

    As in JAX, NaN is above all numbers and 0 above -0; here also a NaN with the sign bit, which JAX
    puts below them.
    """
    if x.dtype == jnp.bool_:
        values, indices = _largest(x.astype(jnp.int64), k=k, axis=axis)
        return values != 0, indices
    rows = jnp.moveaxis(x, axis, 0)
    index = jnp.arange(len(rows), dtype=jnp.int32).reshape(-1, *[1] * (x.ndim - 1))
    is_real = jnp.issubdtype(x.dtype, jnp.floating)
    least = -jnp.inf if is_real else jnp.iinfo(x.dtype).min
    least = jnp.asarray(least, x.dtype)

    def step(remaining: Any, _: Any) -> Any:
        candidates: Any = remaining
        numbers = rows
        if is_real:
            candidates = _preferred(candidates, rows != rows)
            numbers = jnp.where(rows != rows, 0.0, rows)
        candidates &= numbers == jnp.max(jnp.where(candidates, numbers, least), axis=0)
        if is_real:
            candidates = _preferred(candidates, (numbers != 0.0) | (1.0 / numbers > 0.0))
        best = jnp.argmax(candidates, axis=0).astype(jnp.int32)
        value = jnp.max(jnp.where(index == best, rows, least), axis=0)
        return remaining & (index != best), (value, best)

    start = jnp.ones(rows.shape, bool)
    results: Any = jax.lax.scan(step, start, None, length=k)[1]
    values, indices = results
    return jnp.moveaxis(values, 0, axis), jnp.moveaxis(indices, 0, axis)


def _product(x: Any, y: Any, **params: Any) -> Any:
    """Product of arrays of integers; that of real numbers is a rule of its own."""
    is_integer = jnp.issubdtype(x.dtype, jnp.integer)
    if not is_integer or not x.dtype == y.dtype == params["preferred_element_type"]:
        raise NotImplementedError

    def rows(array: Any, axes: Any, batch: Any) -> Any:
        free = [k for k in range(array.ndim) if k not in (*axes, *batch)]
        shape = [[array.shape[k] for k in group] for group in (batch, free, axes)]
        return array.transpose([*batch, *free, *axes]).reshape([math.prod(s) for s in shape]), shape

    (left, shape), (right, right_shape) = map(rows, (x, y), *params["dimension_numbers"])
    sums = jnp.sum(left[:, :, None] * right[:, None], axis=-1, dtype=x.dtype)
    return sums.reshape([*shape[0], *shape[1], *right_shape[1]])


COMPOSED: dict[str, Callable[..., Any]] = {
    **linear_algebra.COMPOSED,
    **jacobi.COMPOSED,
    "conv_general_dilated": _convolved,
    "cumlogsumexp": _running_logarithm,
    "dot_general": _product,
    "empty2": lambda *, dtype, **_: jnp.zeros((), dtype),
    "le_to": lambda x, y: ~_below(y, x),
    "lt_to": _below,
    "nextafter": _next_after,
    "pow": _power,
    "reduce_precision": _as_double,
    "shift_right_arithmetic": _shifted_right,
    "shift_right_logical": _shifted_logically,
    "top_k": _largest,
    # since JAX 0.11
    "log2": lambda x, **_: jnp.log(x) * (1.0 / math.log(2.0)),
    "one_minus_square": lambda x: (1.0 + x) * (1.0 - x),
    "polynomial": _polynomial,
    # since JAX 0.12, whose own expansion has uint64
    "Frexp": _mantissa_and_exponent,
}
"""Primitive, or class of one that carries its own expansion -> function of its operands and
parameters, of the operations it is compiled as."""

_traced: dict[Any, Any] = {}


def expanded(equation: Any) -> Any | None:
    """Closed jaxpr of the simpler operations that a composed primitive of JAX stands for.

    Args:
        equation: Equation.

    Returns:
        The jaxpr, with the operands of the equation as arguments; None for other primitives.
    """
    name, params = equation.primitive.name, equation.params
    # since JAX 0.12: sums by indices, searches and others carry their own expansion
    carried = params.get("_prim")
    composed = COMPOSED.get(name if carried is None else type(carried).__name__)
    expand = partial(composed, **params) if composed else getattr(carried, "expand", None)
    is_looped = name in linear_algebra.ELIMINATION and (
        max(equation.invars[0].aval.shape[-2:]) > linear_algebra.SMALL
    )
    if expand is None or is_looped:
        return None
    operands = [jax.ShapeDtypeStruct(a.aval.shape, a.aval.dtype) for a in equation.invars]
    if composed is None:
        return jax.make_jaxpr(expand)(*operands)
    # the same operation often comes again: tracing one takes longer than lowering it
    key = name, str(params), *((operand.shape, operand.dtype) for operand in operands)
    if key not in _traced:
        try:
            _traced[key] = jax.make_jaxpr(expand)(*operands)
        except NotImplementedError:
            _traced[key] = None
    return _traced[key]
