"""Emitted C as functions of NumPy arrays, compiled by the compiler of this machine."""

import ctypes
import os
import shutil
import subprocess

import numpy as np
import pytest

from gyrostat.codegen.flight import Entry, emit
from gyrostat.codegen.flight.module import by_address
from gyrostat.codegen.flight.structs import Leaf, Struct
from gyrostat.core.jax64 import jax

STRICT = ("-std=c99", "-ffp-contract=off", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Wshadow")
STRICT = (*STRICT, "-pedantic", "-Werror")


def compiler():
    """The C compiler; the test is skipped where there is none."""
    wanted = (os.environ.get("CC"), "gcc", "cc", "clang")
    found = next((name for name in wanted if name and shutil.which(name)), None)
    return found or pytest.skip("no C compiler: found none of $CC, gcc, cc, clang")


def build(folder, *arguments):
    """Run the compiler in a folder; what it warns of is an error."""
    command = [compiler(), *STRICT, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


def layout(content, real):
    """The NumPy type of a content."""
    if isinstance(content, Struct):
        members = [(m.name, *_member(m.content, real)) for m in content.members]
        return np.dtype(members, align=True)
    return np.dtype(_member(content, real)[0])


def _member(content, real):
    if isinstance(content, Struct):
        return layout(content, real), ()
    return {"real": real, "integer": "i8", "logical": "?"}[content.kind], content.shape


def leaves(array, content):
    """Views of the leaves of an array of structs, in JAX's order."""
    if isinstance(content, Leaf):
        return [array]
    return [leaf for m in content.members for leaf in leaves(array[m.name], m.content)]


def write(module, folder):
    """Write header and source."""
    (folder / f"{module.name}.h").write_text(module.header, encoding="utf-8")
    (folder / f"{module.name}.c").write_text(module.source, encoding="utf-8")


class Compiled:
    """An emitted module, loaded; every entry runs over many lanes at once."""

    def __init__(self, module, folder, *, precision="double"):
        self.module, self.real = module, "f8" if precision == "double" else "f4"
        write(module, folder)
        self.driver = "\n".join([f'#include "{module.name}.h"', *map(self._loop, module.ports)])
        (folder / "driver.c").write_text(self.driver, encoding="utf-8")
        build(folder, "-shared", "-fPIC", f"{module.name}.c", "driver.c", "-o", "lib.so", "-lm")
        self.library = ctypes.CDLL(str(folder / "lib.so"))

    def _type(self, content):
        if isinstance(content, Struct):
            return content.name
        real = "double" if self.real == "f8" else "float"
        return {"real": real, "integer": "int64_t", "logical": "bool"}[content.kind]

    def _loop(self, entry):
        ports = self.module.ports[entry]
        parameters = ", ".join(f"{self._type(p.content)} *{p.name}" for p in ports)
        given = ", ".join(self._argument(p, k) for k, p in enumerate(ports))
        head = f"void {entry}_lanes(int64_t lanes, const int64_t *step, int *status, {parameters})"
        loop = f"for (int64_t k = 0; k < lanes; ++k) {{ status[k] = {entry}({given}); }}"
        return f"{head};\n{head}\n{{ {loop} }}"

    def _argument(self, port, number):
        place = f"{port.name}[k * step[{number}]"
        if isinstance(port.content, Struct) or by_address(port):
            return f"&{place}]"
        if port.content.shape:
            return f"(void *)&{place} * {int(np.prod(port.content.shape))}]"
        return f"{place}]"

    def __call__(self, entry, arguments):
        """Run over lanes.

        Args:
            entry: its name.
            arguments: name -> tree of arrays, first axis the lane.

        Returns:
            Status (lanes,), and name -> leaves of what C has set, in JAX's order.
        """
        lanes = len(jax.tree.leaves(arguments)[0])
        ports = self.module.ports[entry]
        arrays = [self._array(port, arguments.get(port.name), lanes) for port in ports]
        return self._run(entry, arrays, lanes, [1] * len(ports))

    def sequence(self, entry, arguments, moving):
        """Run step by step: the arguments in `moving` go on, what is given and set stays."""
        lanes = len(jax.tree.leaves(arguments[moving[0]])[0])
        arrays, steps = [], []
        for port in self.module.ports[entry]:
            goes_on = port.name in moving or not port.given
            tree = arguments.get(port.name)
            if not goes_on:
                tree = jax.tree.map(lambda leaf: np.asarray(leaf)[None], tree)
            arrays.append(self._array(port, tree, lanes if goes_on else 1))
            steps.append(int(goes_on))
        status, found = self._run(entry, arrays, lanes, steps)
        assert not status.any()
        return found

    def _array(self, port, tree, lanes):
        shape = port.content.shape if isinstance(port.content, Leaf) else ()
        array = np.zeros((lanes, *shape), layout(port.content, self.real))
        if port.given:
            given = [leaf for leaf in jax.tree.leaves(tree) if np.size(leaf)]
            for place, leaf in zip(leaves(array, port.content), given, strict=True):
                place[...] = leaf
        return array

    def _run(self, entry, arrays, lanes, steps):
        status, steps = np.full(lanes, -1, np.int32), np.array(steps, np.int64)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in (steps, status, *arrays)]
        self.library[f"{entry}_lanes"](ctypes.c_int64(lanes), *pointers)
        found = zip(self.module.ports[entry], arrays, strict=True)
        return status, {p.name: leaves(a, p.content) for p, a in found if p.set}


def results_of(name, functions, arguments, folder, *, precision="double"):
    """Results of functions in flight C for arrays whose first axis is the lane.

    Args:
        name: Name of the module.
        functions: Functions of the arguments, each with a tuple of arrays as result.
        arguments: Name -> array.
        folder: Folder for the C.
        precision: Precision of real numbers.

    Returns:
        Function -> (status, arrays of its results).
    """
    example = {key: array[0] for key, array in arguments.items()}
    entries = []
    for function in functions:
        count = len(jax.eval_shape(function, *example.values()))
        results = tuple(f"result_{k}" for k in range(count))
        entries.append(Entry(function.__name__, function, example, results))
    program = Compiled(emit(name, entries, precision), folder, precision=precision)
    runs = {function: program(function.__name__, arguments) for function in functions}
    return {
        function: (status, [leaves[0] for leaves in found.values()])
        for function, (status, found) in runs.items()
    }
