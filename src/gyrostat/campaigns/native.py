"""Program of a scenario for the native engine, stored with all that is needed to call it.

A program depends only on the structure of its scenario. It is stored in the private cache under a
digest of this structure, of the code of this package and of all versions. A stored program is
neither traced nor compiled again.
"""

import hashlib
import os
import pickle
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np

from gyrostat.codegen.simd.batch import Traced, traced
from gyrostat.codegen.simd.call import Compiled, Layout
from gyrostat.codegen.simd.compiler import library, library_name, require_compiler, stored_library
from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.threefry import Words
from gyrostat.core.types import Vector
from gyrostat.runs.designs import Plans
from gyrostat.runs.fingerprint import FLAGS, engine_record
from gyrostat.runs.metrics.observer import Seen
from gyrostat.runs.run_loop import ON_DEMAND, OWN, Drawn, loop_of, runner_of
from gyrostat.scenario.kinds.orbits import has_own_orbits
from gyrostat.scenario.kinds.registry import is_shipped
from gyrostat.scenario.structure import Structure


class Part(NamedTuple):
    """Compiled function as it is stored.

    Attributes:
        text: SHA-256 digest of its text.
        library: Name of its library in the cache.
        layout: Layout of its arguments and results.
    """

    text: str
    library: str
    layout: Layout


class Stored(NamedTuple):
    """Program as it is stored.

    Attributes:
        begin: Initialisation of runs.
        chunk: Control periods of one chunk of time.
        seen: Tree of the accumulated metrics, with their places in the list of the carry.
        records: Tree of the records, with their places in the list of records.
    """

    begin: Part
    chunk: Part
    seen: Any
    records: Any


class Program(NamedTuple):
    """Program of a scenario, loaded; see `Stored`.

    Attributes:
        begin: Initialisation of runs.
        chunk: Control periods of one chunk of time.
        seen: See `Stored`.
        records: See `Stored`.
        starts: Index of the first sample of each chunk.
        stored: What the cache has of it.
    """

    begin: Compiled
    chunk: Compiled
    seen: Any
    records: Any
    starts: range
    stored: Stored

    def chunks(
        self, nominal: Vector, drawn: Drawn, plans: Plans, keys: Words, asked: Sequence[int]
    ) -> Iterator[tuple[Seen, Any, Any]]:
        """Run chunk by chunk; the last chunk may extend beyond the last sample.

        Args:
            nominal: Nominal values.
            drawn: What each run has of its own, with a leading axis of runs.
            plans: Designs.
            keys: Random keys of the noise, (runs,), or of each part of a run, (runs, parts).
            asked: Indices of the runs whose records are requested.

        Yields:
            `Seen` after the chunk, the errors of all runs, and the records of the requested runs.
            The errors are the counted pointing errors of the run and of each window, (runs,
            samples), and the error vectors of pointing requirements, (runs, samples, 3).
        """
        arguments = (nominal, *map(np.asarray, jax.tree.leaves((drawn, plans))), keys)
        carry = self.begin(arguments)
        for first in self.starts:
            results = self.chunk((*carry, np.int64(first), *arguments), asked)
            carry, records = results[: len(carry)], results[len(carry) :]
            counted, rows = jax.tree.map(records.__getitem__, self.records)
            yield jax.tree.map(carry.__getitem__, self.seen), counted, rows


def program_of(
    structure: Structure, plans: Plans, *, parts: int = 0, verify: bool = False
) -> Program:
    """Program of a scenario: from the cache, or traced, compiled and stored.

    A program with a component that is not of this package is always traced and never stored.

    Args:
        structure: Structure of the scenario.
        plans: Designs; only the shapes and types of their numbers are used.
        parts: Number of parts of a run whose noise has its own random key; 0: one key for the run.
        verify: Trace the program in any case and compare it with the stored one.

    Raises:
        InputError: There is no compiler, the engine does not support the scenario, or the stored
            program differs.
    """
    require_compiler()
    cache = private_cache() if is_shipped(structure) else None
    name = program_name(structure, plans, parts)
    content = None if cache is None else cache.read(name)
    stored = None if content is None else pickle.loads(content)
    if stored is not None and not verify:
        libraries = [stored_library(part.library) for part in (stored.begin, stored.chunk)]
        if None not in libraries:
            return load(structure, stored, *libraries)
    traces, metrics, records = trace(structure, plans, parts)
    begin, chunk = map(_part, traces)
    entry = Stored(begin, chunk, metrics, records)
    if verify and stored is not None and [*stored[:2]] != [*entry[:2]]:
        raise InputError(
            f"{cache and cache.path}: found a stored program {name} that differs from a new trace, "
            "expected the same (`gyrostat cache --clear` removes it); please report this"
        )
    traced_begin, traced_chunk = traces
    with ThreadPoolExecutor(1) as pool:  # the compiler is another process
        begin_future = pool.submit(library, traced_begin.text)
        chunk_library = library(traced_chunk.text)
    program = load(structure, entry, begin_future.result(), chunk_library)
    if cache is not None:
        cache.write(name, pickle.dumps(entry))
    return program


def program_name(structure: Structure, plans: Plans, keys: int, kind: str = "lanes") -> str:
    """Name of the stored program in the cache.

    Args:
        structure: Structure of the scenario.
        plans: Designs; only the shapes and types of their numbers are used.
        keys: See `parts` of `program_of`.
        kind: Start of the name: "lanes" for compiled C, "kernel" for texts, which no compiler made.
    """
    leaves, tree = jax.tree.flatten(plans)
    # the platform does not change the C code
    options = {
        key: value
        for key, value in os.environ.items()
        if key.startswith("JAX_") and key != "JAX_PLATFORMS"
    }
    parts = (
        *(structure, keys, tree, [(np.shape(leaf), np.result_type(leaf)) for leaf in leaves]),
        engine_record("cpu", FLAGS["cpu"], "native" if kind == "lanes" else "jax"),
        sorted(options.items()),
    )
    return f"{kind}-program-{hashlib.sha256(repr(parts).encode()).hexdigest()}"


def trace(structure: Structure, plans: Plans, parts: int) -> tuple[tuple[Traced, Traced], Any, Any]:
    """Functions of the initialisation and of a chunk as C, and trees of places; see `Stored`.

    Args:
        structure: Structure of the scenario.
        plans: Designs; only the shapes and types of their numbers are used.
        parts: See `program_of`.

    Raises:
        InputError: The scenario contains an operation that is not supported.
    """
    make, length = loop_of(structure), runner_of(structure).length

    def begin(*arguments: Any) -> Any:
        return make(*arguments).begin()

    def chunk(carry: Any, first: Any, *arguments: Any) -> Any:
        return make(*arguments).scan(carry, first, length)

    key = jax.ShapeDtypeStruct((1, parts) if parts else (1,), jax.random.key(0).dtype)
    orbit = plans.orbit if has_own_orbits(structure.dispersed) else None
    drawn = Drawn(
        np.zeros((1, len(structure.dispersed))),
        jax.tree.map(lambda leaf: np.zeros((1, *np.shape(leaf))), orbit),
    )
    arguments = (np.zeros(len(structure.keys)), drawn, plans, key)
    traced_begin = traced(begin, OWN, arguments)
    carry = jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((1, *leaf.shape), leaf.dtype), traced_begin.results
    )
    traced_chunk = traced(
        chunk, (True, False, *OWN), (carry, 0, *arguments), on_demand=(False, ON_DEMAND)
    )
    (_, metrics), records = (_places(results) for results in traced_chunk.results)
    return (traced_begin, traced_chunk), metrics, records


def _places(tree: Any) -> Any:
    """Tree in which each leaf is replaced by its place in the list of leaves."""
    leaves, structure = jax.tree.flatten(tree)
    return jax.tree.unflatten(structure, range(len(leaves)))


def _part(each: Traced) -> Part:
    digest = hashlib.sha256(each.text.encode()).hexdigest()
    return Part(digest, library_name(each.text), each.layout)


def load(structure: Structure, stored: Stored, *libraries: Any) -> Program:
    """Program from what is stored of it and its loaded libraries.

    Args:
        structure: Structure of the scenario.
        stored: What is stored.
        libraries: Libraries of the initialisation and of a chunk.
    """
    begin, chunk = (
        Compiled(part.layout, each) for part, each in zip(stored[:2], libraries, strict=True)
    )
    starts = runner_of(structure).starts
    return Program(begin, chunk, stored.seen, stored.records, starts, stored)
