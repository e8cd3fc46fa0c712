"""Comparison of two traces of one function: operations, parameters and constants.

The text of a jaxpr has no values of its constant arrays, and its names of variables are of no
importance; here, variables are compared by the operations that compute them.
"""

from collections.abc import Iterable, Iterator
from itertools import count, starmap, zip_longest
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import Tracer, jax, jnp


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


def first_difference(one: Any, other: Any, *, same_run: bool = False) -> Difference | None:
    """First difference between two closed jaxprs; None if they are equal.

    Args:
        one: Closed jaxpr.
        other: Closed jaxpr of the same function.
        same_run: Whether both were traced inside one trace of a larger function; its values are
            then compared by identity, and otherwise by shape and type only.
    """
    equal: set[tuple[int, int]] = set()  # a large trace calls the same few jaxprs many times

    def compare(one: Any, other: Any) -> Difference | None:
        pair = id(one), id(other)
        if one is other or pair in equal:
            return None
        for first, second in zip_longest(_operations(one, same_run), _operations(other, same_run)):
            if first is None or second is None or first[:3] != second[:3]:
                equation = (first or second or (None,))[-1]
                return Difference(_described(first, second), _described(second, first), equation)
            inner = zip(_inner_of(first), _inner_of(second), strict=False)
            found = next(filter(None, starmap(compare, inner)), None)
            if found is not None:
                return found
        equal.add(pair)
        return None

    return compare(one, other)


Operation = tuple[str, tuple[Any, ...], Any, Any]
"""Name of a primitive, its operands, its other parameters and results, and its equation."""


def _operations(closed: Any, same_run: bool) -> Iterator[Operation]:
    """Operations of a jaxpr in their order, without those of inner ones; then its results."""
    jaxpr, consts = getattr(closed, "jaxpr", closed), getattr(closed, "consts", ())
    numbers = count()
    known: dict[Any, Any] = {variable: next(numbers) for variable in jaxpr.invars}
    known |= {
        variable: _value(value, same_run)
        for variable, value in zip(jaxpr.constvars, consts, strict=False)
    }

    def operand(atom: Any) -> Any:
        value = getattr(atom, "val", None)  # of a literal
        return known.get(atom) if value is None else _value(value, same_run)

    for equation in jaxpr.eqns:
        results = tuple(str(atom.aval) for atom in equation.outvars)
        inner = sum(1 for _ in _inner(equation.params.values()))
        plain = _plain(equation.params, same_run), results, inner
        yield equation.primitive.name, tuple(map(operand, equation.invars)), plain, equation
        known.update((atom, next(numbers)) for atom in equation.outvars)
    yield "result", tuple(map(operand, jaxpr.outvars)), None, None


def _inner_of(operation: Operation) -> Iterator[Any]:
    """Jaxprs that an operation executes."""
    equation = operation[-1]
    return _inner(() if equation is None else equation.params.values())


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
        content: Bytes; for a value of an outer trace, its identity or nothing.
        shown: Text for a message.
    """

    type: str
    content: Any
    shown: str


def _value(value: Any, same_run: bool) -> _Value:
    if isinstance(value, Tracer):
        return _Value(str(value.aval), id(value) if same_run else None, "a value of the run")
    dtype = getattr(value, "dtype", None)
    if dtype is not None and jnp.issubdtype(dtype, jax.dtypes.prng_key):
        value = jax.random.key_data(value)
    array = np.asarray(value)
    shown = np.array2string(array.ravel()[:3], separator=", ", precision=17)
    shown = shown[1:-1] if array.size <= 3 else f"{shown[1:-1]}, ..."
    return _Value(f"{dtype}{array.shape}", array.tobytes(), shown)


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


def _described(operation: Operation | None, other: Operation | None) -> str:
    """Operation for a message: its constants, if only these differ from the other one."""
    if operation is None:
        return "no further operation"
    name, operands, *_ = operation
    pairs = zip_longest(operands, other[1]) if other is not None and other[0] == name else ()
    for one, two in pairs:
        if one != two and isinstance(one, _Value):
            return one.shown
    return f"the operation {name}"
