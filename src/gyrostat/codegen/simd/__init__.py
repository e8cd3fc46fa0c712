"""Runs side by side in compiled C: what JAX traces of one run, at the speed of vector instructions.

`gyrostat.codegen.simd.batch` has what compiles and calls; it needs JAX, which this package does not
load.
"""

from gyrostat.codegen.simd.compiler import (
    FLAGS,
    compiler,
    compiler_version,
    instructions,
    run_compiler,
)

__all__ = ["FLAGS", "compiler", "compiler_version", "instructions", "run_compiler"]
