"""C99 code for flight: a traced function as a module with structs, a header and a test program."""

from gyrostat.codegen.flight.c import emit
from gyrostat.codegen.flight.module import Entry, Module, Port

__all__ = ["Entry", "Module", "Port", "emit"]
