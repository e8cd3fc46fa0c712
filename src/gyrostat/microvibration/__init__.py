"""Microvibration of wheels: loads from a waterfall, and the line of sight that they move."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
