"""Execution of one run or a batch, whole or in chunks of time, by JAX or by the native engine."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import equinox as eqx
import numpy as np
from numpy.typing import NDArray

from gyrostat.codegen.jax_versions import UnsupportedVersionError
from gyrostat.codegen.simd.batch import Lanes, lanes
from gyrostat.core.engines import say_slower
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.messages import silent
from gyrostat.core.stored_trees import stored_tree_function
from gyrostat.simulation.loop import Loop

LANES = 64
"""Runs in one batch of JAX. Larger batches are not faster; progress is reported between batches."""
LONGEST = 2000
"""Most samples in a chunk of the native engine, which keeps them in memory for all SIMD lanes."""
MOST = 32
"""Largest number of compiled programs of the native engine that are kept."""
_NATIVE: dict[Any, tuple[Lanes | None, Lanes]] = {}


def by_engine(engine: str, attempt: Callable[[str], Any]) -> Any:
    """Call a function with an engine; "auto" tries the native engine first, then JAX.

    Args:
        engine: "jax", "native" or "auto".
        attempt: Function of the name of the engine, "jax" or "native".

    Returns:
        Result of the function.

    Raises:
        InputError: Raised by the function; with "auto", only by its call for JAX. Or the engine is
            unknown.
    """
    if engine not in ("jax", "native", "auto"):
        raise InputError(f"engine: found {engine!r}, expected jax, native or auto")
    if engine == "auto":
        try:
            return attempt("native")
        except UnsupportedVersionError as error:
            say_slower(error, silent)
        except InputError:
            pass
        engine = "jax"
    return attempt(engine)


class Runner:
    """Executes a loop for one run or for many.

    Python numbers are compile-time constants in JAX and parameters in the native engine.

    Args:
        make: Arguments of one run -> its loop. Compiled programs are kept for each such function.
        own: For each argument, whether it has a leading axis of runs. If none has, there is a
            single run and results have no axis of runs.
        count: Number of control periods.
        engine: "jax" or "native"; "native" supports batches only.
        longest: Most samples in a chunk; None for a single chunk.
        on_demand: Flags in the tree structure of the loop's records, or a prefix of it: whether
            records are returned only for requested runs. Needs chunks of more than 64 samples.
        stored: Whether the program of JAX is kept in the private cache.

    Attributes:
        starts: Index of the first sample of each chunk.
        length: Number of samples in a chunk.
    """

    def __init__(
        self,
        make: Callable[..., Loop],
        own: Sequence[bool],
        count: int,
        *,
        engine: str = "jax",
        longest: int | None = None,
        on_demand: Any = False,
        stored: bool = False,
    ) -> None:
        if engine not in ("jax", "native"):
            raise InputError(f"engine: found {engine!r}, expected jax or native")
        self._make, self._own, self._engine, self._on_demand = make, tuple(own), engine, on_demand
        self._samples, self._stored = count + 1, stored
        # the smallest number of chunks of equal length
        chunks = 1 if longest is None else -(-self._samples // longest)
        self.length = -(-self._samples // chunks)
        self.starts = range(0, self._samples, self.length)

    def chunks(
        self, *arguments: Any, carry: Any = None, asked: Sequence[int] = ()
    ) -> Iterator[tuple[Any, Any]]:
        """Run chunk by chunk; the last chunk may extend beyond the last sample.

        Args:
            arguments: Arguments of all runs.
            carry: Initial carry of all runs, if it is known.
            asked: Indices of the runs whose on-demand records are requested.

        Yields:
            The carry after the chunk, and its records with axes (run, sample).

        Raises:
            InputError: The native engine cannot run this loop; the message names the line of
                Python.
        """
        if self._engine == "native":
            beginning, chunk = self.compiled(*arguments, carry=carry)
            arrays, _ = eqx.partition(arguments, _is_number)
            carry = carry if beginning is None else beginning(*arrays)
            for first in self.starts:
                carry, rows = chunk(carry, first, *arrays, asked=asked)
                yield carry, rows
            return
        run = _stored_chunk if self._stored else _compiled_chunk
        for first in self.starts:
            carry, rows = run(
                *(self._make, self._own, self.length),
                *(carry, np.asarray(first), arguments),
            )
            yield carry, self._select(rows, asked)

    def records(
        self,
        *arguments: Any,
        runs: int | None = None,
        on_progress: Callable[[int, int], None] | None = None,
    ) -> Any:
        """Records of every sample of every run.

        Args:
            arguments: Arguments of all runs.
            runs: Number of runs; None for a single run whose arguments have no axis of runs.
            on_progress: Called with the number of completed runs and the total number of runs.

        Returns:
            Records with axes (run, sample), (sample,) for a single run.
        """
        if runs is None:
            ((_, rows),) = self.chunks(*arguments)
            return rows
        parts, progress = [], 0
        for rows, count in blocks(runs, runs if self._engine == "native" else min(LANES, runs)):
            selection = [
                jax.tree.map(lambda leaf: leaf[rows] if eqx.is_array(leaf) else leaf, part)  # noqa: B023
                if each and len(rows) < runs
                else part
                for each, part in zip(self._own, arguments, strict=True)
            ]
            chunks = [row for _, row in self.chunks(*selection)]
            parts.append(
                jax.tree.map(
                    lambda *leaves: np.concatenate(leaves, axis=1)[:count, : self._samples],  # noqa: B023
                    *chunks,
                )
            )
            progress += count
            if on_progress is not None:
                on_progress(progress, runs)
        return jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts)

    def compiled(self, *arguments: Any, carry: Any = None) -> tuple[Lanes | None, Lanes]:
        """Compiled programs of the native engine.

        Returns:
            The program of the initialisation, None if the carry is given; the program of a chunk.

        Raises:
            InputError: There is no compiler, or the loop contains an unsupported operation.
        """
        arrays, static = eqx.partition(arguments, _is_number)
        leaves, tree = jax.tree.flatten(static)
        shapes = [
            (np.shape(leaf)[each:], str(getattr(leaf, "dtype", float)))
            for each, part in zip(self._own, arrays, strict=True)
            for leaf in jax.tree.leaves(part)
        ]
        # structures and types are part of the key: None may be an array elsewhere, and 1 == True
        kind = (
            *(self._make, self._own, self.length, self._on_demand, carry is None, tree),
            *(jax.tree.structure(arrays), tuple(leaves), tuple(map(type, leaves)), *shapes),
        )
        if kind not in _NATIVE:
            if len(_NATIVE) >= MOST:
                del _NATIVE[next(iter(_NATIVE))]
            _NATIVE[kind] = self._compile(arrays, static, carry)
        return _NATIVE[kind]

    def _compile(self, arrays: Any, static: Any, carry: Any) -> tuple[Lanes | None, Lanes]:
        def begin(*parts):
            return self._make(*eqx.combine(parts, static)).begin()

        def chunk(carry, first, *parts):
            return self._make(*eqx.combine(parts, static)).scan(carry, first, self.length)

        beginning = None
        if carry is None:
            beginning = lanes(begin, self._own, arrays)
            carry = beginning(*arrays)
        on_demand = (False, self._on_demand)
        batched = (True, False, *self._own)
        return beginning, lanes(chunk, batched, (carry, 0, *arrays), on_demand=on_demand)

    def _select(self, rows: Any, indices: Sequence[int]) -> Any:
        """Records with on-demand parts for the requested runs only."""

        def pick(flag: bool, part: Any) -> Any:
            if not flag:
                return jax.tree.map(np.asarray, part)
            if not indices:
                return jax.tree.map(lambda leaf: np.empty((0, *leaf.shape[1:]), leaf.dtype), part)
            return jax.tree.map(lambda leaf: np.asarray(leaf)[np.asarray(indices)], part)

        return jax.tree.map(pick, self._on_demand, rows)


def blocks(runs: int, size: int) -> Iterator[tuple[NDArray[np.int64], int]]:
    """Divide runs into blocks of equal size, so that only one size is compiled.

    Args:
        runs: Number of runs.
        size: Number of runs in a block.

    Yields:
        The indices of the runs of a block, and the number of valid ones; the last block is padded
        with the last run.
    """
    for first in range(0, runs, size):
        yield np.minimum(np.arange(first, first + size), runs - 1), min(size, runs - first)


def _is_number(leaf: Any) -> bool:
    return isinstance(leaf, float) or hasattr(leaf, "dtype")


def _chunk(make, batched, length, carry, first, arguments):
    """Run a chunk by JAX; without a carry, the first chunk including the initialisation."""

    def chunk(carry, *parts):
        loop = make(*parts)
        if carry is None:
            return loop.scan(loop.begin(), jnp.array(0), length)
        return loop.scan(carry, first, length)

    if not any(batched):
        return chunk(carry, *arguments)
    axes = tuple(eqx.if_array(0) if each else None for each in (True, *batched))
    return eqx.filter_vmap(chunk, in_axes=axes)(carry, *arguments)


_compiled_chunk, _stored_chunk = eqx.filter_jit(_chunk), stored_tree_function(_chunk)
