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
    """What the tuning remembers.

    Attributes:
        gain: (n,) that is to be used.
        rows: least-squares state of each channel, of size 1, leading axis n.
        error: state of the reference model that filters the error signal.
        input: of the one that filters the input.
        output: of the one that filters the output.
        quiet: time since nothing was cut, s.
    """

    gain: Signal
    rows: LeastSquares
    error: Any
    input: Any
    output: Any
    quiet: Scalar


class SafeFrit(Checked):
    """`OnlineFrit` with what keeps it from harm.

    K is diagonal, so that one channel's disturbance cannot be taken for another's; the filters
    start at the first output, so that none is invented at the start; K is kept to a range; the
    covariance is capped, since forgetting without information lets it grow without bound; a
    channel waits while its error is small; and nothing is learnt while the actuators give less
    than was asked for, nor until the filters have forgotten it. Y. Wakasa and others as there;
    projection and cap: P. A. Ioannou, J. Sun, "Robust Adaptive Control", sections 4.4 and 8.5.

    Attributes:
        feedback: (n,) diagonal of F.
        reference: M, the same lag on all channels or diagonal.
        forgetting: lambda in (0, 1].
        smoothing: kappa in (0, 1].
        dead_zone: (n,) channel j waits while |e_j| is less.
        initial_gain: (n,), 1/s on integrators.
        lowest: (n,) of the gain.
        highest: (n,) of the gain.
        largest_covariance: of each channel; it starts there.
        wait: s after the actuators were last cut.
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
            InputError: It is outside its range.
        """
        gain = np.asarray(self.initial_gain, dtype=float)
        low, high = np.asarray(self.lowest), np.asarray(self.highest)
        if not np.all((low <= gain) & (gain <= high)):
            raise InputError(
                f"FRIT initial gain: found {gain.tolist()}, expected between {low.tolist()} and "
                f"{high.tolist()}"
            )

    def start(self, output: Signal) -> SafeFritMemory:
        """Memory before the first sample, at an output (n,)."""
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
        """Memory after a sample: the gain in it is for the next one.

        Args:
            memory: before.
            error: (n,) that the gain feeds back.
            input: (n,) that the plant was given over the period from this sample on.
            output: (n,) of the plant.
            cut: whether the actuators gave less than was asked for.
            period: to the next sample, s.
        """
        xi, eta = regression(self, memory, output)
        found = jax.vmap(recursive_least_squares, in_axes=(0, 0, 0, None))(
            memory.rows, xi[:, None], eta, self.forgetting
        )
        kept = jnp.clip(found.estimate[:, 0], self.lowest, self.highest)
        capped = jnp.minimum(found.covariance, self.largest_covariance)
        quiet = jnp.where(cut, 0.0, memory.quiet + period)
        heeded = (jnp.abs(error) >= self.dead_zone) & (quiet > self.wait)
        rows = LeastSquares(
            jnp.where(heeded[:, None], kept[:, None], memory.rows.estimate),
            jnp.where(heeded[:, None, None], capped, memory.rows.covariance),
        )
        followed = memory.gain + self.smoothing * (rows.estimate[:, 0] - memory.gain)
        return SafeFritMemory(
            gain=jnp.where(heeded, followed, memory.gain),
            rows=rows,
            error=self.reference(memory.error, error, period),
            input=self.reference(memory.input, input, period),
            output=self.reference(memory.output, output, period),
            quiet=quiet,
        )
