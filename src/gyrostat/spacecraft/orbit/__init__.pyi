"""Public names of the package; `__init__.py` reads this file."""

from gyrostat.spacecraft.orbit.elements import CircularElements as CircularElements
from gyrostat.spacecraft.orbit.elements import KeplerElements as KeplerElements
from gyrostat.spacecraft.orbit.elements import Trajectory as Trajectory
from gyrostat.spacecraft.orbit.ephemeris import Ephemeris as Ephemeris
from gyrostat.spacecraft.orbit.frames import States as States
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment as OrbitEnvironment
from gyrostat.spacecraft.orbit.orbit_environment import OrbitSamples as OrbitSamples
from gyrostat.spacecraft.orbit.orbit_file import OrbitFile as OrbitFile
from gyrostat.spacecraft.orbit.tables import OrbitAccuracy as OrbitAccuracy
from gyrostat.spacecraft.orbit.time_scales import Epoch as Epoch
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements as TwoLineElements
