"""Verbs of the command line as functions, with the same options and files.

Quantities are numbers in SI units or text with a unit ("5 rpm"). A function writes files to `out`,
and none if it is None; only `campaign` needs a folder, for which it has a default name. Each
function passes messages for the user to `say`, which drops them by default.
"""

from gyrostat.verbs.cache import cache
from gyrostat.verbs.campaign_report import report
from gyrostat.verbs.campaigns import campaign
from gyrostat.verbs.comparison import compare
from gyrostat.verbs.error_budget import budget
from gyrostat.verbs.exports import export
from gyrostat.verbs.feasibility import feasible
from gyrostat.verbs.gyro import allan
from gyrostat.verbs.identification import identify
from gyrostat.verbs.lots import lot
from gyrostat.verbs.microvibration import jitter, waterfall
from gyrostat.verbs.monitoring import monitor
from gyrostat.verbs.papers import reproduce
from gyrostat.verbs.placement import place
from gyrostat.verbs.pools import pool
from gyrostat.verbs.recovery import recover
from gyrostat.verbs.scenario_check import check
from gyrostat.verbs.single_runs import replay, simulate
from gyrostat.verbs.speed_plan import plan_speeds
from gyrostat.verbs.tuning import tune
from gyrostat.verbs.wheels import bench, validate

__all__ = [
    "allan",
    "bench",
    "budget",
    "cache",
    "campaign",
    "check",
    "compare",
    "export",
    "feasible",
    "identify",
    "jitter",
    "lot",
    "monitor",
    "place",
    "plan_speeds",
    "pool",
    "recover",
    "replay",
    "report",
    "reproduce",
    "simulate",
    "tune",
    "validate",
    "waterfall",
]
