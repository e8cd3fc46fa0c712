"""WebAssembly of C modules, run by Node, and functions of NumPy that are traced by JAX."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from gyrostat.codegen.numpy_tracing import with_jax
from gyrostat.codegen.simd import web
from gyrostat.codegen.simd.batch import traced
from gyrostat.codegen.simd.web import web_assembly, web_compiler
from gyrostat.codegen.simd.words_read import words_read
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

DRIVER = """
const { readFileSync } = require("fs"), own = JSON.parse(process.argv[2]);
const module = new WebAssembly.Module(readFileSync(process.argv[1]));
const { exports } = new WebAssembly.Instance(module, {});
const from = (exports.__heap_base.value + 15) & ~15;
exports.memory.grow(1);
const words = new Float64Array(exports.memory.buffer, from, 20);
words.set(own);
exports.work(1n, 1n, from + 80, from, from + 80, 0, 0, from + 144);
const imports = WebAssembly.Module.imports(module).length;
console.log(JSON.stringify({ imports, made: [...words.subarray(10, 14)] }));
"""


def work(x, y):
    # a branch, functions of the C library and a loop
    return jnp.where(x > y, jnp.sin(x), jnp.exp(y)), jax.lax.fori_loop(
        0, 100, lambda k, total: total + jnp.cos(k * x) / (1.0 + y * y), 0.0
    )


def test_two_runs_by_node_are_those_of_numpy(tmp_path):
    if web_compiler() is None or shutil.which("node") is None:
        pytest.skip("neither zig (ziglang) nor clang with wasi-libc, or no node")
    x, y = np.array([0.3, -2.0]), np.array([-1.0, 0.7])
    code = traced(work, (True, True), (x, y))
    path = tmp_path / "work.wasm"
    path.write_bytes(web_assembly({"work": code.text}))
    inputs = json.dumps([*x, *y])  # (words, lanes)
    command = ["node", "-e", DRIVER, str(path), inputs]
    answer = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    expected = np.where(x > y, np.sin(x), np.exp(y)), np.cos(np.outer(np.arange(100), x)).sum(0)
    assert answer["imports"] == 0
    first, second = np.reshape(answer["made"], (2, 2))
    np.testing.assert_allclose(first, expected[0], rtol=1e-14)
    np.testing.assert_allclose(second, expected[1] / (1.0 + y * y), rtol=1e-13)


def used(shared, table, own):
    # shared[1] and own[0] are never used; all of the table may be
    return shared[0] * own[1] + table[own[2].astype(int)] + shared[2]


def test_words_that_a_program_reads_and_uses():
    arguments = np.zeros(3), np.zeros(200), np.zeros((1, 3))
    code = traced(used, (False, False, True), arguments)
    assert words_read(code.text) == ({0, 2, 3}, {1, 2})


def test_without_a_compiler_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setattr(web, "web_compiler", lambda: None)
    with pytest.raises(InputError, match=r"--fly: .*pip install 'ziglang.*; or install clang"):
        web_assembly({})


def test_a_text_that_is_no_c_is_told_in_one_line():
    if web_compiler() is None:
        pytest.skip("neither zig (ziglang) nor clang with wasi-libc")
    with pytest.raises(InputError, match=r"found .*error: .* from .*, expected it to compile"):
        web_assembly({"wrong": "int f(void) { return nothing; }"})


def statistics(memory, count):
    largest = np.where(count > 0, np.maximum(memory["a"], 1.0), np.nan)
    norm = np.linalg.norm(memory["b"], axis=-1)
    return [largest, np.round(norm) / count.astype(float), np.isfinite(memory["b"])[..., 0]]


def test_a_function_of_numpy_is_traced_as_numpy_computes_it():
    count = np.array([0, 3])
    memory = {"a": np.array([5.0, 0.2]), "b": np.array([[3.0, 4.4], [np.inf, 1.0]])}
    with np.errstate(divide="ignore"):
        expected = statistics(memory, count)
    for each, other in zip(jax.jit(with_jax(statistics))(memory, count), expected, strict=True):
        np.testing.assert_array_equal(each, other)
