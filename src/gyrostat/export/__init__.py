"""What leaves for other programs: C for flight software, data sheets."""

from gyrostat.export.c import emit
from gyrostat.export.module import Entry, Module, Port

__all__ = ["Entry", "Module", "Port", "emit"]
