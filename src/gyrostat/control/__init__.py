"""Controllers of the control loop, from measurement to command, and their design methods."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
