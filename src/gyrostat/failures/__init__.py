"""Attitudes that remain feasible after wheel failures, infeasibility certificates and recovery."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
