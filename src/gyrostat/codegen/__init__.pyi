"""Public names of the package; `__init__.py` reads this file."""

from gyrostat.codegen.lower import Lowering as Lowering
from gyrostat.codegen.source import Source as Source
from gyrostat.codegen.tracing import Trace as Trace
from gyrostat.codegen.tracing import as_arrays as as_arrays
from gyrostat.codegen.tracing import trace as trace
