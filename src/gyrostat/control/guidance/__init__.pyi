"""Public names of the package; `__init__.py` reads this file."""

from gyrostat.control.guidance.attitude_reference import AttitudeReference as AttitudeReference
from gyrostat.control.guidance.attitude_reference import Profile as Profile
from gyrostat.control.guidance.attitude_reference import reference_at as reference_at
from gyrostat.control.guidance.guide import Following as Following
from gyrostat.control.guidance.guide import Guide as Guide
from gyrostat.control.guidance.guided import Guided as Guided
from gyrostat.control.guidance.guided import toward as toward
from gyrostat.control.guidance.pointing import Aim as Aim
from gyrostat.control.guidance.pointing import GroundTarget as GroundTarget
from gyrostat.control.guidance.pointing import Pointing as Pointing
from gyrostat.control.guidance.pointing import to_earth as to_earth
from gyrostat.control.guidance.pointing import to_sun as to_sun
from gyrostat.control.guidance.profiles import Fixed as Fixed
from gyrostat.control.guidance.profiles import Nadir as Nadir
from gyrostat.control.guidance.profiles import Table as Table
from gyrostat.control.guidance.reference import NEVER as NEVER
from gyrostat.control.guidance.reference import BoundReference as BoundReference
from gyrostat.control.guidance.reference import Condition as Condition
from gyrostat.control.guidance.reference import Mode as Mode
from gyrostat.control.guidance.reference import Reference as Reference
from gyrostat.control.guidance.slew import SlewLimits as SlewLimits
from gyrostat.control.guidance.slew import Slews as Slews
from gyrostat.control.guidance.slew import Transition as Transition
from gyrostat.control.guidance.slew_profile import SlewProfile as SlewProfile
from gyrostat.control.guidance.wheel_envelope import WheelEnvelope as WheelEnvelope
