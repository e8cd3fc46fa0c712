"""What leaves for other programs: C for flight, co-simulation units, Basilisk, data sheets."""

from gyrostat.codegen.flight.c import emit
from gyrostat.codegen.flight.module import Entry, Module, Port
from gyrostat.exports.basilisk import basilisk
from gyrostat.exports.compensated_wheel import CompensatedWheel
from gyrostat.exports.fmu import write_fmu
from gyrostat.exports.folder import files
from gyrostat.exports.sheet import sheet
from gyrostat.exports.targets import TARGETS, Target

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
