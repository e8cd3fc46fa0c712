"""Health of wheels in flight from their telemetry: friction and motor per window of time."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
