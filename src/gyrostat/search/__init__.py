"""Searches among the runs of a scenario: rare failures, the worst case, the best gains."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
