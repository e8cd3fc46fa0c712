"""Identification of wheel models from bench records, with uncertainty."""

from gyrostat.identification.acceptance import accept
from gyrostat.identification.acceptance_lines import Acceptance
from gyrostat.identification.averaging import Effect
from gyrostat.identification.batch import identify
from gyrostat.identification.coast import identify_coast
from gyrostat.identification.comparison import Candidate, compare
from gyrostat.identification.fit import Fit
from gyrostat.identification.methods import identify_dedicated
from gyrostat.identification.observability import Observability
from gyrostat.identification.steady import identify_steady
from gyrostat.identification.temperature import TemperatureTrend, temperature_trends
from gyrostat.identification.torque_step import identify_torque_step
from gyrostat.identification.validation import Validation, validate

__all__ = [
    "Acceptance",
    "Candidate",
    "Effect",
    "Fit",
    "Observability",
    "TemperatureTrend",
    "Validation",
    "accept",
    "compare",
    "identify",
    "identify_coast",
    "identify_dedicated",
    "identify_steady",
    "identify_torque_step",
    "temperature_trends",
    "validate",
]
