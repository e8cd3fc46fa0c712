"""FRIT with bounded gains, adapted only while excitation suffices."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.adaptive.frit import (
    LeastSquares,
    SampledModel,
    Signal,
    recursive_least_squares,
    regression,
)
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, positive_share, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp


class SafeFritMemory(NamedTuple):
    """State of the on-line tuning.

    Attributes:
        gain: Gain for the next input, (n,).
        rows: Least-squares state of each channel, of size 1, with leading axis n.
        error: State of the reference model that filters the error signal.
        input: State of the reference model that filters the input.
        output: State of the reference model that filters the output.
        quiet: Time since the actuators last saturated, s.
    """

    gain: Signal
    rows: LeastSquares
    error: Any
    input: Any
    output: Any
    quiet: Scalar


class SafeFrit(Checked):
    """`OnlineFrit` with safeguards: diagonal and bounded gain, bounded covariance, dead zone.

    - K is diagonal, so that the disturbance of one channel does not change the gain of another.
    - The filters start at the first output, so that they cause no initial transient.
    - K is limited to a range.
    - The covariance is limited, since forgetting without excitation lets it grow without bound.
    - A channel is not updated while its error is small.
    - No channel is updated while the actuators saturate, and until its effect has decayed in the
      filters.

    Y. Wakasa and others, as in `frit.py`; projection and limit of the covariance: P. A. Ioannou, J.
    Sun, "Robust Adaptive Control", sections 4.4 and 8.5.

    Attributes:
        feedback: Diagonal of F, (n,), 1/s.
        reference: Reference model M, the same lag on all channels or diagonal.
        forgetting: Forgetting factor lambda in (0, 1].
        smoothing: Smoothing factor kappa in (0, 1].
        dead_zone: Dead zone of the error, (n,). Channel j is not updated while |e_j| is smaller.
        initial_gain: Initial diagonal of the gain, (n,); on integrators in 1/s.
        lowest: Lower limit of the gain, (n,).
        highest: Upper limit of the gain, (n,).
        largest_covariance: Upper limit of the covariance of each channel, and its initial value.
        wait: Time without updates after the last saturation of the actuators, s.
    """

    feedback: Annotated[Signal, positive("FRIT feedback", "1/s")]
    reference: SampledModel
    forgetting: Annotated[Scalar, positive_share("FRIT forgetting")]
    smoothing: Annotated[Scalar, positive_share("FRIT smoothing")]
    dead_zone: Annotated[Signal, size("FRIT dead zone")]
    initial_gain: Signal
    lowest: Annotated[Signal, size("FRIT lowest gain")]
    highest: Annotated[Signal, size("FRIT highest gain")]
    largest_covariance: Annotated[Scalar, positive("FRIT largest covariance")]
    wait: Annotated[Scalar, size("FRIT wait", "s")] = 60.0

    def check_own(self) -> None:
        """Validate the initial gain.

        Raises:
            InputError: The initial gain is outside its range.
        """
        gain = np.asarray(self.initial_gain, dtype=float)
        low, high = np.asarray(self.lowest), np.asarray(self.highest)
        if not np.all((low <= gain) & (gain <= high)):
            raise InputError(
                f"FRIT initial gain: found {gain.tolist()}, expected between {low.tolist()} and "
                f"{high.tolist()}"
            )

    def start(self, output: Signal) -> SafeFritMemory:
        """Initial memory, at an output (n,)."""
        gain = jnp.asarray(self.initial_gain, dtype=float)
        covariance = jnp.full((len(gain), 1, 1), self.largest_covariance)
        at_rest = self.reference.start(jnp.zeros_like(gain))
        return SafeFritMemory(
            gain=gain,
            rows=LeastSquares(gain[:, None], covariance),
            error=at_rest,
            input=at_rest,
            output=self.reference.start(output),
            quiet=jnp.zeros(()),
        )

    def __call__(
        self,
        memory: SafeFritMemory,
        *,
        error: Signal,
        input: Signal,
        output: Signal,
        cut: Bool[Array, ""],
        period: Scalar,
    ) -> SafeFritMemory:
        """Update at a sample; the gain in the result is for the next sample.

        Args:
            memory: Memory from the last sample.
            error: Error signal that the gain feeds back, (n,).
            input: Input of the plant over the period that starts at this sample, (n,).
            output: Output of the plant, (n,).
            cut: Whether the actuators gave less than was commanded.
            period: Time to the next sample, s.
        """
        xi, eta = regression(self, memory, output)
        update = jax.vmap(recursive_least_squares, in_axes=(0, 0, 0, None))(
            memory.rows, xi[:, None], eta, self.forgetting
        )
        estimate = jnp.clip(update.estimate[:, 0], self.lowest, self.highest)
        covariance = jnp.minimum(update.covariance, self.largest_covariance)
        quiet = jnp.where(cut, 0.0, memory.quiet + period)
        active = (jnp.abs(error) >= self.dead_zone) & (quiet > self.wait)
        rows = LeastSquares(
            jnp.where(active[:, None], estimate[:, None], memory.rows.estimate),
            jnp.where(active[:, None, None], covariance, memory.rows.covariance),
        )
        gain = memory.gain + self.smoothing * (rows.estimate[:, 0] - memory.gain)
        return SafeFritMemory(
            gain=jnp.where(active, gain, memory.gain),
            rows=rows,
            error=self.reference(memory.error, error, period),
            input=self.reference(memory.input, input, period),
            output=self.reference(memory.output, output, period),
            quiet=quiet,
        )
