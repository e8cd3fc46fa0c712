"""Instructions and stack of the C of `controller_programs.py` on Cortex-M4F and Cortex-M7.

    python benchmarks/program_instructions.py [NAME ...] [--precision float] [--steps 200]

Prints for each program and processor the bound of the instructions of a step, the bound without
subnormal operands, the largest count on the simulated processor, and their ratio; the bound of the
stack and the bytes that were used. Exits with 1 if a count is above its bound.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from controller_programs import PROGRAMS
from soak_bounds import M4, M7, Board, missing_tools
from step_timing import MAIN, harness

from gyrostat.codegen.bounds.angles import angles
from gyrostat.codegen.flight import emit
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import prototype
from gyrostat.exports.evidence.board import board_file

RUN = "\nint main(void)\n{{\n    for (long k = 0; k < {}; ++k) {{ step(k); }}\n    return 0;\n}}\n"


def reduction(board, processor, real):
    """Largest count of the reduction of an angle, of the angles that take long."""
    suffix = "" if real == "double" else "f"
    name = f"__kernel_rem_pio2{suffix}"
    rows = [angle.hex() for angle in angles(real)]
    text = f"static const {real} angles[{len(rows)}] = {{{', '.join(rows)}}};\n"
    (board.folder / "angles.h").write_text(text, encoding="utf-8")
    arguments = {name: f"{real} *x, {real} *y, int e0, int nx, int prec, const int32_t *digits"}
    main = board_file("angles.c", real=real, tangent=f"tan{suffix}")
    board.build(processor, "", main, arguments, "-I.")
    return {name: board.counts()[name][0]}


def measured(name, real, steps):
    """Rows of the table, and what is above its bound."""
    program, entry = PROGRAMS[name](), f"{name}_step"
    module = emit(name, [program.entry(entry)], real)
    start = harness(module, entry, program.arguments, program.inputs, real).removesuffix(MAIN)
    head = " ".join(prototype(entry, module.ports[entry], Dialect(real)).split())
    arguments = {entry: head.partition("(")[2].removesuffix(")")}
    for title, processor in (("M4F", M4), ("M7", M7)):
        with tempfile.TemporaryDirectory() as folder:
            board = Board(Path(folder), painted=8192)
            counted = reduction(board, processor, real)
            (Path(folder) / f"{name}.h").write_text(module.header, encoding="utf-8")
            main = start + RUN.format(steps)
            include = f'#include "{name}.h"\n'
            board.build(processor, module.source, main, arguments, "-Os", "-I.", include=include)
            count, used = board.counts()[entry]
            bound, stack = board.bounds(counted)[entry]
            wrong = count > bound.any or used > stack
            print(
                f"{name:22s} {title:3s} {bound.any:10d} {bound.normal:10d} {count:10d} "
                f"{bound.any / count:6.2f} {bound.normal / count:6.2f} {stack:6d} {used:6d}",
                "above its bound" if wrong else "",
                flush=True,
            )
            yield wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", default=list(PROGRAMS), metavar="NAME")
    parser.add_argument("--precision", choices=["double", "float"], default="double")
    parser.add_argument("--steps", type=int, default=200, help="steps that are counted")
    options = parser.parse_args()
    if missing := missing_tools():
        print(f"not run: {', '.join(missing)} not installed")
        return 0
    print("program                CPU      bound     normal      count   ratios      stack   used")
    wrong = False
    for name in options.names:
        wrong |= any([*measured(name, options.precision, options.steps)])
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
