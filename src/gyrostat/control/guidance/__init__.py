"""References of attitude, rate and acceleration over time, and controllers that follow them."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
