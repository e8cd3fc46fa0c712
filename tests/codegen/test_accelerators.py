"""Programs with one run in each work item against JAX, on OpenCL and with a stand-in for CUDA."""

import gc
import importlib.util

import numpy as np
import pytest

from gyrostat.codegen.accelerators import driver
from gyrostat.codegen.accelerators.devices import device as device_of
from gyrostat.codegen.accelerators.program import DeviceProgram, Part
from gyrostat.codegen.accelerators.source import ranks_source, source
from gyrostat.codegen.simd.batch import traced
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.random_keys import words_of
from gyrostat.runs.metrics.percentiles import SortedErrors, ranks
from tests.codegen.stand_in import stand_in

LENGTH, RUNS = 70, 13
RANDOM = np.random.default_rng(3)
TABLE = RANDOM.standard_normal(40)
STARTS = RANDOM.uniform(-2.0, 2.0, RUNS)
KEYS = jax.random.split(jax.random.key(5), RUNS)


def begin(table, start, key):
    """State of a run: a number, a count and whether it is positive."""
    del key
    return start * table[0], jnp.int64(2), start > 0.0


def chunk(state, first, table, start, key):
    """Noise, a table, functions, a branch and a loop of another length in each run."""

    def step(state, k):
        x, count, is_up = state
        noise = jax.random.normal(jax.random.fold_in(key, first + k))
        x = 0.9 * x + 0.1 * table[jnp.abs(count) % 40] + 0.01 * noise
        x = jnp.where(is_up, jnp.sin(x) + jnp.exp(-x * x), jnp.arctan2(x, 1.0 + start**2))
        _, turns = jax.lax.while_loop(
            lambda pair: pair[0] > 0.1, lambda pair: (0.5 * pair[0], pair[1] + 1), (jnp.abs(x), 0)
        )
        x = jax.lax.cond(turns > 2, lambda x: x - 0.3, lambda x: jnp.tanh(x), x)
        error = jnp.where(first + k < 30, jnp.inf, jnp.abs(x))
        return (x, count + turns, x > 0.2), (error, jnp.stack([x, noise]))

    return jax.lax.scan(step, state, jnp.arange(LENGTH))


@pytest.fixture(scope="module")
def parts():
    arguments = (TABLE, STARTS, KEYS)
    first = traced(begin, (False, True, True), arguments)
    state = [jax.ShapeDtypeStruct((RUNS, *leaf.shape), leaf.dtype) for leaf in first.results]
    second = traced(
        chunk,
        (True, False, False, True, True),
        (tuple(state), 0, *arguments),
        on_demand=(False, (False, True)),
    )
    return [Part(each.text, each.layout) for each in (first, second)]


@pytest.fixture(scope="module", params=["stand-in for cuda", "opencl"])
def device(request, tmp_path_factory):
    if request.param == "opencl":
        if importlib.util.find_spec("pyopencl") is None:
            pytest.skip("not run: pyopencl is not installed")
        try:
            yield device_of("opencl")
        except InputError as error:
            pytest.skip(f"not run: {error}")
        return
    with pytest.MonkeyPatch.context() as patch:
        made, loaded = stand_in(tmp_path_factory.mktemp("cuda"), patch)
        yield made
        gc.collect()
        assert loaded.left() == 0


@pytest.fixture(scope="module")
def program(device, parts):
    return DeviceProgram(device, *parts)


@pytest.fixture(scope="module")
def expected():
    """State after each of two chunks, and records, by JAX."""
    state = jax.vmap(begin, (None, 0, 0))(TABLE, STARTS, KEYS)
    fly = jax.jit(jax.vmap(chunk, (0, None, None, 0, 0)))
    results = []
    for first in (0, LENGTH):
        state, records = fly(state, first, TABLE, STARTS, KEYS)
        results.append([*state, *records])
    return results


def arguments(runs=slice(None)):
    return TABLE, STARTS[runs], words_of(KEYS)[runs]


def test_runs_are_those_of_jax(program, expected):
    asked = [1, RUNS - 1]
    chunks = list(program.chunks([0, LENGTH], arguments(), asked))
    assert chunks[0][:3] == [None] * 3
    for ours, theirs in zip(chunks, expected, strict=True):
        rows = np.asarray(theirs[4])[asked]
        np.testing.assert_allclose(ours[3], theirs[3], rtol=1e-12)
        np.testing.assert_allclose(ours[4], rows, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(chunks[1][0], expected[1][0], rtol=1e-12)
    np.testing.assert_array_equal(chunks[1][1], expected[1][1])
    np.testing.assert_array_equal(chunks[1][2], expected[1][2])


@pytest.mark.parametrize("runs", [slice(4, 5), slice(0, 12, 5)])
def test_a_run_has_the_same_bits_in_any_company(program, runs):
    every = list(program.chunks([0, LENGTH], arguments()))[1]
    some = list(program.chunks([0, LENGTH], arguments(runs), [0]))[1]
    for ours, theirs in zip(some[:4], every[:4], strict=True):
        np.testing.assert_array_equal(ours, theirs[runs])


def test_ranked_values_are_those_of_sorted_ones(program):
    chunks = list(program.chunks([0, LENGTH], arguments()))
    errors = SortedErrors(RUNS, 2 * LENGTH)
    for each in chunks:
        errors.add(each[3])
    percents = (0.1, 37.0, 50.0, 95.0, 99.7)
    table = np.stack([ranks(percent, 2 * LENGTH) for percent in percents])
    results, (found,) = program.ranked([0, LENGTH], arguments(), [1], [3], table)
    np.testing.assert_array_equal(results[1], chunks[1][1])
    for percent, values in zip(percents, found, strict=True):
        np.testing.assert_array_equal(values, errors.percentile(percent))
    # in the first 30 samples no error counts
    _, (none,) = program.ranked([-LENGTH], arguments(), [], [3], table[:, : LENGTH + 1])
    assert np.all(np.isnan(none))


def test_wrong_arguments_are_refused(program):
    with pytest.raises(InputError, match=r"found \[13\], expected numbers below 13"):
        next(program.chunks([0], arguments(), [13]))
    with pytest.raises(InputError, match=r"found float64\[39\], expected float64\[40\]"):
        next(program.chunks([0], (TABLE[1:], *arguments()[1:])))


def test_usage_is_one_line(program):
    line = program.kernels()[1].usage.text()
    assert "registers" in line
    assert "private" in line
    assert "\n" not in line


def test_texts_compile_for_a_device_that_is_not_there(parts):
    try:
        driver.compiler_version()
    except InputError:
        pytest.skip("not run: NVRTC is not installed")
    options = ("-arch=sm_90", "-fmad=false", "-std=c++17")
    definitions = {"RECORDS": 1, "WORK_GROUP": 256, "SHARED_WORDS": 41}
    assert b"fly_all" in driver.compiled(source(parts[1].text, definitions), options)
    assert b"ranked" in driver.compiled(ranks_source(256), options)
    with pytest.raises(InputError, match="from NVRTC, expected it to compile"):
        driver.compiled("no C", options)


def test_missing_packages_and_drivers_are_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyopencl", None)
    from gyrostat.codegen.accelerators.opencl import opencl

    opencl.cache_clear()
    with pytest.raises(InputError, match="found no pyopencl, expected the packages of the extra"):
        device_of("opencl")
    opencl.cache_clear()
    with pytest.raises(InputError, match="engine: found 'jax', expected one of opencl, cuda"):
        device_of("jax")


def test_without_a_driver_cuda_is_refused(monkeypatch):
    def none(name):
        raise OSError(name)

    monkeypatch.setattr(driver.ctypes, "CDLL", none)
    driver.driver.cache_clear()
    with pytest.raises(InputError, match="--engine cuda: found no driver"):
        driver.driver()
    driver.driver.cache_clear()
