"""Position of the Sun from the centre of the Earth.

The library erfa (`epv00`: heliocentric position of the Earth, good to 5 km) in TT for TDB. The
position is geometric: light time and aberration, 20 arcseconds together, are left out.
"""

import numpy as np

from gyrostat.spacecraft.orbit.earth import ASTRONOMICAL_UNIT
from gyrostat.spacecraft.orbit.frames import Vectors
from gyrostat.spacecraft.orbit.libraries import library
from gyrostat.spacecraft.orbit.time_scales import Epoch, Times


def sun_position(epoch: Epoch, times: Times) -> Vectors:
    """Position of the Sun from the centre of the Earth, GCRS, (rows, 3), m, at times, s."""
    heliocentric, _ = library("erfa").epv00(*epoch.tt(times))
    return -ASTRONOMICAL_UNIT * np.asarray(heliocentric["p"])
