"""From a function to its jaxpr and the Python lines it comes from.

Whatever JAX does not promise to keep is used in this module and in no other: the primitives' names
and parameters are met in `primitives`, `lower` and `control_flow`, and are only read there.
"""

import ast
import functools
import linecache
import os
import sysconfig
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import equinox
import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat.errors import InputError

_LIBRARIES = tuple(
    str(Path(place).resolve()) + os.sep
    for place in (
        Path(jax.__file__).parent,
        Path(equinox.__file__).parent,
        Path(np.__file__).parent,
        sysconfig.get_path("stdlib"),
    )
)
_CALLS = {
    "jit": "jaxpr",
    "pjit": "jaxpr",
    "closed_call": "call_jaxpr",
    "custom_jvp_call": "call_jaxpr",
    "custom_vjp_call": "call_jaxpr",
}
"""Primitives that only call another jaxpr -> the parameter that holds it."""


class Source(NamedTuple):
    """A line of Python.

    Attributes:
        file: from its package on, as gyrostat/control/attitude_pid.py; no folder of a machine.
        line: number.
        text: of the line, without blanks around it.
        name: what the line gives a value to, or the function that it returns from; "" for neither.
    """

    file: str
    line: int
    text: str
    name: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


NOWHERE = Source("", 0, "", "")


@dataclass(frozen=True)
class Trace:
    """A traced function.

    Attributes:
        jaxpr: its operations, a `jax.extend.core.ClosedJaxpr`.
        results: what it returns, with shapes in place of arrays.
    """

    jaxpr: Any
    results: Any


def as_arrays(tree: Any) -> Any:
    """A tree with every number as an array, so that none is compiled in.

    Raises:
        InputError: a leaf is no number.
    """
    try:
        return jax.tree.map(jnp.asarray, tree)
    except TypeError as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"tree: found a leaf that is no number ({reason})") from None


def trace(function: Callable[..., Any], arguments: Sequence[Any], name: str) -> Trace:
    """Trace a function twice and see that it is a function.

    Args:
        function: of trees of arrays, to a tree of arrays.
        arguments: examples of its arguments.
        name: for messages.

    Raises:
        InputError: it needs values where only shapes are known, as a shape or a Python `if` that
            depends on data does; it has a side effect; it differs from one call to the next.
    """
    arguments = as_arrays(tuple(arguments))
    found = []
    for _ in range(2):
        try:
            with jax.checking_leaks():
                # a function object of its own: JAX would else remember the first trace
                traced, results = jax.make_jaxpr(
                    lambda *given: as_arrays(function(*given)), return_shape=True
                )(*arguments)
        except InputError:
            raise
        except Exception as error:
            raise InputError(f"{_raised_at(error) or name}: {_reason(error)}") from error
        found.append(Trace(traced, results))
    refuse_effects(found[0].jaxpr.jaxpr, NOWHERE)
    first, second = (str(trace.jaxpr) for trace in found)
    if first != second:
        raise InputError(
            f"{name}: found another trace in its second call, expected no side effect: state is "
            "an argument and a result"
        )
    return found[0]


def refuse_effects(jaxpr: Any, called_at: Source) -> None:
    """Refuse callbacks, prints and the like, with the line of the first.

    Args:
        jaxpr: what to look through.
        called_at: line that stands for what a library does.

    Raises:
        InputError: as said.
    """
    for equation in jaxpr.eqns:
        if equation.effects:
            where = source(equation, called_at)
            for inner in inner_jaxprs(equation):
                refuse_effects(inner, where)
            what = "an effect on the outside"
            raise refused(equation, where, what, "none: flight code has no Python")


def inner_jaxprs(equation: Any) -> list[Any]:
    """The jaxprs among an equation's parameters, without their constants."""
    every = []
    for value in equation.params.values():
        for item in value if isinstance(value, tuple | list) else (value,):
            inner = getattr(item, "jaxpr", item)
            if hasattr(inner, "eqns"):
                every.append(inner)
    return every


def called(equation: Any) -> Any | None:
    """The closed jaxpr that an equation only calls; None where it does something itself."""
    parameter = _CALLS.get(equation.primitive.name)
    inner = equation.params.get(parameter)
    if inner is None or not hasattr(inner, "consts"):
        return None
    return inner


def own_function(equation: Any, inner: Any) -> str | None:
    """Name of a jitted function that is not one of the libraries' own; None for those."""
    if equation.primitive.name not in ("jit", "pjit"):
        return None
    where = getattr(getattr(inner.jaxpr, "debug_info", None), "func_src_info", None) or ""
    file = where.partition(" at ")[2].rpartition(":")[0]
    if not file or _in_library(file):
        return None
    name = str(equation.params["name"]).strip("_")
    return name if name.isidentifier() else None


def constant(atom: Any) -> Any | None:
    """The value of a literal; None for a variable."""
    return getattr(atom, "val", None)


def source(equation: Any, otherwise: Source) -> Source:
    """The innermost line of Python that an equation comes from and that is no library's."""
    found = equation.source_info.traceback
    for frame in found.frames if found is not None else ():
        if not _in_library(frame.file_name):
            return _source(frame.file_name, frame.line_num)
    return otherwise


def refused(equation: Any, where: Source, what: str, expected: str) -> InputError:
    """The error for an equation that has no place in flight code."""
    return InputError(f"{where}: found {what} ({equation.primitive.name}), expected {expected}")


@functools.cache
def _in_library(file: str) -> bool:
    return file.startswith("<") or str(Path(file).resolve()).startswith(_LIBRARIES)


@functools.cache
def _source(file: str, line: int) -> Source:
    path = Path(file)
    shown = path.name
    # from the outermost package on
    while (path.parent / "__init__.py").exists():
        path = path.parent
        shown = f"{path.name}/{shown}"
    return Source(shown, line, linecache.getline(file, line).strip(), _named_at(file).get(line, ""))


@functools.cache
def _named_at(file: str) -> dict[int, str]:
    """Line -> the name that it gives a value to: an assignment's, an argument's, a function's."""
    try:
        tree = ast.parse("".join(linecache.getlines(file)))
    except SyntaxError:
        return {}
    spans: list[tuple[int, bool, int, str]] = []

    def visit(node: ast.AST, function: str) -> None:
        for child in ast.iter_child_nodes(node):
            name = ""
            match child:
                case ast.Assign(targets=[ast.Name(id=name)]):
                    pass
                case ast.AnnAssign(target=ast.Name(id=name)):
                    pass
                case ast.AugAssign(target=ast.Name(id=name)):
                    pass
                case ast.Return():
                    name = function
                case ast.keyword(arg=str(argument), value=value):
                    # strict=True and the like name no result
                    name = "" if isinstance(value, ast.Constant) else argument
            if name and isinstance(child, ast.stmt | ast.keyword):
                more = (child.end_lineno or child.lineno) - child.lineno
                spans.append((more, isinstance(child, ast.keyword), child.lineno, name))
            inner = isinstance(child, ast.FunctionDef) and child.name
            visit(child, inner or function)

    visit(tree, "")
    named: dict[int, str] = {}
    # the shortest span of lines wins, a statement over an argument
    for more, _, first, name in sorted(spans):
        for line in range(first, first + more + 1):
            named.setdefault(line, name.strip("_"))
    return named


def _raised_at(error: BaseException) -> Source | None:
    places = [
        frame
        for frame in traceback.extract_tb(error.__traceback__)
        if not _in_library(frame.filename) and not frame.filename.startswith(_OWN)
    ]
    return _source(places[-1].filename, places[-1].lineno or 0) if places else None


_OWN = str(Path(__file__).parent) + os.sep


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
