"""Statistics of a signal over samples, accumulated sample by sample."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector


class Statistic(NamedTuple):
    """Statistic of a signal over samples.

    Attributes:
        start: Memory before the first sample.
        updated: Function (memory, value) -> memory after a sample.
        result: Function (memories, numbers of samples) -> statistics, NumPy.
    """

    start: float
    updated: Callable[[Any, Any], Any]
    result: Callable[[Vector, Vector], Vector]


MAX = Statistic(-np.inf, jnp.maximum, lambda memory, _: memory)
LAST = Statistic(0.0, lambda _, value: value, lambda memory, _: memory)
SUM = Statistic(0.0, lambda memory, value: memory + value, lambda memory, _: memory)
MEAN = SUM._replace(result=lambda memory, samples: memory / samples)
ROOT_OF_MEAN = SUM._replace(result=lambda memory, samples: np.sqrt(memory / samples))
RMS = ROOT_OF_MEAN._replace(updated=lambda memory, value: memory + value**2)
