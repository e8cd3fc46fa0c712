"""Entries of the cache: limit, order of removal, clearing."""

import json
import os
import subprocess
import sys

import pytest

from gyrostat.core import cache_entries
from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError

OVERHEAD = 17 + 32  # first line and digest of an entry


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "cache"))
    return private_cache(pytest.fail)


def names(cache):
    return {entry.path.name for entry in cache_entries.entries(cache.path)}


def write(cache, name, size, used):
    cache.write(name, bytes(size - OVERHEAD))
    os.utime(cache.path / name, (used, used))


def test_the_least_recently_used_entries_go_first(cache, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE_LIMIT", "1kB")
    for time, name in enumerate(("lanes-a", "jax-b", "lanes-c")):
        write(cache, name, 300, 1000.0 + time)
    assert cache.read("lanes-a") is not None  # now the last one that was used
    cache.write("jax-d", bytes(300 - OVERHEAD))
    assert names(cache) == {"lanes-a", "lanes-c", "jax-d"}


def test_an_entry_above_the_limit_is_not_kept_and_one_just_below_is(cache, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE_LIMIT", "1000")
    write(cache, "jax-old", 200, 1000.0)
    cache.write("jax-large", bytes(1000 - OVERHEAD))
    assert names(cache) == {"jax-large"}
    cache.write("jax-larger", bytes(1001 - OVERHEAD))
    assert names(cache) == set()


def test_files_of_others_are_neither_counted_nor_removed(cache, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE_LIMIT", "1000")
    notes = cache.path / "notes.txt"
    notes.write_bytes(bytes(5000))
    (cache.path / "jax-link").symlink_to(notes)
    cache.write("lanes-a", bytes(300))
    assert names(cache) == {"lanes-a"}
    assert [entry.kind for entry in cache_entries.clear(cache.path)] == ["native engine"]
    assert notes.stat().st_size == 5000
    assert names(cache) == set()


@pytest.mark.parametrize(
    ("text", "size"),
    [("", 10**9), ("500", 500), ("500MB", 500e6), ("1.5 gb", 1.5e9), ("2 kB", 2000)],
)
def test_limits(monkeypatch, text, size):
    monkeypatch.setenv("GYROSTAT_CACHE_LIMIT", text)
    assert cache_entries.limit() == size


@pytest.mark.parametrize("text", ["much", "-1 MB", "1e9", "1 M", "1 MiB", "nan"])
def test_a_limit_that_is_no_size_is_refused_before_anything_is_compiled(monkeypatch, text):
    monkeypatch.setenv("GYROSTAT_CACHE_LIMIT", text)
    with pytest.raises(InputError, match=r"GYROSTAT_CACHE_LIMIT: found '.*', expected a size"):
        private_cache(pytest.fail)


COMPILING = """
from gyrostat.core.jax64 import jax, jnp
jax.jit(lambda x: jnp.linalg.svd(jnp.sin(x) @ x.T)[1].sum())(jnp.ones((8, 8)))
"""


def test_a_script_keeps_what_jax_compiles_as_the_command_line_does(cache):
    environment = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    environment |= {"JAX_PLATFORMS": "cpu", "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0"}
    subprocess.run([sys.executable, "-c", COMPILING], env=environment, check=True)
    assert any(name.startswith("jax-") for name in names(cache))


def test_the_command_line_shows_and_clears(run, cache):
    cache.write("jax-a", bytes(1000))
    cache.write("lanes-b", bytes(2000))
    code, out, err = run("cache", "--json")
    assert code == 0
    assert "jax" in err.casefold()
    assert json.loads(out)["entries"] == {
        "native engine": {"count": 1, "size": 2000 + OVERHEAD},
        "JAX": {"count": 1, "size": 1000 + OVERHEAD},
        "designs": {"count": 0, "size": 0},
        "exported code": {"count": 0, "size": 0},
        "accelerators": {"count": 0, "size": 0},
    }
    code, out, _ = run("cache", "--clear", "--json")
    assert code == 0
    assert json.loads(out)["removed"] == 2
    assert names(cache) == set()
