"""From bench records to a wheel with honest uncertainty."""

from gyrostat.identify.averaging import Effect
from gyrostat.identify.batch import identify
from gyrostat.identify.coast import identify_coast
from gyrostat.identify.comparison import Candidate, compare
from gyrostat.identify.fit import Fit
from gyrostat.identify.methods import identify_dedicated
from gyrostat.identify.observability import Observability
from gyrostat.identify.steady import identify_steady
from gyrostat.identify.temperature import TemperatureTrend, temperature_trends
from gyrostat.identify.torque_step import identify_torque_step
from gyrostat.identify.validation import Validation, validate

__all__ = [
    "Candidate",
    "Effect",
    "Fit",
    "Observability",
    "TemperatureTrend",
    "Validation",
    "compare",
    "identify",
    "identify_coast",
    "identify_dedicated",
    "identify_steady",
    "identify_torque_step",
    "temperature_trends",
    "validate",
]
