"""Public names of the package; `__init__.py` reads this file."""

from gyrostat.failures.attitude_words import attitude_text as attitude_text
from gyrostat.failures.attitude_words import euler_angles as euler_angles
from gyrostat.failures.braking import BrakeGain as BrakeGain
from gyrostat.failures.braking import earliest_settling as earliest_settling
from gyrostat.failures.certificate import Certificate as Certificate
from gyrostat.failures.controllability import controllability_matrix as controllability_matrix
from gyrostat.failures.feasibility import Holdable as Holdable
from gyrostat.failures.feasibility import holdable as holdable
from gyrostat.failures.feasibility import holdable_sky as holdable_sky
from gyrostat.failures.recovery import Recovery as Recovery
from gyrostat.failures.recovery import recover as recover
from gyrostat.failures.recovery import settling_time as settling_time
from gyrostat.failures.recovery import state_of as state_of
from gyrostat.failures.recovery_plan import Loss as Loss
from gyrostat.failures.recovery_plan import RecoveryPlan as RecoveryPlan
from gyrostat.failures.recovery_plan import plan_recovery as plan_recovery
from gyrostat.failures.sky_map import SkyMap as SkyMap
from gyrostat.failures.telemetry import Telemetry as Telemetry
