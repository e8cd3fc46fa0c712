"""Scenarios from TOML files, and changes of scenarios from Python."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
