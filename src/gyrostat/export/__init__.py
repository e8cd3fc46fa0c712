"""What leaves for other programs: C for flight, co-simulation units, Basilisk, data sheets."""

from gyrostat.export.basilisk import basilisk
from gyrostat.export.c import emit
from gyrostat.export.compensated_wheel import CompensatedWheel
from gyrostat.export.fmu import write_fmu
from gyrostat.export.folder import files
from gyrostat.export.module import Entry, Module, Port
from gyrostat.export.sheet import sheet
from gyrostat.export.targets import TARGETS, Target

__all__ = [
    "TARGETS",
    "CompensatedWheel",
    "Entry",
    "Module",
    "Port",
    "Target",
    "basilisk",
    "emit",
    "files",
    "sheet",
    "write_fmu",
]
