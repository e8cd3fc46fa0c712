"""References of attitude, rate and acceleration over time, and controllers that follow them."""

from gyrostat.control.guidance.attitude_reference import AttitudeReference, Profile, reference_at
from gyrostat.control.guidance.guide import Following, Guide
from gyrostat.control.guidance.guided import Guided, toward
from gyrostat.control.guidance.pointing import Aim, GroundTarget, Pointing, to_earth, to_sun
from gyrostat.control.guidance.profiles import Fixed, Nadir, Table
from gyrostat.control.guidance.reference import (
    NEVER,
    BoundReference,
    Condition,
    Mode,
    Reference,
)
from gyrostat.control.guidance.slew import SlewLimits, Slews, Transition
from gyrostat.control.guidance.slew_profile import SlewProfile
from gyrostat.control.guidance.wheel_envelope import WheelEnvelope

__all__ = [
    "NEVER",
    "Aim",
    "AttitudeReference",
    "BoundReference",
    "Condition",
    "Fixed",
    "Following",
    "GroundTarget",
    "Guide",
    "Guided",
    "Mode",
    "Nadir",
    "Pointing",
    "Profile",
    "Reference",
    "SlewLimits",
    "SlewProfile",
    "Slews",
    "Table",
    "Transition",
    "WheelEnvelope",
    "reference_at",
    "to_earth",
    "to_sun",
    "toward",
]
