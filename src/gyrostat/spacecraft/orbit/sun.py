"""Positions of the Sun and of the Moon from the centre of the Earth.

The library erfa in TT for TDB: `epv00`, the heliocentric position of the Earth, good to 5 km;
`moon98`, the Moon by J. Meeus's series, good to 6 arcseconds. The positions are geometric: light
time and aberration, 20 arcseconds together, are left out.
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


def moon_position(epoch: Epoch, times: Times) -> Vectors:
    """Position of the Moon from the centre of the Earth, GCRS, (rows, 3), m, at times, s."""
    return ASTRONOMICAL_UNIT * np.asarray(library("erfa").moon98(*epoch.tt(times))["p"])
