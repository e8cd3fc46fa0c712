"""Emitted C beside compiled JAX: nanoseconds a step, bytes of code and of stack.

    OMP_NUM_THREADS=1 python benchmarks/flight_code.py [--steps 2000000]

The compensator of Carrara and Kuga's table with its Kalman filter, and the wheel that it drives,
each in a loop of its own with its own state. The C loop is timed by the processor's clock in the
program itself; JAX runs the same steps as one compiled scan. Each takes the best of three runs.
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from flight_modules import PERIOD, WHEEL, compensator

from gyrostat.codegen.flight.measure import FLAGS, measure
from gyrostat.codegen.simd import compiler
from gyrostat.control import Guarded
from gyrostat.core.files import write_texts
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import files, targets

COMPENSATOR = compensator()

LOOP = """
#include "{name}.h"
#include <math.h>
#include <stdio.h>
#include <time.h>

int main(void)
{{
    {declared}
    double best = INFINITY;
    {parameters}
    for (int run = 0; run < 3; ++run) {{
        {start}
        const clock_t begin = clock();
        for (long k = 0; k < {steps}; ++k) {{
            const double angle = 0.001 * (double)(k % 6283);
            {step}
        }}
        best = fmin(best, (double)(clock() - begin) / CLOCKS_PER_SEC / {steps} * 1e9);
    }}
    printf("%.1f", best);
    return 0;
}}
"""
SNIPPETS = {
    "compensator": {
        "declared": "EstimatingCompensator c; MeasurementGuard g; GuardedMemory m;"
        " EstimatingCommand out; SampleReport report;",
        "parameters": "compensator_parameters(&c, &g);",
        "start": f"compensator_start(&c, {PERIOD}, &m);",
        "step": "const TableMeasurement seen = {1e-3 * angle, 1e-4, 3.0 - angle};"
        " compensator_step(&c, &g, &m, &seen, &out, &report);",
    },
    "wheel": {
        "declared": "Wheel w; double speed; bool resolved;",
        "parameters": "wheel_parameters(&w);",
        "start": "speed = -1.0;",
        "step": f"wheel_step(&w, &speed, 0.1 * (angle - 3.0), 0.0, {PERIOD}, &resolved);",
    },
}


def in_c(target, texts, steps, optimisation):
    """Nanoseconds a step."""
    name = target.name
    with tempfile.TemporaryDirectory() as folder:
        loop = LOOP.format(name=name, steps=steps, **SNIPPETS[name])
        write_texts(Path(folder), {**texts, "loop.c": loop})
        command = [*compiler(), *FLAGS.split(), optimisation, "loop.c", f"{name}.c", "-lm"]
        subprocess.run([*command, "-o", "loop"], cwd=folder, check=True)
        done = subprocess.run([f"{folder}/loop"], capture_output=True, text=True, check=True)
    return float(done.stdout)


def in_jax(target, steps):
    """Nanoseconds a step of the same loop as one scan."""
    angle = 0.001 * (np.arange(steps) % 6283)
    (step,) = target.steps
    if target.name == "compensator":
        guard = step.arguments["guard"]
        first_input = jax.tree.map(lambda values: values[0], target.inputs["measurement"])

    def compensate(memory, angle):
        seen = first_input._replace(attitude=1e-3 * angle, rate=jnp.array(1e-4), speed=3.0 - angle)
        memory, command, _ = step.function(COMPENSATOR, guard, memory, seen)
        return memory, command.current

    def move(speed, angle):
        speed, resolved = step.function(WHEEL, speed, 0.1 * (angle - 3.0), 0.0, PERIOD)
        return speed, resolved

    body, first = (
        (compensate, Guarded(COMPENSATOR, guard).start(PERIOD))
        if target.name == "compensator"
        else (move, jnp.array(-1.0))
    )
    run = jax.jit(lambda angle: jax.lax.scan(body, first, angle)[0])
    jax.block_until_ready(run(angle))
    best = np.inf
    for _ in range(3):
        begin = time.process_time()
        jax.block_until_ready(run(angle))
        best = min(best, (time.process_time() - begin) / steps * 1e9)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=2_000_000)
    steps = parser.parse_args().steps
    for target in (targets.compensator(COMPENSATOR, PERIOD), targets.wheel(WHEEL, PERIOD)):
        texts = files(target, "double", "")
        made = measure(texts, target.name)
        print(f"{target.name}: {made.code} bytes of code, stack {dict(made.stack)} with -Os")
        for optimisation in ("-Os", "-O2"):
            print(f"  C {optimisation}: {in_c(target, texts, steps, optimisation):.0f} ns a step")
        print(f"  JAX: {in_jax(target, steps):.0f} ns a step")


if __name__ == "__main__":
    main()
