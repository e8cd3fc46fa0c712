"""Identification of wheel models from bench records, with uncertainty."""

from gyrostat.identification.batch import identify, identify_problem
from gyrostat.identification.bench.coast import identify_coast
from gyrostat.identification.bench.methods import identify_dedicated
from gyrostat.identification.bench.steady import identify_steady
from gyrostat.identification.bench.torque_step import identify_torque_step
from gyrostat.identification.comparison import candidates_of, compare
from gyrostat.identification.drive.control_law import read_control_law
from gyrostat.identification.drive.inverse import identify_inverse
from gyrostat.identification.experiment import design_text as design_text  # a view
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.judge import comparison_text as comparison_text  # a view
from gyrostat.identification.judge import validation_text as validation_text  # a view
from gyrostat.identification.judge.acceptance import accept
from gyrostat.identification.judge.acceptance_lines import Acceptance
from gyrostat.identification.judge.fit_changes import Comparison
from gyrostat.identification.judge.fit_comparison import compare_fits
from gyrostat.identification.judge.validation import Validation, validate
from gyrostat.identification.lot import lot_json as lot_json  # a view
from gyrostat.identification.lot import lot_text as lot_text  # a view
from gyrostat.identification.lot.analysis import analyse_lot
from gyrostat.identification.lot.lot_table import dispersion_table
from gyrostat.identification.lot.result import Lot
from gyrostat.identification.pool import pool_json as pool_json  # a view
from gyrostat.identification.pool import pool_text as pool_text  # a view
from gyrostat.identification.pool.analysis import pool_fits
from gyrostat.identification.pool.pool_model import pooled_model
from gyrostat.identification.pool.result import Pool
from gyrostat.identification.result import fit_json as fit_json  # a view
from gyrostat.identification.result import fit_text as fit_text  # a view
from gyrostat.identification.result.fit import Candidate, Fit
from gyrostat.identification.result.stored_fit import StoredFit, stored_fit
from gyrostat.identification.result.temperature_trend import TemperatureTrend
from gyrostat.identification.temperature import temperature_trends, trends_of
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.observability import Observability

__all__ = [
    "Acceptance",
    "Candidate",
    "Comparison",
    "Effect",
    "Fit",
    "Lot",
    "Observability",
    "Pool",
    "Problem",
    "StoredFit",
    "TemperatureTrend",
    "Validation",
    "accept",
    "analyse_lot",
    "candidates_of",
    "compare",
    "compare_fits",
    "dispersion_table",
    "identify",
    "identify_coast",
    "identify_dedicated",
    "identify_inverse",
    "identify_problem",
    "identify_steady",
    "identify_torque_step",
    "pool_fits",
    "pooled_model",
    "read_control_law",
    "stored_fit",
    "temperature_trends",
    "trends_of",
    "validate",
]
