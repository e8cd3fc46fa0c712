"""Persistent store of JAX's compiled programs in the private cache.

JAX's own store does not verify what it reads and does not write entries atomically, and other
users can read its folders. XLA may crash on a damaged program, or run it.
"""

import contextlib
import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from gyrostat.core.cache import Cache, named_folder, private_cache

__all__ = ["compiled_anew", "keep_programs", "use_private_cache"]

_reading = True


def keep_programs(say: Callable[[str], None]) -> None:
    """Open the private cache and ignore `JAX_COMPILATION_CACHE_DIR`; call before JAX is imported.

    Args:
        say: See `gyrostat.core.cache.private_cache`.
    """
    private_cache(say)
    os.environ.pop("JAX_COMPILATION_CACHE_DIR", None)


def use_private_cache(jax: Any) -> None:
    """Let JAX store the programs of this process in the private cache.

    If `JAX_COMPILATION_CACHE_DIR` names another folder, JAX uses that one. JAX has no public way to
    replace the store. If a release of JAX lacks the internal function used here, programs are not
    stored.

    Args:
        jax: The imported module.
    """
    folder, root = jax.config.jax_compilation_cache_dir, named_folder()
    if folder and (root is None or Path(folder) != root.resolve() / "jax"):
        return
    cache, module = private_cache(), sys.modules.get("jax._src.compilation_cache")
    if cache is None or not hasattr(module, "get_file_cache"):
        jax.config.update("jax_compilation_cache_dir", None)
        return
    store = _Store(cache)
    module.get_file_cache = lambda path: (store, path)  # pyright: ignore
    jax.config.update("jax_compilation_cache_dir", str(cache.path / "jax"))
    # XLA's own files (autotuning on GPUs) would be read unverified
    jax.config.update("jax_persistent_cache_enable_xla_caches", "none")
    if "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS" not in os.environ:
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.05)


@contextlib.contextmanager
def compiled_anew() -> Iterator[None]:
    """Compile every program anew, although the store may have it."""
    global _reading
    _reading = False
    try:
        yield
    finally:
        _reading = True


class _Store:
    """Store with the methods that JAX calls, as in `jax._src.compilation_cache_interface`."""

    def __init__(self, cache: Cache):
        self._cache, self._path = cache, cache.path

    def get(self, key: str) -> bytes | None:
        return self._cache.read(_entry(key)) if _reading else None

    def put(self, key: str, value: bytes) -> None:
        self._cache.write(_entry(key), value)


def _entry(key: str) -> str:
    return f"jax-{hashlib.sha256(key.encode()).hexdigest()}"
