"""Metrics of a user, computed during the simulation."""

from typing import Any, Protocol

from jaxtyping import Array, Bool

from gyrostat.campaigns.metrics.sample import Sample
from gyrostat.campaigns.own.wrapper import Own
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.user_errors import numbers, same_memory


class RunMetric(Protocol):
    """Protocol of a metric of a user: a number of each run.

    The method `start() -> memory` is optional; the memory is 0.0 without it. The attribute `unit`,
    a text, is optional; it is "1" without it.
    """

    def __call__(self, memory: Any, sample: Sample) -> Any:
        """Memory after a sample, of the same structure, shapes and types."""
        ...

    def result(self, memory: Any) -> Scalar:
        """Metric, from the memory after the last sample of a run; NaN: the run has none."""
        ...


class OwnMetric(Own):
    """Metric of a user, a `RunMetric`, in the loop of a run."""

    def start(self) -> Any:
        """Memory before the first sample; 0 if the part has no method `start`."""
        if not hasattr(self.inner, "start"):
            return jnp.zeros(())
        return self.begun()

    def __call__(self, memory: Any, sample: Sample) -> Any:
        """Memory after a sample.

        Raises:
            InputError: The part raised an exception, or returned something else than its memory.
        """
        after = self.called("__call__", memory, sample)
        return same_memory(self.name, memory, after)

    def result_if(self, is_last: Bool[Array, ""], memory: Any) -> Scalar:
        """Metric of a run, from the memory after its last sample; 0 after another sample.

        Raises:
            InputError: The part raised an exception, or returned something else than a number.
        """

        def result() -> Scalar:
            return numbers(self.name, "result", self.called("result", memory), ())

        return jax.lax.cond(is_last, result, lambda: jnp.zeros(()))
