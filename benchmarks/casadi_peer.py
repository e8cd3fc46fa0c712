"""CasADi's C beside that of this package: size, time to compile, and time of a step.

    python -m venv casadi && casadi/bin/pip install casadi
    python benchmarks/casadi_peer.py --casadi casadi/bin/python [--folder DIR]

The Kalman filter of 15 states, the model predictive controller and the controller of four wheels of
`controller_programs.py`, by `gyrostat.codegen.flight.emit` and by CasADi (`casadi_controllers.py`),
and the filter by hand with loops (`calibrating_filter.c`). Constants are in the code, numbers are
double. All variants first run with the same measurements; their results are compared. Same
compiler and options for all. Times are the smallest of interleaved repetitions. CasADi counts with
the best of its variants in each cell; a cell in which it is better is printed as lost.
"""

import argparse
import resource
import subprocess
import tempfile
from pathlib import Path

import calibrating_filter as calibrating
import controller_programs as programs
import numpy as np
from step_timing import CORTEX_M4, MAIN, built, code_size, constants, harness, nanoseconds, outputs

from gyrostat.codegen.flight import emit
from gyrostat.codegen.flight.measure import FLAGS
from gyrostat.codegen.simd.compiler import require_compiler
from gyrostat.core.jax64 import jax

HERE = Path(__file__).parent
CONTROLLERS = {"filter": "filter", "mpc": "mpc", "four_wheels": "four_wheels_fixed"}
"""Name in CasADi -> program."""
VARIANTS = ("sx", "mx", "mixed")
CLOSENESS = 1e-8
"""Largest accepted difference of a number, relative to its largest value."""

REASONS = {
    ("filter", "size"): "the text has names, and the line of Python of each group of statements",
    ("filter", "step"): "products of 15x15 matrices are loops, which do not leave out the columns "
    "of zeros and ones that arise in the step; CasADi's `sx` is 350 kB of text without them",
    ("four_wheels", "size"): "rotations, inverses and the allocation are written out at each "
    "place, with names and lines of Python; CasADi's `mx` has functions, `sx` short names",
}
"""Controller and cell that is lost -> reason."""

CASADI_MAIN = """
#include <math.h>
int step(const double **arg, double **res, int *iw, double *w, int mem);
int step_work(int *sz_arg, int *sz_res, int *sz_iw, int *sz_w);
static double states[2][{state}], commands[{command}], w[100000];
static int iw[100000], sizes[4];
static const double *arg[1000];
static double *res[1000];
static long last;
static void step_once(long k)
{{
    arg[0] = states[k & 1];
    arg[1] = given[k % {samples}];
    res[0] = states[(k + 1) & 1];
    res[1] = commands;
    step(arg, res, iw, w, 0);
    last = k + 1;
}}
#define step step_once
#include <stdio.h>
static void print(void)
{{
    for (int i = 0; i < {state}; ++i) printf("%.17g ", states[last & 1][i]);
    for (int i = 0; i < {commands}; ++i) printf("%.17g ", commands[i]);
    printf("\\n");
}}
"""


def write_constants(file):
    """File with the constants of the controllers, for CasADi."""
    controller = programs.four_wheels().arguments["controller"]
    law, observer = controller.controller, controller.filter
    wheels = law.spacecraft.wheels
    np.savez(
        file,
        **{name: getattr(law, name) for name in ("turn_gain", "rate_gain", "largest_rate")},
        **{
            name: getattr(observer, name)
            for name in ("attitude_sigma", "angle_walk", "bias_walk", "bias_sigma")
        },
        inertia=law.spacecraft.inertia,
        axes=wheels.axes,
        rotor=wheels.inertia,
        wheel_torque_limit=wheels.torque_limit,
        momentum_limit=wheels.momentum_limit,
        period=calibrating.PERIOD,
        gyro=calibrating.GYRO,
        sensors=calibrating.SENSORS,
        hessian=programs.HESSIAN,
        linear=programs.LINEAR,
        step_size=programs.STEP_SIZE,
        iterations=programs.ITERATIONS,
        torque_limit=programs.TORQUE_LIMIT,
    )


def flat(tree, rows):
    """Numbers of a tree, one row for each step if its leaves have a first axis of steps."""
    shape = (rows, -1)
    leaves = [np.reshape(np.asarray(leaf, float), shape) for leaf in jax.tree.leaves(tree)]
    return np.concatenate(leaves, 1)


def casadi_main(program, command):
    """Main function for C of CasADi."""
    (state, _), (rows,) = program.arguments.values(), program.inputs.values()
    start, samples = flat(state, 1), len(jax.tree.leaves(rows)[0])
    texts = [constants("const double", "given", flat(rows, samples))]
    texts[0] = texts[0].replace("[]", f"[{samples}][{flat(rows, samples).shape[1]}]", 1)
    filled = CASADI_MAIN.format(
        state=start.size, command=max(command, 1), commands=command, samples=samples
    )
    initial = constants("const double", "initial", start).replace("[]", f"[1][{start.size}]", 1)
    begin = "memcpy(states[0], initial, sizeof initial);"
    main = MAIN.replace("const long steps", f"{begin}\n    const long steps", 1)
    return "\n".join(["#include <math.h>", *texts, initial, filled, main])


def variants(name, folder):
    """Name of a variant -> its folder, main file and executables by optimisation."""
    program = programs.PROGRAMS[CONTROLLERS[name]]()
    module = emit(name, [program.entry(f"{name}_step")])
    main = harness(module, f"{name}_step", program.arguments, program.inputs)
    header = {f"{module.name}.h": module.header}
    texts = {"gyrostat": {f"{name}.c": module.source, **header, "main.c": main}}
    if name == "filter":
        by_hand = (HERE / "calibrating_filter.c").read_text(encoding="utf-8")
        texts["by hand"] = {f"{name}.c": by_hand, **header, "main.c": main}
    results = jax.eval_shape(program.function, *program.arguments.values())
    leaves = jax.tree.leaves(results[1]) if len(program.results) > 1 else []
    command = sum(leaf.size for leaf in leaves)
    for variant in VARIANTS:
        source = (folder / f"{name}_{variant}.c").read_text(encoding="utf-8")
        files = {f"{name}.c": source, "main.c": casadi_main(program, command)}
        texts[f"CasADi {variant}"] = files
    made = {}
    for variant, files in texts.items():
        place = folder / f"{name}_{variant}".replace(" ", "_")
        place.mkdir()
        made[variant] = {o: built(place, files, o) for o in ("-O2", "-Os")}
    return made


def compile_seconds(places, file, optimisation, repetitions=5):
    """Processor time to compile each file: the smallest of interleaved repetitions.

    What takes more than 5 s is compiled once.
    """

    def one(place):
        command = [*require_compiler(), *FLAGS.split(), optimisation, "-c", file, "-o", "/dev/null"]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, cwd=place, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    least = {name: one(place) for name, place in places.items()}
    for _ in range(repetitions - 1):
        for name, place in places.items():
            if least[name] < 5.0:
                least[name] = min(least[name], one(place))
    return least


def compare(name, folder):
    """Print the table of one controller."""
    made = variants(name, folder)
    reference = outputs(made["gyrostat"]["-O2"], 60)
    scale = np.max(np.abs(reference), axis=0)
    print(f"\n{name}")
    for variant, paths in made.items():
        found = np.concatenate([outputs(path, 60) for path in paths.values()])
        twice = np.concatenate([reference, reference])
        worst = np.max(np.abs(found - twice) / np.where(scale > 0.0, scale, 1.0))
        print(f"  {variant}: results differ by {worst:.1e}")
        if not worst < CLOSENESS:
            raise SystemExit(f"{name}, {variant}: found other results, expected {CLOSENESS}")
    places, file = {variant: paths["-O2"].parent for variant, paths in made.items()}, f"{name}.c"
    cells = {"text, B": {v: (p / file).stat().st_size for v, p in places.items()}}
    cells["Cortex-M4 -Os, B"] = {v: code_size(p, file, "-Os", CORTEX_M4) for v, p in places.items()}
    for optimisation in ("-O2", "-Os"):
        sizes = {v: code_size(p, file, optimisation) for v, p in places.items()}
        cells[f"code {optimisation}, B"] = sizes
        cells[f"compile {optimisation}, s"] = compile_seconds(places, file, optimisation)
        step = nanoseconds({v: paths[optimisation] for v, paths in made.items()})
        cells[f"step {optimisation}, ns"] = step
    for cell, values in cells.items():
        row(name, cell, values)


def row(name, cell, values):
    """Print a cell of a controller: every variant, and the ratio to the best of CasADi."""
    sizes = {variant: value for variant, value in values.items() if value is not None}
    listed = ", ".join(
        f"{variant} {sizes[variant]:.4g}" if variant in sizes else f"{variant} does not compile"
        for variant in values
    )
    if "gyrostat" not in sizes:
        print(f"  {cell:18s} not run: {CORTEX_M4.split()[0]} is not installed")
        return
    best = min((v for v in sizes if v.startswith("CasADi")), key=lambda v: sizes[v])
    ratio = sizes["gyrostat"] / sizes[best]
    by_hand = sizes["gyrostat"] / sizes["by hand"] if "by hand" in sizes else None
    hand = "" if by_hand is None else f"; {by_hand:.2f} of by hand"
    verdict = "lost" if ratio > 1.0 else "won"
    print(f"  {cell:18s} {verdict:4s} {ratio:6.2f} of {best}{hand}  ({listed})", flush=True)
    if ratio > 1.0:
        kind = next((kind for kind in ("compile", "step") if cell.startswith(kind)), "size")
        print(f"  {'':18s} because {REASONS.get((name, kind), 'of a reason not found yet')}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--casadi", required=True, help="Python with CasADi")
    parser.add_argument("--folder", type=Path, help="keep the C here; must not exist")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary) / "peer"
        folder.mkdir(parents=True)
        write_constants(folder / "constants.npz")
        command = [options.casadi, HERE / "casadi_controllers.py", "constants.npz", "."]
        command[1] = command[1].resolve()
        subprocess.run(command, cwd=folder, check=True)
        for name in CONTROLLERS:
            compare(name, folder)


if __name__ == "__main__":
    main()
