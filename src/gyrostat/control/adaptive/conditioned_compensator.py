"""Model error compensator with anti-windup for actuators with limits."""

from typing import Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.adaptive.frit import SampledModel, Signal
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp


class ConditionedMemory(NamedTuple):
    """State of the compensator between two samples.

    Attributes:
        model: State of the nominal model.
        correction: Correction that was added to the input, (n,).
        error: Output of the model minus output of the plant, (n,).
    """

    model: Any
    correction: Signal
    error: Signal


class ConditionedCompensator(eqx.Module):
    """Model error compensator with anti-windup, whose model is driven by the actual input.

    The input is u = u_n + K (y_n - y). While the actuators apply u, this is
    `ModelErrorCompensator`: the model is driven by u_n. In general it is driven by the applied
    input minus K (y_n - y). If the actuators saturate, the difference y_n - y then contains only
    the model error, so that there is no windup. With integrators as the model and a diagonal K, K
    (y_n - y) tends to the negative of the input disturbance of the plant, at the rate K.

    Attributes:
        model: Nominal model, from input to output.
    """

    model: SampledModel

    def start(self, output: Signal) -> ConditionedMemory:
        """Initial memory at an output, with zero error."""
        zero = jnp.zeros_like(output)
        return ConditionedMemory(self.model.start(output), zero, zero)

    def __call__(
        self,
        memory: ConditionedMemory,
        given: Signal,
        output: Signal,
        gain: Signal | Float[Array, ""],
        period: Scalar,
    ) -> ConditionedMemory:
        """Update at a sample; `correction` in the result is for the current input.

        Args:
            memory: Memory from the last sample.
            given: Input that the actuators have applied since the last sample, (n,).
            output: Current output of the plant, (n,).
            gain: Diagonal of K, (n,); on integrators in 1/s, and below 2 / period.
            period: Time since the last sample, s.
        """
        model = self.model(memory.model, given - memory.correction, period)
        error = self.model.output(model) - output
        return ConditionedMemory(model, gain * error, error)
