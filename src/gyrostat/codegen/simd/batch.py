"""Compile a function of one run for many runs, one in each SIMD lane."""

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.lower import Lowering
from gyrostat.codegen.program import Function, Name, Operand, Table
from gyrostat.codegen.prune import prune
from gyrostat.codegen.simd.batch_scope import BATCH, batch_kind, numbers
from gyrostat.codegen.simd.compiler import library
from gyrostat.codegen.simd.module import module
from gyrostat.codegen.simd.rarely_taken import branch_rarely_taken
from gyrostat.codegen.simd.simplify import simplify
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

Words = NDArray[np.uint64]


@dataclass(frozen=True)
class Lanes:
    """Compiled function that computes any number of runs.

    Attributes:
        text: Text of its C module.
        width: Number of SIMD lanes.
    """

    text: str
    width: int
    _library: ctypes.CDLL
    _own: tuple[bool, ...]
    _types: tuple[tuple[tuple[int, ...], Any], ...]
    _results: Any
    _places: tuple["_Place", ...]
    _words: dict[str, int]

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
            InputError: The arguments have other shapes or types than those compiled for, or
                different numbers of runs; or a run in `asked` does not exist.
        """
        leaves = jax.tree.leaves(arguments)
        split: tuple[list[Words], list[Words]] = ([], [])
        for leaf, own, known in zip(leaves, self._own, self._types, strict=True):
            split[own].append(_words(leaf, *known, own=own))
        runs = len(split[True][0])
        if any(len(words) != runs for words in split[True]):
            found = ", ".join(str(len(words)) for words in split[True])
            raise InputError(f"runs: found {found}, expected one number of them")
        if any(run not in range(runs) for run in asked):
            raise InputError(f"asked: found {list(asked)}, expected numbers below {runs}")
        groups = -(-runs // self.width)
        shared = np.concatenate([np.zeros(0, np.uint64), *(word.ravel() for word in split[False])])
        own = np.concatenate([w.reshape(runs, int(np.prod(w.shape[1:]))) for w in split[True]], 1)
        # unused lanes repeat the last run
        own = own[np.minimum(np.arange(groups * self.width), runs - 1)]
        own = own.reshape(groups, self.width, own.shape[1]).swapaxes(1, 2).copy()
        wanted = sorted({run // self.width for run in asked})
        place = np.full(groups, -1, np.int64)
        place[wanted] = np.arange(len(wanted))
        memory = {
            name: np.empty((len(wanted) if name == "asked" else groups, words, self.width), "u8")
            for name, words in self._words.items()
        }
        self._library.fly_all(
            ctypes.c_int64(groups),
            ctypes.c_int64(threads),
            *(ctypes.c_void_p(a.ctypes.data) for a in (shared, own, *memory.values(), place)),
        )
        lanes = {name: np.arange(runs) for name in memory}
        lanes["asked"] = np.array(
            [place[run // self.width] * self.width + run % self.width for run in asked], np.int64
        )
        found = {
            name: made.swapaxes(1, 2).reshape(len(made) * self.width, made.shape[1])[lanes[name]]
            for name, made in memory.items()
        }
        return jax.tree.unflatten(self._results, [p.of(found[p.memory]) for p in self._places])


@dataclass(frozen=True)
class _Place:
    """Position of a result in one of the output buffers of a run."""

    memory: str
    start: int
    shape: tuple[int, ...]
    dtype: Any

    def of(self, words: Words) -> NDArray[Any]:
        own = words[:, self.start : self.start + int(np.prod(self.shape))]
        return _numbers(own.reshape(len(words), *self.shape), self.dtype)


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
        function: Function of trees of arrays that returns a tree of arrays; also accepted by
            `jax.jit`.
        own: For each argument, whether it differs between runs and has a leading axis.
        arguments: Example arguments; only their shapes and types are used.
        on_demand: Tree, or prefix of a tree, of the results: whether the rows of a scan of more
            than `batch_scope.LONGEST` passes are returned only for requested runs.
        more_flags: Further flags for the compiler.

    Raises:
        InputError: There is no compiler, or the function contains an operation that SIMD code does
            not support; the message names the line of Python.
    """
    flags = [bool(o) for o, tree in zip(own, arguments, strict=True) for _ in jax.tree.leaves(tree)]
    single = [
        jax.tree.map(_single if each else _whole, tree)
        for each, tree in zip(own, arguments, strict=True)
    ]
    if not any(flags):
        raise InputError("own: found no argument that differs between runs, expected one or more")
    traced, shapes = jax.make_jaxpr(function, return_shape=True)(*single)
    inputs = [_named(variable.aval) for variable in traced.jaxpr.invars]
    lowering, body = Lowering(BATCH), []
    made = lowering.graph(traced, inputs, body)
    flagged = jax.tree.leaves(
        jax.tree.map(lambda flag, tree: jax.tree.map(lambda _: flag, tree), on_demand, shapes)
    )
    results: list[Operand] = []
    rows: list[tuple[Table, bool]] = []
    places: list[_Place] = []
    words = {"made": 0, "every": 0, "asked": 0}
    for array, shape, demand in zip(made, jax.tree.leaves(shapes), flagged, strict=True):
        table = array.item() if array.shape == () else None
        memory = "made"
        if isinstance(table, Table):
            memory = "asked" if demand else "every"
            rows.append((table, demand))
        else:
            results += list(array.flat)
        places.append(_Place(memory, words[memory], shape.shape, shape.dtype))
        words[memory] += int(np.prod(shape.shape))
    split: tuple[list[Name], list[Name]] = ([], [])
    for names, each in zip(inputs, flags, strict=True):
        split[each].extend(names.flat)
    program = Function(
        "fly", split[False] + split[True], body, results, rows=[table for table, _ in rows]
    )
    prune([program], [program])
    branch_rarely_taken(program)
    simplify(program)
    prune([program], [program])
    text = module(program, *split, [demand for _, demand in rows])
    compiled = library(text, more_flags)
    return Lanes(
        text,
        compiled.lanes(),
        compiled,
        tuple(flags),
        tuple((leaf.shape, leaf.dtype) for leaf in jax.tree.leaves(single)),
        jax.tree.structure(shapes),
        tuple(places),
        words,
    )


def _single(leaf: Any) -> Any:
    leaf = _whole(leaf)
    return jax.ShapeDtypeStruct(leaf.shape[1:], leaf.dtype)


def _whole(leaf: Any) -> Any:
    leaf = leaf if hasattr(leaf, "dtype") else np.asarray(leaf)
    return jax.ShapeDtypeStruct(leaf.shape, leaf.dtype)


def _named(shape: Any) -> NDArray[Any]:
    kind = batch_kind(shape.dtype)
    if kind is None:
        raise InputError(f"argument: found numbers of type {shape.dtype}, expected float64 ones")
    names = np.empty(shape.shape, dtype=object)
    for place in np.ndindex(shape.shape):
        names[place] = Name(kind)
    return names


def _words(leaf: Any, shape: tuple[int, ...], dtype: Any, *, own: bool) -> Words:
    """Numbers as 64-bit words: logical values as masks, the two words of a random key as one."""
    found = leaf if hasattr(leaf, "dtype") else np.asarray(leaf)
    key = jnp.issubdtype(found.dtype, jax.dtypes.prng_key)
    fits = found.dtype == dtype or not (key or np.bool_ in (found.dtype, dtype))
    if fits and found.dtype != dtype:
        fits = np.can_cast(found.dtype, dtype)
    if not fits or found.shape[own:] != shape or (own and not found.shape):
        raise InputError(
            f"argument: found {found.dtype}{list(found.shape[own:])}, expected "
            f"{dtype}{list(shape)}, which this was compiled for"
        )
    array = numbers(found)
    if array.dtype == np.bool_:
        return (-array.astype(np.int64)).view(np.uint64)
    if key:
        return array
    return np.ascontiguousarray(array, _word(dtype)).reshape(array.shape).view(np.uint64)


def _numbers(words: Words, dtype: Any) -> Any:
    words = np.ascontiguousarray(words)
    if jnp.issubdtype(dtype, jax.dtypes.prng_key):
        pair = np.stack([words >> np.uint64(32), words], axis=-1).astype(np.uint32)
        return jax.random.wrap_key_data(jnp.asarray(pair))
    return words != 0 if dtype == np.bool_ else words.view(_word(dtype)).astype(dtype)


def _word(dtype: Any) -> type[np.number]:
    return np.float64 if dtype == np.float64 else np.int64
