"""Identification of wheel models from bench records, with uncertainty."""

# these register themselves as views of the results
from gyrostat.identification import design_text as design_text
from gyrostat.identification import fit_json as fit_json
from gyrostat.identification import fit_text as fit_text
from gyrostat.identification.acceptance import accept
from gyrostat.identification.acceptance_lines import Acceptance
from gyrostat.identification.averaging import Effect
from gyrostat.identification.batch import identify, identify_problem
from gyrostat.identification.coast import identify_coast
from gyrostat.identification.comparison import candidates_of, compare
from gyrostat.identification.fit import Candidate, Fit
from gyrostat.identification.fit_changes import Comparison
from gyrostat.identification.fit_comparison import compare_fits
from gyrostat.identification.methods import identify_dedicated
from gyrostat.identification.observability import Observability
from gyrostat.identification.problem import Problem
from gyrostat.identification.steady import identify_steady
from gyrostat.identification.stored_fit import StoredFit, stored_fit
from gyrostat.identification.temperature import temperature_trends, trends_of
from gyrostat.identification.temperature_trend import TemperatureTrend
from gyrostat.identification.torque_step import identify_torque_step
from gyrostat.identification.validation import Validation, validate

__all__ = [
    "Acceptance",
    "Candidate",
    "Comparison",
    "Effect",
    "Fit",
    "Observability",
    "Problem",
    "StoredFit",
    "TemperatureTrend",
    "Validation",
    "accept",
    "candidates_of",
    "compare",
    "compare_fits",
    "identify",
    "identify_coast",
    "identify_dedicated",
    "identify_problem",
    "identify_steady",
    "identify_torque_step",
    "stored_fit",
    "temperature_trends",
    "trends_of",
    "validate",
]
