"""Comparison of two traces of one function: operations, parameters and constants.

The text of a jaxpr has no values of its constant arrays, and its names of variables are of no
importance; here, variables are compared by the operations that compute them.
"""

from collections.abc import Callable, Iterable, Iterator
from hashlib import sha256
from itertools import count, zip_longest
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import Tracer, jax
from gyrostat.core.random_keys import is_random_key


class Difference(NamedTuple):
    """First difference between two traces.

    Attributes:
        found: What the first trace has there, for a message.
        other: What the second trace has there.
        equation: Equation of the first trace; None for a difference in the results.
    """

    found: str
    other: str
    equation: Any


class Operation(NamedTuple):
    """Operation of an outline.

    Attributes:
        digest: Digest of its name, operands, other parameters and types of results, without inner
            operations.
        name: Name of its primitive.
        operands: Texts of its constant operands, for a message.
        inner: Outlines of the jaxprs that it executes.
        equation: Its equation; None for the results of the trace, and in another process.
    """

    digest: str
    name: str
    operands: tuple[str | None, ...]
    inner: "tuple[Outline, ...]" = ()
    equation: Any = None


class Outline(NamedTuple):
    """What two traces of one function have in common, also in two processes.

    Attributes:
        digest: Digest of the operations.
        operations: Operations in their order, with the results of the trace as the last one.
    """

    digest: str
    operations: tuple[Operation, ...]


def outline_of(closed: Any, *, same_run: bool = False, equations: bool = True) -> Outline:
    """Outline of a closed jaxpr.

    Args:
        closed: Closed jaxpr.
        same_run: See `first_difference`.
        equations: Whether the operations have their equations; an outline without can be pickled.
    """
    outlines: dict[int, Outline] = {}  # a large trace calls the same few jaxprs many times

    def outline(closed: Any) -> Outline:
        if id(closed) not in outlines:
            operations = tuple(_operations(closed, same_run, outline, equations=equations))
            parts = [(each.digest, *(inner.digest for inner in each.inner)) for each in operations]
            outlines[id(closed)] = Outline(_digest(parts), operations)
        return outlines[id(closed)]

    return outline(closed)


def first_difference(one: Any, other: Any, *, same_run: bool = False) -> Difference | None:
    """First difference between two closed jaxprs; None if they are equal.

    Args:
        one: Closed jaxpr.
        other: Closed jaxpr of the same function.
        same_run: Whether both were traced inside one trace of a larger function; its values are
            then compared by identity, and otherwise by shape and type only.
    """
    if one is other:
        return None
    return difference_of(*(outline_of(each, same_run=same_run) for each in (one, other)))


def difference_of(one: Outline, other: Outline) -> Difference | None:
    """First difference between two outlines; None if they are equal."""
    if one.digest == other.digest:
        return None
    for first, second in zip_longest(one.operations, other.operations):
        if first is None or second is None or first.digest != second.digest:
            equation = next(each.equation for each in (first, second) if each is not None)
            return Difference(_description(first, second), _description(second, first), equation)
        difference = next(filter(None, map(difference_of, first.inner, second.inner)), None)
        if difference is not None:
            return difference
    return None


def _digest(content: Any) -> str:
    return sha256(repr(content).encode()).hexdigest()


def _operations(
    closed: Any, same_run: bool, outline: Callable[[Any], Outline], *, equations: bool
) -> Iterator[Operation]:
    """Operations of a jaxpr in their order; then its results."""
    jaxpr, consts = getattr(closed, "jaxpr", closed), getattr(closed, "consts", ())
    numbers = count()
    labels: dict[Any, Any] = {variable: next(numbers) for variable in jaxpr.invars}
    labels |= {
        variable: _value(value, same_run)
        for variable, value in zip(jaxpr.constvars, consts, strict=False)
    }

    def operand(atom: Any) -> Any:
        value = getattr(atom, "val", None)  # of a literal
        return labels.get(atom) if value is None else _value(value, same_run)

    def operation(name: str, atoms: Iterable[Any], signature: Any = (), *fields: Any) -> Operation:
        operands = [operand(atom) for atom in atoms]
        texts = tuple(each.shown if isinstance(each, _Value) else None for each in operands)
        return Operation(_digest((name, operands, signature)), name, texts, *fields)

    for equation in jaxpr.eqns:
        name, params = equation.primitive.name, equation.params
        inner = tuple(map(outline, _inner(params.values())))
        results = [str(atom.aval) for atom in equation.outvars]
        signature = _plain(params, same_run), results, len(inner)
        yield operation(name, equation.invars, signature, inner, equation if equations else None)
        labels.update((atom, next(numbers)) for atom in equation.outvars)
    yield operation("result", jaxpr.outvars)


def _inner(parameters: Iterable[Any]) -> Iterator[Any]:
    """Jaxprs among the parameters of an operation."""
    for value in parameters:
        if isinstance(value, list | tuple):
            yield from _inner(value)
        elif hasattr(getattr(value, "jaxpr", value), "eqns"):
            yield value


class _Value(NamedTuple):
    """Constant of a trace, compared by its bytes.

    Attributes:
        type: Type and shape.
        content: Digest of its bytes; for a value of an outer trace, its identity or nothing.
        shown: Text for a message.
    """

    type: str
    content: Any
    shown: str


def _value(value: Any, same_run: bool) -> _Value:
    if isinstance(value, Tracer):
        return _Value(str(value.aval), id(value) if same_run else None, "a value of the run")
    dtype = getattr(value, "dtype", None)
    if is_random_key(value):
        value = jax.random.key_data(value)
    array = np.asarray(value)
    text = ", ".join(map(repr, array.ravel()[:3].tolist())) + (", ..." if array.size > 3 else "")
    content = sha256(array.tobytes()).hexdigest()
    return _Value(f"{dtype}{array.shape}", content, text)


def _plain(value: Any, same_run: bool) -> Any:
    """Parameter of an operation, without inner jaxprs, and functions by their types only."""
    if isinstance(value, dict):
        return tuple((str(key), _plain(entry, same_run)) for key, entry in value.items())
    if isinstance(value, list | tuple):
        return tuple(_plain(entry, same_run) for entry in value)
    if isinstance(value, np.ndarray | np.generic | jax.Array):
        return _value(value, same_run)
    if value is None or isinstance(value, str | bytes | bool | int | float | complex | np.dtype):
        return repr(value)
    return type(value).__qualname__


def _description(operation: Operation | None, counterpart: Operation | None) -> str:
    """Operation for a message: its constants, if only these differ from the other one."""
    if operation is None:
        return "no further operation"
    if counterpart is not None and counterpart.name == operation.name:
        for text, other_text in zip_longest(operation.operands, counterpart.operands):
            if text is not None and text != other_text:
                return text
    return f"the operation {operation.name}"
