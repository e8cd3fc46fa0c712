"""Compile a function of one run for many runs, one in each SIMD lane."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.codegen.jax_versions import require_supported
from gyrostat.codegen.lower import Lowering
from gyrostat.codegen.memo import Memo
from gyrostat.codegen.program import Function, Operand, Table
from gyrostat.codegen.program_cost import Cost, cost
from gyrostat.codegen.prune import prune
from gyrostat.codegen.row_choice import smallest
from gyrostat.codegen.scope import Scope
from gyrostat.codegen.sharing import share_tables
from gyrostat.codegen.simd.batch_scope import BATCH, numbers
from gyrostat.codegen.simd.call import KEY, Compiled, Layout, Place, Type
from gyrostat.codegen.simd.compiler import library
from gyrostat.codegen.simd.inputs import inputs_of, parameters_of
from gyrostat.codegen.simd.module import module
from gyrostat.codegen.simd.rarely_taken import branch_rarely_taken
from gyrostat.codegen.simd.simplify import simplify
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.random_keys import random_keys


@dataclass(frozen=True)
class Traced:
    """Function as C, not compiled yet.

    Attributes:
        text: Text of its C module.
        layout: Layout of its arguments and results, as lists of arrays.
        results: Shapes and types of the results, in their tree.
    """

    text: str
    layout: Layout
    results: Any


@dataclass(frozen=True)
class Lanes:
    """Compiled function that computes any number of runs.

    Attributes:
        traced: The function as C.
        compiled: The function of lists of arrays.
    """

    traced: Traced
    compiled: Compiled

    @property
    def text(self) -> str:
        """Text of its C module."""
        return self.traced.text

    @property
    def width(self) -> int:
        """Number of SIMD lanes."""
        return self.compiled.library.lanes()

    def __call__(self, *arguments: Any, asked: Sequence[int] = (), threads: int = 1) -> Any:
        """Compute all runs.

        Args:
            arguments: Arguments of the function; those that differ between runs have a leading
                axis.
            asked: Runs for which the rows on demand are returned.
            threads: Number of threads.

        Returns:
            The results with a leading axis of runs; rows on demand only for the runs in `asked`.

        Raises:
            InputError: See `Compiled`.
        """
        layout = self.traced.layout
        leaves = [
            _plain(leaf, expected)
            for leaf, expected in zip(jax.tree.leaves(arguments), layout.types, strict=True)
        ]
        arrays = self.compiled(leaves, asked, threads)
        results = [
            random_keys(array) if place.type.dtype == KEY else array
            for array, place in zip(arrays, layout.places, strict=True)
        ]
        return jax.tree.unflatten(jax.tree.structure(self.traced.results), results)


def lanes(
    function: Callable[..., Any],
    own: Sequence[bool],
    arguments: Sequence[Any],
    *,
    on_demand: Any = False,
    more_flags: tuple[str, ...] = (),
) -> Lanes:
    """Compile a function of one run for many runs.

    Args:
        function: See `traced`.
        own: See `traced`.
        arguments: See `traced`.
        on_demand: See `traced`.
        more_flags: Further flags for the compiler.

    Raises:
        InputError: There is no compiler; or see `traced`.
    """
    code = traced(function, own, arguments, on_demand=on_demand)
    return Lanes(code, Compiled(code.layout, library(code.text, more_flags)))


def traced(
    function: Callable[..., Any],
    own: Sequence[bool],
    arguments: Sequence[Any],
    *,
    on_demand: Any = False,
) -> Traced:
    """Convert a function of one run to C for many runs.

    Args:
        function: Function of trees of arrays that returns a tree of arrays; also accepted by
            `jax.jit`.
        own: For each argument, whether it differs between runs and has a leading axis.
        arguments: Example arguments; only their shapes and types are used.
        on_demand: Tree, or prefix of a tree, of the results: whether they are returned only for
            requested runs.

    Raises:
        InputError: The function contains an operation that SIMD code does not support; the message
            names the line of Python. Or the version of JAX is not supported.
    """
    require_supported()
    flags = [bool(o) for o, tree in zip(own, arguments, strict=True) for _ in jax.tree.leaves(tree)]
    single = [
        jax.tree.map(_run_aval if each else _aval, tree)
        for each, tree in zip(own, arguments, strict=True)
    ]
    if not any(flags):
        raise InputError("own: found no argument that differs between runs, expected one or more")
    jaxpr, shapes = jax.make_jaxpr(function, return_shape=True)(*single)
    demands = jax.tree.leaves(
        jax.tree.map(lambda flag, tree: jax.tree.map(lambda _: flag, tree), on_demand, shapes)
    )
    lowered = smallest(lambda scope: _lowered(jaxpr, flags, shapes, demands, scope), BATCH)
    inputs, places, words = lowered.inputs, lowered.places, lowered.words
    program = lowered.program
    share_tables(program)
    split = parameters_of(inputs, flags, program.body)
    own_words = sum(array.size for array, each in zip(inputs, flags, strict=True) if each)
    text = module(program, *split, lowered.rows, {**words, "own": own_words})
    types = tuple(_type(leaf) for leaf in jax.tree.leaves(single))
    return Traced(text, Layout(tuple(flags), types, tuple(places), words), shapes)


@dataclass(frozen=True)
class _Lowered:
    program: Function
    inputs: list[Any]
    rows: dict[Table, list[tuple[str, int]]]
    places: list[Place]
    words: dict[str, int]


def _lowered(
    jaxpr: Any, flags: Sequence[bool], shapes: Any, demands: Sequence[Any], scope: Scope
) -> tuple[_Lowered, Memo, Cost]:
    """Program without what is not needed, and where its results are."""
    inputs = inputs_of([variable.aval for variable in jaxpr.jaxpr.invars], flags)
    lowering, body = Lowering(scope), []
    outputs = lowering.graph(jaxpr, inputs, body)
    results: list[Operand] = []
    rows: dict[Table, list[tuple[str, int]]] = {}
    places: list[Place] = []
    words = {"made": 0, "every": 0, "asked": 0}
    for array, shape, demand in zip(outputs, jax.tree.leaves(shapes), demands, strict=True):
        table = array.item() if array.shape == () else None
        memory = "made"
        if isinstance(table, Table):
            memory = "asked" if demand else "every"
            rows.setdefault(table, []).append((memory, words[memory]))
        else:
            results += list(array.flat)
        places.append(Place(memory, words[memory], _type(shape), bool(demand)))
        words[memory] += int(np.prod(shape.shape))
    program = Function("fly", [], body, results, rows=[*rows])
    prune([program], [program])
    branch_rarely_taken(program)
    simplify(program)
    prune([program], [program])
    lowered = _Lowered(program, inputs, rows, places, words)
    return lowered, lowering.memo, cost([program])


def _run_aval(leaf: Any) -> Any:
    leaf = _aval(leaf)
    return jax.ShapeDtypeStruct(leaf.shape[1:], leaf.dtype)


def _aval(leaf: Any) -> Any:
    leaf = leaf if hasattr(leaf, "dtype") else np.asarray(leaf)
    return jax.ShapeDtypeStruct(leaf.shape, leaf.dtype)


def _type(leaf: Any) -> Type:
    return Type(tuple(leaf.shape), str(leaf.dtype))


def _plain(leaf: Any, expected: Type) -> Any:
    """Array as NumPy has it; random keys as words."""
    if (str(getattr(leaf, "dtype", "")) == KEY) != (expected.dtype == KEY):
        raise InputError(
            f"argument: found {getattr(leaf, 'dtype', type(leaf).__name__)}, expected "
            f"{expected.dtype}{list(expected.shape)}, which this was compiled for"
        )
    return numbers(leaf)
