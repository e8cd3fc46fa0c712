"""Model error compensator with anti-windup for actuators with limits."""

from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.adaptive.frit import SampledModel, Signal
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class ConditionedMemory(NamedTuple):
    """Between two samples.

    Attributes:
        model: state of the nominal model.
        correction: (n,) that was added to the input.
        error: (n,) output of the model less that of the plant.
    """

    model: Any
    correction: Signal
    error: Signal


class ConditionedCompensator(eqx.Module):
    """u = u_n + K (y_n - y), the model driven by what the actuators gave, less K (y_n - y).

    While the actuators give u, this is `ModelErrorCompensator`: the model is driven by u_n. While
    they do not, the model is driven by what they gave instead of what the law wanted, so that the
    difference y_n - y holds nothing but the model's error: nothing winds up. With integrators as
    the model and K diagonal, K (y_n - y) tends to the opposite of what the plant adds to its
    input, at the rate K.

    Attributes:
        model: nominal, input to output.
    """

    model: SampledModel

    def start(self, output: Signal) -> ConditionedMemory:
        """At an output: no error."""
        none = jnp.zeros_like(output)
        return ConditionedMemory(self.model.start(output), none, none)

    def __call__(
        self,
        memory: ConditionedMemory,
        given: Signal,
        output: Signal,
        gain: Signal | Float[Array, ""],
        period: Scalar,
    ) -> ConditionedMemory:
        """At a sample; `correction` is for the input that is made now.

        Args:
            memory: at the last sample.
            given: (n,) input that the actuators have given since.
            output: (n,) of the plant now.
            gain: (n,) diagonal of K; on integrators, 1/s and below 2 / period.
            period: since the last sample, s.
        """
        model = self.model(memory.model, given - memory.correction, period)
        error = self.model.output(model) - output
        return ConditionedMemory(model, gain * error, error)
