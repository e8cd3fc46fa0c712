"""Reaction wheel with dry friction: parameters, response to a current, and model file."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
