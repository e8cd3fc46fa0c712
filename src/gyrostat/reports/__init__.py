"""Output for people: figures, HTML pages and the files of an answer."""

from gyrostat.core.lazy import lazy_names

__getattr__, __dir__, __all__ = lazy_names(__name__)
