"""Metrics of a user, computed during the simulation."""

from typing import Any, Protocol

from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.user_errors import numbers, same_memory
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.user.wrapper import UserWrapper


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


class UserMetric(UserWrapper):
    """Metric of a user, a `RunMetric`, in the loop of a run."""

    def start(self) -> tuple[Any, Scalar]:
        """Memory before the first sample, 0 if the part has no method `start`; and its result."""
        memory = self.begun() if hasattr(self.inner, "start") else jnp.zeros(())
        return memory, jnp.zeros(())

    def __call__(
        self, memory: tuple[Any, Scalar], sample: Sample, is_last: Bool[Array, ""]
    ) -> tuple[Any, Scalar]:
        """Memory after a sample, and the metric after the last one, 0 after another sample.

        Raises:
            InputError: The part raised an exception, or returned something else than its memory
                or a number.
        """
        before, _ = memory
        after = same_memory(self.name, before, self.called("__call__", before, sample))

        def result() -> Scalar:
            return numbers(self.name, "result", self.called("result", after), ())

        return after, jax.lax.cond(is_last, result, lambda: jnp.zeros(()))
