"""Evaluation of functions by NumPy, for functions that are called once or a few times.

Such a function runs for milliseconds and takes seconds to compile. Of a branch, only the block that
is taken is evaluated. The last digits can differ from those of compiled code.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from threading import RLock
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.codegen.jax_versions import closed, scan_counts
from gyrostat.codegen.numpy_rules import RULES
from gyrostat.codegen.tracing import CALLS
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.random_keys import is_random_key

Function = Callable[..., Sequence[Any]]
"""Function of numbers and arrays of NumPy that returns some; random keys are arrays of JAX."""


_Step = tuple[Function, list[int], list[int]]
"""Operation, and the places of its operands and results in the memory."""


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
    """Jaxpr as functions of numbers, made at its first call: not every branch is taken."""

    def __init__(self, jaxpr: Any, programs: _Programs) -> None:
        self._jaxpr, self._programs = jaxpr, programs
        self._places: dict[Any, int] = {}
        self._memory: list[Any] = []
        self._steps: list[_Step] | None = None
        self._inputs: list[int] = []
        self._outputs: list[int] = []

    def __call__(self, *values: Any) -> list[Any]:
        with self._programs.lock:
            steps = self._made() if self._steps is None else self._steps
        memory = self._memory.copy()
        for place, value in zip(self._inputs, values, strict=True):
            memory[place] = value
        for function, operands, results in steps:
            made = function(*[memory[place] for place in operands])
            for place, value in zip(results, made, strict=True):
                memory[place] = value
        return [memory[place] for place in self._outputs]

    def _made(self) -> list[_Step]:
        jaxpr = self._jaxpr
        self._inputs = [*map(self._place, (*jaxpr.constvars, *jaxpr.invars))]
        self._steps = [*map(self._step, jaxpr.eqns)]
        self._outputs = [*map(self._place, jaxpr.outvars)]
        return self._steps

    def _place(self, atom: Any) -> int:
        """Place of a variable or constant in the memory."""
        value = getattr(atom, "val", None)  # of a constant
        if value is None and atom in self._places:
            return self._places[atom]
        self._memory.append(None if value is None else np.asarray(value, atom.aval.dtype)[()])
        if value is None:
            self._places[atom] = len(self._memory) - 1
        return len(self._memory) - 1

    def _step(self, equation: Any) -> _Step:
        operands = [*map(self._place, equation.invars)]
        results = [*map(self._place, equation.outvars)]
        return self._function(equation), operands, results

    def _function(self, equation: Any) -> Function:
        name, params, of = equation.primitive.name, equation.params, self._programs.of
        if name in _OF_PARAMETERS:
            return _OF_PARAMETERS[name](params, of)
        if name in CALLS:
            return of(closed(params[CALLS[name]], ()))
        atoms = (*equation.invars, *equation.outvars)
        has_keys = name != "random_bits" and any(is_random_key(atom.aval) for atom in atoms)
        rule = None if has_keys else RULES.get(name)
        function = None if rule is None else rule(equation)
        return _by_jax(equation) if function is None else lambda *values: (function(*values),)


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
