"""A function of one run, compiled for many."""

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat._jax import jax, jnp
from gyrostat.errors import InputError
from gyrostat.lanes.compiler import library
from gyrostat.lanes.wide import WIDE, wide_kind
from gyrostat.lanes.write import module
from gyrostat.lowering import Lowering, prune
from gyrostat.lowering.program import Function, Name, Operand, Table

Words = NDArray[np.uint64]


@dataclass(frozen=True)
class Lanes:
    """A compiled function, for as many runs as are given.

    Attributes:
        text: of its C module.
        width: lanes that are carried together.
    """

    text: str
    width: int
    _library: ctypes.CDLL
    _own: tuple[bool, ...]
    _results: Any
    _places: tuple["_Place", ...]
    _words: dict[str, int]

    def __call__(self, *arguments: Any, asked: Sequence[int] = (), threads: int = 1) -> Any:
        """Compute all runs.

        Args:
            arguments: as those of the function; what a run has of its own has a leading axis.
            asked: runs whose rows on demand are wanted.
            threads: that share the work.

        Returns:
            The results with a leading axis of runs; in rows on demand, of the runs asked for.
        """
        leaves = jax.tree.leaves(arguments)
        split: tuple[list[Words], list[Words]] = ([], [])
        for leaf, own in zip(leaves, self._own, strict=True):
            split[own].append(_words(leaf))
        runs = len(split[True][0])
        groups = -(-runs // self.width)
        shared = _joined([word.ravel() for word in split[False]], 0)
        own = _joined([word.reshape(runs, -1) for word in split[True]], 1)
        # lanes without a run fly the last one again
        own = own[np.minimum(np.arange(groups * self.width), runs - 1)]
        own = own.reshape(groups, self.width, -1).swapaxes(1, 2).copy()
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
    """Where a result lies among a run's words of some memory."""

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
    """Compile a function of one run for many.

    Args:
        function: of trees of arrays, to a tree of arrays; for `jax.jit` too.
        own: for each argument whether each run has one of its own, with a leading axis.
        arguments: examples, for shapes alone.
        on_demand: a tree, or the beginning of one, as the function returns: whether the rows of a
            scan of more than `wide.LONGEST` passes are given for the runs that are asked for alone.
        more_flags: for the compiler.

    Raises:
        InputError: there is no compiler, or the function has something that lanes do not know; the
            message names the line of Python.
    """
    flags = [bool(o) for o, tree in zip(own, arguments, strict=True) for _ in jax.tree.leaves(tree)]
    single = [
        jax.tree.map(_single if each else _whole, tree)
        for each, tree in zip(own, arguments, strict=True)
    ]
    traced, shapes = jax.make_jaxpr(function, return_shape=True)(*single)
    inputs = [_named(variable.aval) for variable in traced.jaxpr.invars]
    lowering, body = Lowering(WIDE), []
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
    text = module(program, *split, [demand for _, demand in rows])
    compiled = library(text, more_flags)
    return Lanes(
        text,
        compiled.lanes(),
        compiled,
        tuple(flags),
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
    kind = wide_kind(shape.dtype)
    if kind is None:
        raise InputError(f"argument: found numbers of type {shape.dtype}, expected float64 ones")
    names = np.empty(shape.shape, dtype=object)
    for place in np.ndindex(shape.shape):
        names[place] = Name(kind)
    return names


def _joined(arrays: list[Words], axis: int) -> Words:
    return np.concatenate(arrays, axis) if arrays else np.zeros(0, np.uint64)


def _words(leaf: Any) -> Words:
    """Numbers as words of 64 bits: a logical one as a mask, the two words of a key as one."""
    if jnp.issubdtype(getattr(leaf, "dtype", np.float64), jax.dtypes.prng_key):
        pair = np.asarray(jax.random.key_data(leaf)).astype(np.uint64)
        return (pair[..., 0] << np.uint64(32)) | pair[..., 1]
    array = np.asarray(leaf)
    if array.dtype == np.bool_:
        return (-array.astype(np.int64)).view(np.uint64)
    if array.dtype == np.float64:
        return np.ascontiguousarray(array).view(np.uint64)
    return array.astype(np.int64).view(np.uint64)


def _numbers(words: Words, dtype: Any) -> NDArray[Any]:
    words = np.ascontiguousarray(words)
    if dtype == np.bool_:
        return words != 0
    return words.view(np.float64) if dtype == np.float64 else words.view(np.int64).astype(dtype)
