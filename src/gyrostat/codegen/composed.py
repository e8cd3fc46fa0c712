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
    return (x < y) | ((x == x) & (y != y))


def _shifted_right(x: Any, bits: Any) -> Any:
    """Arithmetic right shift, which C leaves to the compiler: division, rounded down."""
    if not jnp.issubdtype(x.dtype, jnp.signedinteger):
        raise NotImplementedError
    size = 8 * x.dtype.itemsize
    quotient = jnp.floor_divide(x, jnp.left_shift(jnp.ones_like(x), jnp.clip(bits, 0, size - 2)))
    beyond = (bits < 0) | (bits > size - 2)
    return jnp.where(beyond, jnp.where(x < 0, -1, 0).astype(x.dtype), quotient)


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


def _running_logarithm(x: Any, *, axis: int, reverse: bool) -> Any:
    return jax.lax.associative_scan(jnp.logaddexp, x, axis=axis, reverse=reverse)


COMPOSED: dict[str, Callable[..., Any]] = {
    **linear_algebra.COMPOSED,
    **jacobi.COMPOSED,
    "conv_general_dilated": _convolved,
    "cumlogsumexp": _running_logarithm,
    "le_to": lambda x, y: ~_below(y, x),
    "lt_to": _below,
    "shift_right_arithmetic": _shifted_right,
    # since JAX 0.11
    "log2": lambda x, **_: jnp.log(x) * (1.0 / math.log(2.0)),
    "one_minus_square": lambda x: (1.0 + x) * (1.0 - x),
    "polynomial": _polynomial,
}
"""Primitive -> function of its operands and parameters, of the operations it is compiled as."""

_traced: dict[Any, Any] = {}


def expanded(equation: Any) -> Any | None:
    """Closed jaxpr of the simpler operations that a composed primitive of JAX stands for.

    Args:
        equation: Equation.

    Returns:
        The jaxpr, with the operands of the equation as arguments; None for other primitives.
    """
    name, params = equation.primitive.name, equation.params
    composed = COMPOSED.get(name)
    # since JAX 0.12: sums by indices, searches and others carry their own expansion
    expand = getattr(params.get("_prim"), "expand", composed and partial(composed, **params))
    is_looped = name in linear_algebra.ELIMINATION and (
        max(equation.invars[0].aval.shape[-2:]) > linear_algebra.SMALL
    )
    if expand is None or is_looped:
        return None
    operands = [jax.ShapeDtypeStruct(a.aval.shape, a.aval.dtype) for a in equation.invars]
    if composed is None:
        return jax.make_jaxpr(expand)(*operands)
    try:
        # the same factorisation often comes again: tracing one takes longer than lowering it
        key = name, str(params), *((operand.shape, operand.dtype) for operand in operands)
        if key not in _traced:
            _traced[key] = jax.make_jaxpr(expand)(*operands)
    except NotImplementedError:
        return None
    return _traced[key]
