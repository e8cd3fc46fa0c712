"""Attitudes that remain feasible after wheel failures, infeasibility certificates and recovery."""

from gyrostat.failures.braking import BrakeGain, earliest_settling
from gyrostat.failures.certificate import Certificate
from gyrostat.failures.controllability import controllability_matrix
from gyrostat.failures.feasibility import Holdable, holdable, holdable_sky
from gyrostat.failures.recovery import Recovery, recover, settling_time, state_of
from gyrostat.failures.recovery_plan import Loss, RecoveryPlan, plan_recovery
from gyrostat.failures.sky_map import SkyMap

__all__ = [
    "BrakeGain",
    "Certificate",
    "Holdable",
    "Loss",
    "Recovery",
    "RecoveryPlan",
    "SkyMap",
    "controllability_matrix",
    "earliest_settling",
    "holdable",
    "holdable_sky",
    "plan_recovery",
    "recover",
    "settling_time",
    "state_of",
]
