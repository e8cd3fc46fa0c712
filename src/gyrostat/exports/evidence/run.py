"""Runs the evidence of a flight folder."""

import shutil
from pathlib import Path

from gyrostat.codegen.simd import run_compiler
from gyrostat.core.errors import InputError
from gyrostat.exports.evidence.results import Result, read_results


def run_evidence(folder: Path) -> tuple[Result, ...]:
    """Run all scripts of evidence, as `make evidence` does, and read their results.

    Args:
        folder: Flight folder.

    Raises:
        InputError: There is no shell.
    """
    if shutil.which("sh") is None:
        raise InputError("--evidence: found no sh, expected a POSIX shell")
    run_compiler(["sh", str((folder / "evidence" / "run.sh").absolute())])
    return read_results(folder)
