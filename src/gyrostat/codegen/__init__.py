"""From a traced function to a program of scalars, for whoever writes code from it."""

from gyrostat.codegen.lower import Lowering
from gyrostat.codegen.prune import prune
from gyrostat.codegen.source import Source
from gyrostat.codegen.tracing import Trace, as_arrays, trace

__all__ = ["Lowering", "Source", "Trace", "as_arrays", "prune", "trace"]
