"""Code generation: translate a traced function into a program of scalars, and that into C.

The names are loaded on first use, so that `gyrostat.codegen.simd`, which finds the C compiler, does
not load JAX.
"""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
