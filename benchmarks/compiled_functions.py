"""Functions of arrays in compiled code, for batches: flight C, SIMD lanes, or JAX."""

import ctypes
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.flight.measure import FLAGS
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.compiler import require_compiler
from gyrostat.core.jax64 import jax

_TYPES = {"real": "f8", "integer": "i8", "logical": "?"}


def in_flight(function, *examples):
    """Function of batches, the first axis of each argument and result, in flight C with -O2."""
    names = [f"a{k}" for k in range(len(examples))]
    results = [f"r{k}" for k in range(len(jax.eval_shape(function, *examples)))]
    entry = Entry("tested", function, dict(zip(names, examples, strict=True)), tuple(results))
    module = emit("tested", [entry])
    with tempfile.TemporaryDirectory() as folder:
        for ending, text in (("h", module.header), ("c", module.source)):
            (Path(folder) / f"tested.{ending}").write_text(text, encoding="utf-8")
        command = [*require_compiler(), *FLAGS.split(), "-O2", "-shared", "-fPIC", "tested.c"]
        subprocess.run([*command, "-o", "tested.so", "-lm"], cwd=folder, check=True)
        library = ctypes.CDLL(f"{folder}/tested.so")
    contents = [port.content for port in module.ports["tested"]]

    def call(*batches):
        count = len(batches[0])
        arrays = [np.ascontiguousarray(each, float) for each in batches]
        arrays += [
            np.zeros((count, *content.shape), _TYPES[content.kind])
            for content in contents[len(batches) :]
        ]
        for k in range(count):
            library.tested(*(ctypes.c_void_p(each[k : k + 1].ctypes.data) for each in arrays))
        return arrays[len(batches) :]

    return call


def in_lanes(function, *examples):
    """Function of batches in SIMD lanes."""
    batches = tuple(np.asarray(example)[None] for example in examples)
    return lanes(function, (True,) * len(examples), batches)


def by_jax(function, *_):
    """Function of batches by JAX and its library."""
    return jax.jit(jax.vmap(function))


ENGINES = {"flight": in_flight, "native": in_lanes, "jax": by_jax}
"""Name -> function that compiles a function of arrays with a tuple of arrays as result."""
