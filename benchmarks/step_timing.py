"""Compile C of controllers in the same way, and measure size and time of a step.

A program is the source of the controller and a main function that calls it with measurements,
which `harness` writes for C of this package.
"""

import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from gyrostat.codegen.flight.measure import FLAGS
from gyrostat.codegen.flight.module import Module, call
from gyrostat.codegen.flight.structs import Struct, scalars
from gyrostat.codegen.simd.compiler import require_compiler
from gyrostat.core.jax64 import jax

CORTEX_M4 = "arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard"
"""Compiler for a processor whose floating-point unit has single precision."""

MAIN = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

int main(int count, char **words)
{
    const long steps = count > 2 ? atol(words[2]) : 1;
    if (count > 2 && strcmp(words[1], "time") == 0) {
        struct timespec from, to;
        for (long k = 0; k < steps / 10; ++k) step(k);
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &from);
        for (long k = 0; k < steps; ++k) step(k);
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &to);
        const double seconds = (double)(to.tv_sec - from.tv_sec);
        printf("%.3f", (1e9 * seconds + (double)(to.tv_nsec - from.tv_nsec)) / (double)steps);
    } else {
        for (long k = 0; k < steps; ++k) { step(k); print(); }
    }
    return 0;
}
"""


def number(value):
    """Literal of a number."""
    value = float(value)
    if np.isnan(value):
        return "NAN"
    return f"{'-' * (value < 0.0)}INFINITY" if np.isinf(value) else repr(value)


def constants(kind, name, values):
    """Static array with the rows of an array."""
    rows = ",\n".join("{" + ", ".join(map(number, np.ravel(row))) + "}" for row in values)
    return f"static {kind} {name}[] = {{\n{rows}\n}};\n"


def harness(module: Module, entry: str, arguments, inputs, real: str = "double") -> str:
    """Main function for C of this package.

    Args:
        module: Emitted module.
        entry: Its entry.
        arguments: Name -> first value.
        inputs: Name -> measurements; the first axis is the step.
        real: C type of real numbers.
    """
    texts, fresh, prints = [f'#include "{module.name}.h"', "#include <math.h>"], [], []
    for port in module.ports[entry]:
        content = port.content
        if isinstance(content, Struct):
            kind, dimension = content.name, ""
        else:
            kind = {"real": real, "integer": "int64_t", "logical": "bool"}[content.kind]
            dimension = "".join(f"[{size}]" for size in content.shape)
        if port.name in inputs:
            leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(inputs[port.name])]
            rows = np.concatenate([leaf.reshape(len(leaf), -1) for leaf in leaves], 1)
            text = constants("const " + kind, f"given_{port.name}", rows)
            texts.append(text.replace("[]", f"[{len(rows)}]{dimension}", 1))
            fresh.append(
                f"memcpy(&{port.name}, &given_{port.name}[k % {len(rows)}], sizeof {port.name});"
            )
        start = ""
        if port.given:
            leaves = jax.tree.leaves(arguments[port.name])
            values = [number(v) for leaf in leaves for v in np.ravel(leaf)]
            start = (
                " = {" + ", ".join(values) + "}"
                if isinstance(content, Struct) or dimension
                else f" = {values[0]}"
            )
        texts.append(f"static {kind} {port.name}{dimension}{start};")
        if port.set:
            for leaf in scalars(content, port.name, False):
                prints += [f'printf("%.17g ", (double)({name.hint}));' for name in leaf.flat]
    texts += [
        "#include <string.h>",
        "#include <stdio.h>",
        "static void step(long k)",
        "{",
        *fresh,
        f"{call(module, entry)};",
        "}",
    ]
    texts += ["static void print(void)", "{", *prints, r'printf("\n");', "}"]
    return "\n".join(texts) + MAIN


def built(
    folder: Path, sources: Mapping[str, str], optimisation: str, more: Sequence[str] = ()
) -> Path:
    """Executable of sources and headers."""
    for file, text in sources.items():
        (folder / file).write_text(text, encoding="utf-8")
    program = folder / f"program{optimisation}"
    files = [file for file in sources if file.endswith(".c")]
    command = [
        *require_compiler(),
        "-D_POSIX_C_SOURCE=200809L",
        *FLAGS.split(),
        optimisation,
        *more,
    ]
    subprocess.run([*command, *files, "-o", program, "-lm"], cwd=folder, check=True)
    return program


def code_size(folder: Path, file: str, optimisation: str, compiler: str = "") -> int | None:
    """Bytes of instructions and constants of a C file; None if it cannot be compiled."""
    command = compiler.split() or list(require_compiler())
    if shutil.which(command[0]) is None:
        return None
    made = folder / f"{file}{optimisation}.o"
    command += [*FLAGS.split(), optimisation, "-c", file, "-o", made]
    if subprocess.run(command, cwd=folder, capture_output=True).returncode != 0:
        return None
    size = "arm-none-eabi-size" if compiler else "size"
    listed = subprocess.run([size, "-A", made], capture_output=True, text=True, check=True).stdout
    return sum(map(int, re.findall(r"^\.(?:text|rodata)\S*\s+(\d+)", listed, re.MULTILINE)))


def outputs(program: Path, steps: int) -> np.ndarray:
    """Results of the first steps, (steps, numbers)."""
    done = subprocess.run(
        [program, "outputs", str(steps)], capture_output=True, text=True, check=True
    )
    return np.array([line.split() for line in done.stdout.splitlines()], float)


def nanoseconds(
    programs: Mapping[str, Path], repetitions: int = 7, span: float = 0.05
) -> dict[str, float]:
    """Time of a step of each program, ns: the smallest of interleaved repetitions."""

    def one(program, steps):
        words = [program, "time", str(steps)]
        return float(subprocess.run(words, capture_output=True, text=True, check=True).stdout)

    steps = {name: max(100, int(1e9 * span / one(path, 200))) for name, path in programs.items()}
    runs = [{n: one(path, steps[n]) for n, path in programs.items()} for _ in range(repetitions)]
    return {name: min(run[name] for run in runs) for name in programs}
