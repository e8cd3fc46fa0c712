"""Code generation: translate a traced function into a program of scalars, and that into C.

The names are loaded on first use, so that `gyrostat.codegen.simd`, which finds the C compiler, does
not load JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gyrostat.codegen.lower import Lowering
    from gyrostat.codegen.source import Source
    from gyrostat.codegen.tracing import Trace, as_arrays, trace

__all__ = ["Lowering", "Source", "Trace", "as_arrays", "trace"]

_MODULES = {"Lowering": "lower", "Source": "source"}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES.get(name, 'tracing')}"), name)
