"""Compiled functions of arrays, whose machine code is kept in the private cache.

JAX keeps compiled programs too, but finds them only after it has traced the function, which takes
longer than most fits.
"""

import hashlib
import os
import pickle
import platform
from collections.abc import Callable
from functools import lru_cache
from importlib.metadata import version
from typing import Any

import numpy as np
from jax.core import Tracer

from gyrostat.core.cache import private_cache
from gyrostat.core.instructions import processor
from gyrostat.core.jax64 import jax
from gyrostat.core.jax_cache import compiled_anew
from gyrostat.core.source_digest import source_digest


def stored_function(function: Callable[..., Any], *about: Any) -> Callable[..., Any]:
    """Compile a function of arrays, as `jax.jit` does; its machine code outlives the process.

    In a function that is being traced, and on a GPU, it is a function compiled by `jax.jit`. The
    same is true if the function depends on a class that is not of this package, whose code the name
    of the entry does not cover.

    Args:
        function: Function of arrays that returns a tree of arrays.
        about: What else determines the function: texts and numbers that it uses, and classes.
    """
    compiled = jax.jit(function)
    programs: dict[Any, Callable[..., Any]] = {}
    ours = all(each.__module__.startswith("gyrostat.") for each in about if isinstance(each, type))

    def call(*arguments: Any) -> Any:
        if not ours or any(isinstance(each, Tracer) for each in arguments):
            return compiled(*arguments)
        arrays = [np.asarray(each) for each in arguments]
        types = tuple((each.shape, str(each.dtype)) for each in arrays)
        if types not in programs:
            name = repr((function.__module__, function.__qualname__, about, types))
            programs[types] = _executable(compiled, arrays, name)
        return programs[types](*arrays)

    return call


def _executable(compiled: Any, arrays: list[Any], name: str) -> Callable[..., Any]:
    """Executable of a function for the types of these arguments."""
    from jax.experimental.serialize_executable import deserialize_and_load, serialize

    cache = private_cache() if jax.default_backend() == "cpu" else None
    if cache is None:
        return compiled
    entry = f"jax-function-{hashlib.sha256(f'{name} {surroundings()}'.encode()).hexdigest()}"
    content = cache.read(entry)
    if content is not None:
        return deserialize_and_load(*pickle.loads(content))
    with compiled_anew():  # what JAX has loaded from a store cannot be serialised
        executable = compiled.lower(*arrays).compile()
    content = pickle.dumps(serialize(executable))
    results = deserialize_and_load(*pickle.loads(content))(*arrays)
    if all(map(_have_same_bytes, jax.tree.leaves(executable(*arrays)), jax.tree.leaves(results))):
        cache.write(entry, content)
    return executable


def _have_same_bytes(first: Any, second: Any) -> bool:
    return np.asarray(first).tobytes() == np.asarray(second).tobytes()


def surroundings() -> str:
    """Everything beside a function that determines its machine code: settings, code, processor."""
    # of the environment or made since; JAX's cache has no part in a program
    settings = sorted((k, v) for k, v in jax.config.values.items() if "cache" not in k)
    return f"{settings} {_machine()}"


@lru_cache
def _machine() -> str:
    """Versions, processor and flags of XLA."""
    options = {k: v for k, v in os.environ.items() if k.startswith("XLA_")}
    lines = {
        line for line in processor().splitlines() if line.startswith(("flags", "Features", "model"))
    }
    versions = [version(name) for name in ("jax", "jaxlib", "equinox", "numpy")]
    about = (sorted(options.items()), platform.platform(), sorted(lines))
    return repr((*about, *versions, source_digest()))
