"""Code size, stack use and single-precision error of emitted C, from the local compiler."""

import re
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gyrostat.codegen.simd import compiler, run_compiler
from gyrostat.core.files import write_texts

FLAGS = "-std=c99 -ffp-contract=off"
"""Flags without which results may differ from Python in the last digits."""
OPTIMISATION = "-Os"


@dataclass(frozen=True)
class Compiled:
    """Measurements of a compiled module.

    Attributes:
        compiler: First line of the compiler's version text.
        code: Size of instructions and constants, bytes; None if the tool `size` is missing.
        stack: Function -> size of its own stack frame, bytes; empty if the compiler does not
            report it.
        errors: Output -> largest error in the test run, relative to the output's largest value.
        fails: Whether the test program fails.
    """

    compiler: str
    code: int | None
    stack: Mapping[str, int]
    errors: Mapping[str, float]
    fails: bool


def measure(files: Mapping[str, str], name: str) -> Compiled | None:
    """Compile a module and run its test program, in a temporary folder.

    Args:
        files: File name -> text.
        name: Name of the module.

    Returns:
        The measurements; None if there is no compiler or it fails.
    """
    program = compiler()
    if program is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        write_texts(Path(folder), files)

        def run(*words: str) -> str | None:
            process = run_compiler(words, Path(folder))
            return process.stdout if process.returncode == 0 else None

        flags = [*FLAGS.split(), OPTIMISATION]
        usage = run(*program, *flags, "-fstack-usage", "-c", f"{name}.c")
        if usage is None and run(*program, *flags, "-c", f"{name}.c") is None:
            return None
        if run(*program, *flags, f"{name}.o", f"{name}_test.c", "-lm", "-o", "test") is None:
            return None
        # exit status 1 means that an output differs from Python: its numbers are still used
        test = run_compiler([str(Path(folder) / "test"), "errors"])
        lines = (line.rpartition(" ") for line in test.stdout.splitlines())
        sizes = run("size", "-A", f"{name}.o") if shutil.which("size") else None
        sections = re.findall(r"^\.(?:text|rodata)\S*\s+(\d+)", sizes or "", re.MULTILINE)
        stack = Path(folder) / f"{name}.su"
        return Compiled(
            compiler=(run(*program, "--version") or program[0]).splitlines()[0],
            code=sum(map(int, sections)) if sections else None,
            stack=_stack(stack.read_text(encoding="utf-8") if stack.exists() else ""),
            errors={output: float(error) for output, _, error in lines},
            fails=test.returncode != 0,
        )


def _stack(text: str) -> dict[str, int]:
    """Function -> stack use in bytes, from the compiler's report."""
    matches = (re.match(r"\S+:(\w+)\S*\t(\d+)\t", line) for line in text.splitlines())
    return {match[1]: int(match[2]) for match in matches if match}
