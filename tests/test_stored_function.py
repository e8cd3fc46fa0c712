"""Functions whose machine code outlives the process."""

import numpy as np
import pytest

from gyrostat.core import cache_entries, source_digest, stored_function
from gyrostat.core.cache import private_cache
from gyrostat.core.jax64 import jax, jnp


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("GYROSTAT_CACHE", str(tmp_path / "cache"))
    stored_function._machine.cache_clear()
    yield private_cache(pytest.fail)
    stored_function._machine.cache_clear()


def kept(cache):
    return sorted(
        entry.path.name
        for entry in cache_entries.entries(cache.path)
        if entry.path.name.startswith("jax-function-")
    )


class Counted:
    """Function that counts how often it is traced."""

    def __init__(self):
        self.traced = 0

    def __call__(self, x, y):
        self.traced += 1
        total, _ = jax.lax.scan(lambda s, v: (jnp.sin(s) + v @ y, None), jnp.zeros(()), x)
        return {"total": total, "signs": jnp.sign(x) > 0.0}


def made(counted, *about):
    def function(x, y):
        return counted(x, y)

    return stored_function.stored_function(function, *about)


def test_another_process_gets_the_same_bits_without_tracing(cache):
    first, second = Counted(), Counted()
    x, y = np.random.default_rng(0).standard_normal((2, 5, 3))[0], np.arange(3.0)
    one = made(first)(x, y)
    again = made(second)(x, y)  # a new wrapper knows no more than a new process
    assert (first.traced, second.traced) == (1, 0)
    assert one["total"].tobytes() == again["total"].tobytes()
    np.testing.assert_array_equal(one["signs"], again["signs"])
    np.testing.assert_allclose(one["total"], jax.jit(Counted())(x, y)["total"], rtol=1e-14)


def test_other_shapes_and_other_settings_have_their_own_entry(cache):
    x, y = np.ones((5, 3)), np.ones(3)
    made(Counted())(x, y)
    made(Counted())(x[:4], y)
    made(Counted(), "hold")(x, y)
    assert len(kept(cache)) == 3


def test_other_code_or_another_environment_is_compiled_anew(cache, monkeypatch):
    x, y = np.ones((5, 3)), np.ones(3)
    made(Counted())(x, y)
    monkeypatch.setattr(stored_function, "source_digest", lambda: "other")
    stored_function._machine.cache_clear()
    other = Counted()
    made(other)(x, y)
    monkeypatch.setenv("XLA_FLAGS", "--xla_cpu_enable_fast_math=false")
    stored_function._machine.cache_clear()
    made(Counted())(x, y)
    assert other.traced == 1
    assert len(kept(cache)) == 3


def test_a_damaged_entry_is_compiled_anew(cache):
    x, y = np.ones((5, 3)), np.ones(3)
    one = made(Counted())(x, y)
    (name,) = kept(cache)
    path = cache.path / name
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    other = Counted()
    assert made(other)(x, y)["total"] == one["total"]
    assert other.traced == 1


def test_an_executable_that_computes_something_else_is_not_kept(cache, monkeypatch):
    monkeypatch.setattr(stored_function, "_have_same_bytes", lambda first, second: False)
    made(Counted())(np.ones((5, 3)), np.ones(3))
    assert kept(cache) == []


def test_a_class_of_a_user_is_never_part_of_an_entry(cache):
    class Own:
        pass

    made(Counted(), Own)(np.ones((5, 3)), np.ones(3))
    assert kept(cache) == []


def test_within_another_function_it_is_traced(cache):
    counted = Counted()
    twice = jax.vmap(made(counted), (0, None))(np.ones((2, 5, 3)), np.ones(3))
    assert twice["total"].shape == (2,)
    assert kept(cache) == []


@pytest.mark.parametrize("file", ["lanes.h", "exports/templates/check.c"])
def test_the_digest_of_the_code_covers_files_in_c(file, tmp_path, monkeypatch):
    (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
    digests = set()
    for text in ("#define LANES 8", "#define LANES 4"):
        (tmp_path / file).write_text(text)
        monkeypatch.setattr(source_digest.gyrostat, "__file__", str(tmp_path / "__init__.py"))
        digests.add(source_digest.source_digest.__wrapped__())
    assert len(digests) == 2
