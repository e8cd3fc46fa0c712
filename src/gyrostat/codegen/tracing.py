"""Trace a function to its jaxpr, with the Python line of each operation.

The names and parameters of the primitives also appear in `primitives`, `lower` and `control_flow`,
where they are only read; what differs between versions of JAX is in `jax_versions`.
"""

import os
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gyrostat.codegen.composed import expanded
from gyrostat.codegen.jax_versions import closed, require_supported
from gyrostat.codegen.source import NOWHERE, Source, in_library, refused, source, source_at
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

_OWN = str(Path(__file__).parent) + os.sep
CALLS = {
    "jit": "jaxpr",
    "pjit": "jaxpr",
    "closed_call": "call_jaxpr",
    "custom_jvp_call": "call_jaxpr",
    "custom_vjp_call": "call_jaxpr",
    "custom_vmap_call": "call",
    "remat2": "jaxpr",
}
"""Primitive that only calls another jaxpr -> parameter that holds the jaxpr."""


@dataclass(frozen=True)
class Trace:
    """Traced function.

    Attributes:
        jaxpr: Operations, a `jax.extend.core.ClosedJaxpr`.
        results: Tree of results, with shapes in place of arrays.
    """

    jaxpr: Any
    results: Any


def as_arrays(tree: Any) -> Any:
    """Tree with every number as an array, so that no number is compiled in as a constant.

    Raises:
        InputError: A leaf is not a number.
    """
    try:
        return jax.tree.map(jnp.asarray, tree)
    except TypeError as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"tree: found a leaf that is no number ({reason})") from None


def trace(function: Callable[..., Any], arguments: Sequence[Any], name: str) -> Trace:
    """Trace a function twice and check that it is pure.

    Args:
        function: Function of trees of arrays that returns a tree of arrays.
        arguments: Example arguments.
        name: Name of the function for messages.

    Raises:
        InputError: The function needs values where only shapes are known, for example in a shape
            or a Python `if` that depends on data; it has a side effect; its trace differs from one
            call to the next; or the version of JAX is not supported.
    """
    require_supported()
    arguments = as_arrays(tuple(arguments))
    traces = []
    for _ in range(2):
        try:
            with jax.checking_leaks():
                # a new function object: otherwise JAX reuses the first trace
                jaxpr, results = jax.make_jaxpr(
                    lambda *inputs: as_arrays(function(*inputs)), return_shape=True
                )(*arguments)
        except InputError:
            raise
        except Exception as error:
            raise InputError(f"{_error_line(error) or name}: {_reason(error)}") from error
        traces.append(Trace(jaxpr, results))
    refuse_effects(traces[0].jaxpr.jaxpr, NOWHERE)
    first, second = (str(trace.jaxpr) for trace in traces)
    if first != second:
        raise InputError(
            f"{name}: found another trace in its second call, expected no side effect: state is "
            "an argument and a result"
        )
    return traces[0]


def refuse_effects(jaxpr: Any, called_at: Source) -> None:
    """Check that a jaxpr has no callbacks, prints or other side effects.

    Args:
        jaxpr: Jaxpr to search.
        called_at: Line reported for operations inside a library.

    Raises:
        InputError: The jaxpr has a side effect.
    """
    for equation in jaxpr.eqns:
        if equation.effects:
            where = source(equation, called_at)
            for inner in inner_jaxprs(equation):
                refuse_effects(inner, where)
            what = "an effect on the outside"
            raise refused(equation, where, what, "none: flight code has no Python")


def inner_jaxprs(equation: Any) -> list[Any]:
    """Jaxprs among the parameters of an equation, without their constants."""
    jaxprs = []
    for value in equation.params.values():
        for item in value if isinstance(value, tuple | list) else (value,):
            inner = getattr(item, "jaxpr", item)
            if hasattr(inner, "eqns"):
                jaxprs.append(inner)
    return jaxprs


def called(equation: Any) -> Any | None:
    """Closed jaxpr that an equation only calls; None if the equation is an operation itself."""
    parameter = CALLS.get(equation.primitive.name)
    return closed(equation.params[parameter], ()) if parameter else expanded(equation)


def is_own(equation: Any, inner: Any) -> bool:
    """Whether an equation calls a function of the user or of this package, not of a library."""
    where = getattr(getattr(inner.jaxpr, "debug_info", None), "func_src_info", None) or ""
    file = where.partition(" at ")[2].rpartition(":")[0]
    return equation.primitive.name in CALLS and bool(file) and not in_library(file)


def own_function(equation: Any, inner: Any) -> str | None:
    """Name of a jitted function of the user or of this package; None for those of a library."""
    if equation.primitive.name not in ("jit", "pjit") or not is_own(equation, inner):
        return None
    name = str(equation.params["name"]).strip("_")
    return name if name.isidentifier() else None


def constant(atom: Any) -> Any | None:
    """Value of a literal; None for a variable."""
    return getattr(atom, "val", None)


def _error_line(error: BaseException) -> Source | None:
    frames = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if not in_library(frame.filename) and not frame.filename.startswith(_OWN)
    ]
    return source_at(frames[-1].filename, frames[-1].lineno or 0) if frames else None


def _reason(error: Exception) -> str:
    if isinstance(error, jax.errors.NonConcreteBooleanIndexError):
        return "found a shape that depends on data, expected shapes known beforehand"
    if isinstance(error, jax.errors.JAXTypeError):
        return (
            "found Python that needs the value of an input (a shape, an index or an `if`), "
            "expected shapes known beforehand and `jnp.where` or `jax.lax.cond`"
        )
    if isinstance(error, jax.errors.UnexpectedTracerError) or "Leaked" in str(error):
        return "found a value kept from an earlier call, expected no side effect"
    return f"found {type(error).__name__} ({str(error).splitlines()[0]}), expected a traceable step"
