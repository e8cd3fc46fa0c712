"""Bounds of instructions and stack of random C programs against counts on simulated processors.

    python benchmarks/soak_bounds.py [--programs 200] [--seed 0]

Each program has three functions of loops in loops (counted, falling, of a length that depends on an
outer counter, with an early end), branches on data, switches, calls, copies of structs and arrays
that are set to zero. It is compiled for Cortex-M4F or Cortex-M7 with -O1, -Os, -O2 or -O3, and run
with 60 arguments, which are special values of floating-point numbers among others. Prints how much
larger the bounds are than the largest counts, and the programs without a bound, such as those in
which the compiler has made a loop with several entries. Exits with 1 if a count is above its bound.
"""

import argparse
import random
import shutil
import subprocess
import sys
import tempfile
import time
from itertools import chain
from pathlib import Path

import numpy as np

from gyrostat.codegen import bounds
from gyrostat.core.files import write_texts
from gyrostat.exports.evidence.board import board_files, counting_code

M4 = ("cortex-m4", "fpv4-sp-d16", "mps2-an386", "0x21000000")
M7 = ("cortex-m7", "fpv5-d16", "mps2-an500", "0x60000000")
"""Names of the processor, of its FPU and of the simulated board, and the address of its PSRAM."""


def missing_tools():
    """Programs that are needed and not installed."""
    tools = ("arm-none-eabi-gcc", "arm-none-eabi-objdump", "qemu-system-arm")
    return [tool for tool in tools if shutil.which(tool) is None]


class Board:
    """Programs for a simulated board, in one folder.

    Attributes:
        folder: The folder.
        painted: Words of the stack whose use is seen.
    """

    def __init__(self, folder, painted=512):
        self.folder, self.painted = folder, painted
        write_texts(folder, board_files())

    def build(self, processor, code, main, names, *options, include=""):
        """Program of the file code.c, with lines and frames, and a main; functions are counted."""
        cpu, fpu, _, psram = processor
        self.processor = processor
        heads = [f"int {name}({arguments})" for name, arguments in names.items()]
        declared = "\n".join(f"{head};" for head in heads)
        texts = {"code.c": code, "main.c": f"#include <stdint.h>\n{include}{declared}\n{main}"}
        write_texts(self.folder, {**texts, "count.c": counting_code(include, heads)})
        flags = ("-std=c99", "-mthumb", f"-mcpu={cpu}", f"-mfpu={fpu}", "-mfloat-abi=hard")
        command = ("arm-none-eabi-gcc", *flags, "-ffp-contract=off", f"-DPAINTED={self.painted}")
        self._run(*command, *options, "-g", "-fstack-usage", "-c", "code.c", "-o", "code.o")
        wrapped = [f"-Wl,--wrap={name}" for name in names]
        files = ("main.c", "count.c", "board.c", "code.o", "-lm", "-o", "program")
        options = ("-Os", "-nostartfiles", "--specs=rdimon.specs", "-T", "board.ld")
        wrapped.append(f"-Wl,--defsym=psram={psram}")
        self._run(*command, *wrapped, *options, *files)

    def counts(self):
        """Function -> largest count of instructions, bytes of stack."""
        printed = self._run(
            *("qemu-system-arm", "-M", self.processor[2], "-nographic", "-monitor", "none"),
            *("-semihosting-config", "enable=on,target=native", "-icount", "shift=9"),
            *("-kernel", "program"),
        )
        rows = (row.split("\t") for row in printed.splitlines())
        return {name: (int(count), int(stack)) for _, name, count, stack in rows}

    def bounds(self, counted=None):
        """Function of the program -> bounds of its instructions and of its stack."""
        listing = bounds.read_listing(self._run("arm-none-eabi-objdump", "-d", "-l", "program"))
        loops = bounds.c_loops((self.folder / "code.c").read_text(encoding="utf-8"))
        frames = bounds.frames((self.folder / "code.su").read_text(encoding="utf-8"))
        instructions = bounds.Instructions(listing, "code.c", loops, counted or {})
        stack = bounds.Stack(listing, frames)
        names = [name for name in listing.symbols.values() if name.startswith("call_")]
        return {
            name.removeprefix("call_"): (instructions.bound(name), stack.bound(name))
            for name in names
        }

    def _run(self, *words):
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, timeout=100)
        assert done.returncode == 0, done.stderr
        return done.stdout


HEAD = """
#include <stdint.h>
typedef struct { double x[20]; } Block;
static Block blocks[3];
static double table[16][16];
"""
FUNCTIONS = ("first", "second", "third")
VALUES = (
    *("0.0", "-0.0", "1.0", "-2.5", "1e3", "-1e9", "1e300", "-1e-300", "0x1p-1074", "1.0 / 0.0"),
    *("-1.0 / 0.0", "0.0 / 0.0", "3.0", "4.0", "5.0", "7.0"),
)


class Program:
    """A random program.

    Attributes:
        text: C of its functions.
    """

    def __init__(self, draw):
        self._draw = draw
        self._names = 0
        self.text = HEAD
        for number, name in enumerate(FUNCTIONS):
            self._callees = FUNCTIONS[:number]
            body = self._block(2, [], 1)
            self.text += f"int {name}(double *x)\n{{\n{body}    return 0;\n}}\n"

    def _block(self, depth, counters, indent):
        count = self._draw.randint(1, 3)
        return "".join(self._statement(depth, counters, "    " * indent) for _ in range(count))

    def _statement(self, depth, counters, margin):
        draw, inner = self._draw, len(margin) // 4 + 1
        kinds = ["assign", "assign", "store", "copy", "call"]
        if depth:
            kinds += ["loop", "loop", "falling", "triangle", "stopping", "branch", "switch"]
        kind = draw.choice(kinds)
        if kind == "store":
            place = draw.choice(counters or ["3"])
            return f"{margin}table[{place}][{draw.randrange(16)}] += *x;\n"
        if kind == "copy":
            return f"{margin}blocks[{draw.randrange(3)}] = blocks[{draw.randrange(3)}];\n"
        if kind == "call" and self._callees and depth == 2:
            return f"{margin}{draw.choice(self._callees)}(x);\n"
        if kind in ("assign", "call"):
            term = draw.choice(["*x", "table[1][2]", *(f"(double){c}" for c in counters)])
            return f"{margin}*x = *x {draw.choice('+-*/')} {term};\n"
        if kind == "branch":
            tests = ("*x > 1.0", "*x < 1e6", "table[2][3] == 0.0", *(f"{c} > 2" for c in counters))
            yes, no = (self._block(depth - 1, counters, inner) for _ in range(2))
            test = draw.choice(tests)
            return f"{margin}if ({test}) {{\n{yes}{margin}}} else {{\n{no}{margin}}}\n"
        if kind == "switch":
            cases = [
                f"{margin}case {k}:\n{self._block(depth - 1, counters, inner)}{margin}    break;\n"
                for k in range(draw.randint(3, 6))
            ]
            test = "(*x >= 0.0 && *x < 9.0) ? (int)*x : -1"
            return (
                f"{margin}switch ({test}) {{\n{''.join(cases)}{margin}default: break;\n{margin}}}\n"
            )
        return self._loop(kind, depth, counters, margin)

    def _loop(self, kind, depth, counters, margin):
        self._names += 1
        counter, limit = f"k{self._names}", self._draw.randint(1, 15)
        body = self._block(depth - 1, [*counters, counter], len(margin) // 4 + 1)
        head = f"int64_t {counter} = 0; {counter} < {limit}; ++{counter}"
        if kind == "falling":
            head = f"int64_t {counter} = {limit}; {counter} >= 0; --{counter}"
        elif kind == "triangle" and counters:
            head = f"int64_t {counter} = 0; {counter} <= {counters[-1]}; ++{counter}"
        elif kind == "stopping":
            body = f"{margin}    if (!(*x < 1e6)) {{ break; }}\n{body}"
        return f"{margin}for ({head}) {{\n{body}{margin}}}\n"


def main_of(draw):
    """Main function that calls each function with 60 arguments."""
    values = [*VALUES, *(repr(draw.gauss(0.0, 10.0)) for _ in range(60 - len(VALUES)))]
    calls = "".join(f"x = values[k]; {name}(&x); " for name in FUNCTIONS)
    return (
        f"int main(void)\n{{\n    static const double values[] = {{{', '.join(values)}}};\n"
        f"    for (unsigned k = 0u; k < 60u; ++k) {{ double x; {calls}}}\n    return 0;\n}}\n"
    )


def check(board, seed):
    """Ratios of bounds to counts of instructions and of stack; what has no bound; what is above."""
    draw = random.Random(seed)
    processor, optimisation = draw.choice((M4, M7)), draw.choice(("-O1", "-Os", "-O2", "-O3"))
    text = Program(draw).text
    names = dict.fromkeys(FUNCTIONS, "double *x")
    board.build(processor, text, main_of(draw), names, optimisation)
    where = f"seed {seed}, {processor[0]} {optimisation}"
    try:
        counts, limits = board.counts(), board.bounds()
    except bounds.UnboundedError as error:
        return [], [f"{where}: {error}"], []
    ratios, wrong = [], []
    for name, (count, stack) in counts.items():
        bound, depth = limits[name]
        ratios.append((bound.any / count, depth / max(stack, 1)))
        if count > bound.any or stack > depth:
            wrong.append(f"{where}: {name} is above its bound")
    return ratios, [], wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    missing = missing_tools()
    if missing:
        print(f"not run: {', '.join(missing)} not installed")
        return 0
    begin = time.monotonic()
    ratios, unbounded, wrong = [], [], []
    for seed in range(options.seed, options.seed + options.programs):
        with tempfile.TemporaryDirectory() as folder:
            results = check(Board(Path(folder)), seed)
        for total, part in zip((ratios, unbounded, wrong), results, strict=True):
            total += part
        for line in chain(*results[1:]):
            print(line)
    quartiles = np.quantile(ratios, (0.0, 0.25, 0.5, 0.75, 1.0), axis=0)
    print("bound over largest count    least  quartile  median  quartile  largest")
    for title, column in zip(("instructions", "stack"), quartiles.T, strict=True):
        print(f"{title:25}" + "".join(f"{value:9.2f}" for value in column))
    seconds = time.monotonic() - begin
    print(
        f"{options.programs} programs, {len(unbounded)} without a bound, {len(wrong)} counts above "
        f"their bounds, {seconds:.0f} s"
    )
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
