"""Bringing a spacecraft to rest after wheels have failed: where, by which law, how soon."""

from gyrostat.recovery.plan import Loss, RecoveryPlan, plan_recovery
from gyrostat.recovery.recover import Recovery, recover, settling_time

__all__ = ["Loss", "Recovery", "RecoveryPlan", "plan_recovery", "recover", "settling_time"]
