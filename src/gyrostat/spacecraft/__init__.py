"""Bodies with reaction wheels, their sensors, failures and environment."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
