"""Batches of runs in compiled C: one run traced by JAX, executed in each SIMD lane.

`gyrostat.codegen.simd.batch` compiles and calls the code. It needs JAX, which this package does not
load.
"""

from gyrostat.codegen.simd.compiler import (
    compiler,
    compiler_options,
    compiler_version,
    run_compiler,
)

__all__ = ["compiler", "compiler_options", "compiler_version", "run_compiler"]
