"""The verbs of the command line as functions: same options, same files, results as objects.

Quantities are numbers in SI units or text with a unit ("5 rpm"). A function writes files where
`out` says, and none without it; `campaign` alone needs a folder and names one itself. Each gives
every line for a person to `say`, which drops it by default.
"""

from gyrostat.verbs.cache import cache
from gyrostat.verbs.exports import export
from gyrostat.verbs.failures import feasible, recover
from gyrostat.verbs.identification import identify
from gyrostat.verbs.papers import reproduce
from gyrostat.verbs.scenarios import campaign, replay, report, simulate
from gyrostat.verbs.wheels import bench, validate

__all__ = [
    "bench",
    "cache",
    "campaign",
    "export",
    "feasible",
    "identify",
    "recover",
    "replay",
    "report",
    "reproduce",
    "simulate",
    "validate",
]
