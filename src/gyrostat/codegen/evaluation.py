"""Evaluation of functions by NumPy, for functions that are called once or a few times.

Such a function runs for milliseconds and takes seconds to compile. Of a branch, only the block that
is taken is evaluated. The last digits can differ from those of compiled code.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache, partial
from itertools import count
from threading import RLock
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.codegen.jax_versions import closed, scan_counts
from gyrostat.codegen.numpy_expressions import expression
from gyrostat.codegen.numpy_rules import RULES
from gyrostat.codegen.tracing import CALLS
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.random_keys import is_random_key

Function = Callable[..., Sequence[Any]]
"""Function of numbers and arrays of NumPy that returns some; random keys are arrays of JAX."""
INLINED = 8
"""Largest number of operations of a function that is repeated wherever it is called: many functions
of JAX, such as `jnp.where`, have fewer, and a call takes longer than an operation."""


def _is_inlined(jaxpr: Any) -> bool:
    """Whether a function is small and calls none, so that programs grow by a factor at most."""
    calls = any(equation.primitive.name in CALLS for equation in jaxpr.eqns)
    return len(jaxpr.eqns) <= INLINED and not calls


def evaluated(function: Callable[..., Any]) -> Callable[..., Any]:
    """Function that is traced where it is called first, and evaluated by NumPy.

    Args:
        function: Function of trees that returns a tree, without side effects. What is no array in
            these trees is left as it is, as by `equinox.filter_jit`.

    Returns:
        The function; its results are arrays of JAX. It is traced again for arguments of other
        trees, shapes and types, and for others that are no arrays.
    """

    # typed: 1, 1.0 and True are equal, and their programs are not
    @lru_cache(maxsize=8, typed=True)
    def traced(tree: Any, types: Any, other_tree: Any, *others: Any) -> Any:
        arrays, static = jax.tree.unflatten(tree, types), jax.tree.unflatten(other_tree, others)
        jaxpr, shapes, kept = eqx.filter_make_jaxpr(function)(*eqx.combine(arrays, static))
        return evaluation(jaxpr), jax.tree.structure(shapes), kept

    def call(*arguments: Any) -> Any:
        arrays, static = eqx.partition(arguments, eqx.is_array)
        leaves, tree = jax.tree.flatten(arrays)
        others, other_tree = jax.tree.flatten(static)
        evaluate, results, kept = traced(tree, (*map(_type, leaves),), other_tree, *others)
        made = [*map(jnp.asarray, evaluate(*leaves))]
        return eqx.combine(jax.tree.unflatten(results, made), kept)

    return call


def evaluation(traced: Any) -> Function:
    """Function that evaluates a closed jaxpr.

    Args:
        traced: Closed jaxpr.
    """
    evaluate = _Programs().of(traced)

    def call(*values: Any) -> list[Any]:
        with np.errstate(all="ignore"):
            results = evaluate(*map(_number, values))
        return [each if is_random_key(each) else np.asarray(each) for each in results]

    return call


def _type(leaf: Any) -> Any:
    weak = getattr(leaf, "weak_type", False)
    return jax.ShapeDtypeStruct(leaf.shape, leaf.dtype, weak_type=weak)


def _number(value: Any) -> Any:
    return value if is_random_key(value) else np.asarray(value)[()]


class _Programs:
    """Programs of the jaxprs of a trace, which calls the same few many times."""

    def __init__(self) -> None:
        self._programs: dict[int, _Program] = {}
        self.lock = RLock()

    def of(self, traced: Any) -> Function:
        """Function of the arguments of a closed jaxpr."""
        jaxpr = traced.jaxpr
        if id(jaxpr) not in self._programs:
            self._programs[id(jaxpr)] = _Program(jaxpr, self)
        program = self._programs[id(jaxpr)]
        constants = [_number(value) for value in traced.consts]
        return (lambda *values: program(*constants, *values)) if constants else program


class _Program:
    """Jaxpr as a function of Python, made at its first call: not every branch is taken.

    Small functions are evaluated thousands of times in a loop, and a table of operations takes
    longer to go through than many an operation of NumPy.
    """

    def __init__(self, jaxpr: Any, programs: _Programs) -> None:
        self._jaxpr, self._programs = jaxpr, programs
        self._function: Function | None = None

    def __call__(self, *values: Any) -> Sequence[Any]:
        if self._function is None:
            with self._programs.lock:
                self._function = _Source(self._programs).function(self._jaxpr)
        return self._function(*values)


class _Source:
    """Text of a function of Python, and the functions and constants that it names."""

    def __init__(self, programs: _Programs) -> None:
        self._programs = programs
        self._objects: dict[str, Any] = {}
        self._variables: dict[Any, str] = {}
        self._numbers = count()

    def function(self, jaxpr: Any) -> Function:
        """Function of the variables of a jaxpr."""
        arguments = [*map(self._name, (*jaxpr.constvars, *jaxpr.invars))]
        lines = [*self._lines(jaxpr)]
        lines.append(f"return [{', '.join(map(self._name, jaxpr.outvars))}]")
        text = f"def function({', '.join(arguments)}):\n " + "\n ".join(lines)
        exec(text, self._objects)
        return self._objects["function"]

    def _lines(self, jaxpr: Any) -> Iterator[str]:
        for equation in jaxpr.eqns:
            name = CALLS.get(equation.primitive.name)
            inner = None if name is None else closed(equation.params[name], ())
            if inner is None or not _is_inlined(inner.jaxpr):
                yield self._line(equation)
            else:
                yield from self._inlined(equation, inner)

    def _inlined(self, equation: Any, inner: Any) -> Iterator[str]:
        """Lines of a function that is called; its variables have new names at each call."""
        constants = [self._object(_number(value)) for value in inner.consts]
        operands = [*constants, *map(self._name, equation.invars)]
        names = (*inner.jaxpr.constvars, *inner.jaxpr.invars)
        outside, self._variables = self._variables, dict(zip(names, operands, strict=True))
        yield from self._lines(inner.jaxpr)
        results = [*map(self._name, inner.jaxpr.outvars)]
        self._variables = outside
        outside.update(zip(equation.outvars, results, strict=True))

    def _name(self, atom: Any) -> str:
        """Name of a variable or constant."""
        value = getattr(atom, "val", None)  # of a constant
        if value is not None:
            return self._object(np.asarray(value, atom.aval.dtype)[()])
        if atom not in self._variables:
            self._variables[atom] = f"v{next(self._numbers)}"
        return self._variables[atom]

    def _object(self, value: Any) -> str:
        name = f"o{len(self._objects)}"
        self._objects[name] = value
        return name

    def _line(self, equation: Any) -> str:
        operands = [*map(self._name, equation.invars)]
        results = "".join(f"{self._name(atom)}, " for atom in equation.outvars)
        function = self._of_several(equation)
        if function is None:
            function = _rule(equation)
            if function is not None:
                results = results.removesuffix(", ")
                if (text := expression(equation, function)) is not None:
                    return f"{results} = {text.format(*operands)}"
        call = f"{self._object(function or _by_jax(equation))}({', '.join(operands)})"
        return f"{results} = {call}" if results else call

    def _of_several(self, equation: Any) -> Function | None:
        """Function that returns a sequence of results."""
        name, params, of = equation.primitive.name, equation.params, self._programs.of
        if name in _OF_PARAMETERS:
            return _OF_PARAMETERS[name](params, of)
        return of(closed(params[CALLS[name]], ())) if name in CALLS else None


def _rule(equation: Any) -> Callable[..., Any] | None:
    """Function that returns the only result of an equation, or None if it has no rule."""
    name = equation.primitive.name
    atoms = (*equation.invars, *equation.outvars)
    has_keys = name != "random_bits" and any(is_random_key(atom.aval) for atom in atoms)
    rule = None if has_keys else RULES.get(name)
    return None if rule is None else rule(equation)


def _by_jax(equation: Any) -> Function:
    """Function of an equation without a rule: JAX compiles it."""
    primitive = equation.primitive
    bind: Callable[..., Any] = partial(primitive.bind, **equation.params)
    if primitive.name == "pure_callback":
        bind = eqx.filter_jit(bind)  # its error has the message of `equinox.error_if`

    def call(*values: Any) -> Sequence[Any]:
        results = bind(*map(jnp.asarray, values))
        return [*map(_number, results if primitive.multiple_results else (results,))]

    return call


def _branch(params: Any, of: Callable[[Any], Function]) -> Function:
    blocks = [of(closed(each, ())) for each in params["branches"]]

    def branch(index: Any, *values: Any) -> Sequence[Any]:
        return blocks[min(max(int(index), 0), len(blocks) - 1)](*values)

    return branch


def _while(params: Any, of: Callable[[Any], Function]) -> Function:
    test, body = (of(closed(params[name], ())) for name in ("cond_jaxpr", "body_jaxpr"))
    split = params["cond_nconsts"]
    start = split + params["body_nconsts"]

    def loop(*values: Any) -> Sequence[Any]:
        carry: Sequence[Any] = values[start:]
        while np.any(goes_on := test(*values[:split], *carry)[0]):
            changed = body(*values[split:start], *carry)
            # along a batch, each loop ends by itself
            if np.ndim(goes_on):
                pairs = zip(changed, carry, strict=True)
                changed = [_chosen(goes_on, *pair) for pair in pairs]
            carry = changed
        return carry

    return loop


def _chosen(which: Any, yes: Any, no: Any) -> Any:
    """Rows of one of two arrays; the first axes are those of the choice."""
    which = np.reshape(which, (*which.shape, *[1] * (yes.ndim - which.ndim)))
    return (jnp if is_random_key(yes) else np).where(which, yes, no)


def _scan(params: Any, of: Callable[[Any], Function]) -> Function:
    counts, jaxpr, length = scan_counts(params), closed(params["jaxpr"], ()), params["length"]
    body, start = of(jaxpr), counts.constants + counts.carries
    order = range(length)[:: -1 if params["reverse"] else 1]
    rows = [atom.aval for atom in jaxpr.jaxpr.outvars[counts.carries :]]

    def scan(*values: Any) -> Sequence[Any]:
        carry: Sequence[Any] = values[counts.constants : start]
        tables: list[Any] = [
            [None] * length if is_random_key(row) else np.empty((length, *row.shape), row.dtype)
            for row in rows
        ]
        for k in order:
            row = (each[k] for each in values[start:])
            results = body(*values[: counts.constants], *carry, *row)
            carry = results[: counts.carries]
            for table, number in zip(tables, results[counts.carries :], strict=True):
                table[k] = number
        return [*carry, *(jnp.stack(each) if isinstance(each, list) else each for each in tables)]

    return scan


def _unchanged(params: Any, of: Callable[[Any], Function]) -> Function:
    return lambda *values: values


_OF_PARAMETERS = {
    "cond": _branch,
    "while": _while,
    "scan": _scan,
    "optimization_barrier": _unchanged,
}
