"""From a traced function to a program of scalars, for whoever writes code from it."""

from gyrostat.lowering.lower import Lowering
from gyrostat.lowering.prune import prune
from gyrostat.lowering.source import Source
from gyrostat.lowering.tracing import Trace, as_arrays, trace

__all__ = ["Lowering", "Source", "Trace", "as_arrays", "prune", "trace"]
