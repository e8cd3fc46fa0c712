"""Orbit of a spacecraft and what surrounds it, as tables over time.

The tables are made by `gyrostat.spacecraft.orbit.tables.orbit_environment`.
"""

from gyrostat.spacecraft.orbit.elements import CircularElements, KeplerElements, Trajectory
from gyrostat.spacecraft.orbit.ephemeris import Ephemeris
from gyrostat.spacecraft.orbit.frames import States
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment, OrbitSamples
from gyrostat.spacecraft.orbit.orbit_file import OrbitFile
from gyrostat.spacecraft.orbit.tables import OrbitAccuracy
from gyrostat.spacecraft.orbit.time_scales import Epoch
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements

__all__ = [
    "CircularElements",
    "Ephemeris",
    "Epoch",
    "KeplerElements",
    "OrbitAccuracy",
    "OrbitEnvironment",
    "OrbitFile",
    "OrbitSamples",
    "States",
    "Trajectory",
    "TwoLineElements",
]
