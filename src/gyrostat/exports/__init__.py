"""Flight folders in C, FMI co-simulation units, Basilisk modules and data sheets."""

from gyrostat.exports.basilisk import basilisk
from gyrostat.exports.compensated_wheel import CompensatedWheel
from gyrostat.exports.fmu import write_fmu
from gyrostat.exports.folder import files
from gyrostat.exports.parts import Part, part_kind
from gyrostat.exports.scenario_controller import scenario_controller
from gyrostat.exports.sheet import sheet
from gyrostat.exports.target import Target
from gyrostat.exports.targets import TARGETS

__all__ = [
    "TARGETS",
    "CompensatedWheel",
    "Part",
    "Target",
    "basilisk",
    "files",
    "part_kind",
    "scenario_controller",
    "sheet",
    "write_fmu",
]
