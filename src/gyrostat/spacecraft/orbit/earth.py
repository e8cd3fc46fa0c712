"""Constants of the Earth's gravity and orbit."""

EARTH = 3.986004418e14
"""Gravitational parameter of the Earth, m³/s² (IERS Conventions, 2010)."""
EARTH_RADIUS = 6378137.0
"""Equatorial radius of the Earth, m (WGS 84)."""
EARTH_J2 = 1.08262668e-3
"""Second zonal harmonic of the Earth's gravity (EGM96)."""
ASTRONOMICAL_UNIT = 149597870700.0
"""Astronomical unit, m (IAU 2012, resolution B2)."""
