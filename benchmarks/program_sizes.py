"""Size of the C of `controller_programs.py`, of its code, and time of a step.

    python benchmarks/program_sizes.py [NAME ...] [--folder DIR] [--precision float]

Prints for each the time to generate the C, the size of its text, the size of its code for this
machine and for a Cortex-M4 (without the functions of the library, such as those of arithmetic in
double precision), and the time of a step. The C runs with the measurements of the program before
that, and its results are compared with JAX: the largest difference of a number, relative to its
largest value.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from controller_programs import PROGRAMS
from step_timing import CORTEX_M4, built, code_size, harness, nanoseconds, outputs

from gyrostat.codegen.flight import emit
from gyrostat.core.jax64 import jax


def expected_outputs(program, steps):
    """Results of the first steps by JAX, (steps, numbers)."""
    values, rows = dict(program.entry("step").arguments), []
    function = jax.jit(program.function)
    for k in range(steps):
        values |= {n: jax.tree.map(lambda x, k=k: x[k], v) for n, v in program.inputs.items()}
        results = function(*(values[name] for name in program.arguments))
        several = results if len(program.results) > 1 else (results,)
        values |= dict(zip(program.results, several, strict=True))
        order = dict.fromkeys(
            [*(n for n in program.arguments if n in program.results), *program.results]
        )
        leaves = jax.tree.leaves([values[name] for name in order])
        rows.append(np.concatenate([np.ravel(np.asarray(leaf, float)) for leaf in leaves]))
    return np.array(rows)


def difference(found, expected):
    """Largest difference over the largest value of each column, but for what is zero in both."""
    scale = np.max(np.abs(expected), axis=0)
    return np.max(np.abs(found - expected) / np.where(scale > 0.0, scale, 1.0))


def measured(name, folder, precision, compared):
    """Row of the table.

    Args:
        name: Name of the program.
        folder: Empty folder.
        precision: Precision of real numbers.
        compared: Number of steps that are compared with JAX.
    """
    program, entry = PROGRAMS[name](), f"{name}_step"
    begin = time.perf_counter()
    module = emit(name, [program.entry(entry)], precision)
    took = time.perf_counter() - begin
    start = harness(module, entry, program.arguments, program.inputs, precision)
    texts = {f"{name}.h": module.header, f"{name}.c": module.source, "main.c": start}
    programs = {o: built(folder, texts, o) for o in ("-Os", "-O2")}
    error = difference(outputs(programs["-O2"], compared), expected_outputs(program, compared))
    sizes = [code_size(folder, f"{name}.c", o) for o in programs]
    sizes.append(code_size(folder, f"{name}.c", "-Os", CORTEX_M4))
    step = nanoseconds(programs)
    cells = [f"{'not run' if size is None else size:>8}" for size in sizes]
    cells += [f"{time:8.0f}" for time in step.values()]
    return f"{name:22s} {took:4.1f} {len(module.source) / 1e3:7.1f} {' '.join(cells)}  {error:.1e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", default=list(PROGRAMS), metavar="NAME")
    parser.add_argument("--folder", type=Path, help="keep the C here")
    parser.add_argument("--precision", choices=["double", "float"], default="double")
    parser.add_argument("--steps", type=int, default=40, help="steps that are compared with JAX")
    options = parser.parse_args()
    unknown = set(options.names) - set(PROGRAMS)
    if unknown:
        sys.exit(f"NAME: found {', '.join(sorted(unknown))}, expected {', '.join(PROGRAMS)}")
    print(
        "program        generated, s   C, kB  code, B: -Os  -O2  M4 -Os  step, ns: -Os  -O2  error"
    )
    with tempfile.TemporaryDirectory() as temporary:
        for name in options.names:
            folder = (options.folder or Path(temporary)) / name
            folder.mkdir(parents=True, exist_ok=True)
            print(measured(name, folder, options.precision, options.steps), flush=True)


if __name__ == "__main__":
    main()
