"""Orbit of a spacecraft and what surrounds it, as tables over time.

The tables are made by `gyrostat.spacecraft.orbit.tables.orbit_environment`.
"""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
