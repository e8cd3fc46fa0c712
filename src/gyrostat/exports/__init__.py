"""Flight folders in C, FMI co-simulation units, Basilisk modules and data sheets."""

from gyrostat.exports.basilisk import basilisk
from gyrostat.exports.compensated_wheel import CompensatedWheel
from gyrostat.exports.evidence import read_content, read_results, results_text, run_evidence
from gyrostat.exports.fmu import write_fmu
from gyrostat.exports.folder import DIFFERS, Search, files
from gyrostat.exports.parts import Part
from gyrostat.exports.reasons import read_reasons
from gyrostat.exports.scenario_controller import scenario_controller
from gyrostat.exports.sheet import sheet
from gyrostat.exports.target import Target

__all__ = [
    "DIFFERS",
    "CompensatedWheel",
    "Part",
    "Search",
    "Target",
    "basilisk",
    "files",
    "read_content",
    "read_reasons",
    "read_results",
    "results_text",
    "run_evidence",
    "scenario_controller",
    "sheet",
    "write_fmu",
]
