"""Fictitious reference iterative tuning (FRIT), on line by recursive least squares.

A loop u = F (r - y) + K e, with an error signal e that a gain K feeds back, should answer like a
reference model: y = M r. Solved for the reference that would have given the recorded input, the
loop asks of K that K M e = M u - F (y - M y), linear in K, from recorded signals alone. Y. Wakasa
and others, "Online controller tuning via FRIT and recursive least-squares", 2013.
"""

from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, positive_share, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

Signal = Float[Array, " n"]
Gain = Float[Array, "n n"]


class SampledModel(Protocol):
    """A dynamic model in steps of the control period, without direct feedthrough."""

    def start(self, output: Signal) -> Any:
        """A state with this output; where the model can rest there, it does."""
        ...

    def __call__(self, state: Any, input: Signal, period: Scalar) -> Any:
        """The state after one period, s, of held input."""
        ...

    def output(self, state: Any) -> Signal:
        """Output at a state."""
        ...


class FirstOrderLags(Checked):
    """y' = rate (gain u - y) on each channel, exact for a held input.

    Attributes:
        rate: (n,) one over the time constant, 1/s.
        gain: (n,) at rest, or one for all.
    """

    rate: Annotated[Signal, positive("lag rate", "1/s")]
    gain: Signal | float = 1.0

    def start(self, output: Signal) -> Signal:
        """At rest at an output."""
        return output

    def __call__(self, state: Signal, input: Signal, period: Scalar) -> Signal:
        """After one period of held input."""
        kept = jnp.exp(-jnp.asarray(self.rate) * period)
        return kept * state + (1.0 - kept) * self.gain * input

    def output(self, state: Signal) -> Signal:
        """The state."""
        return state


class LeastSquares(NamedTuple):
    """State of a recursive least-squares estimate of a row k with k x = y.

    Attributes:
        estimate: (n,) the row.
        covariance: (n, n) P: its inverse is the information so far.
    """

    estimate: Signal
    covariance: Gain


def recursive_least_squares(
    state: LeastSquares, regressor: Signal, target: Scalar, forgetting: Scalar
) -> LeastSquares:
    """One step with exponential forgetting.

    Endo, Sekiguchi and Nonaka, (27) and (28): after N steps the estimate minimises the sum of
    forgetting^(N - i) (k x_i - y_i)^2 and of forgetting^N (k - k_0)' P_0^-1 (k - k_0).

    Args:
        state: before.
        regressor: (n,) x.
        target: y.
        forgetting: lambda in (0, 1]; 1 forgets nothing.
    """
    weighed = state.covariance @ regressor
    share = weighed / (forgetting + regressor @ weighed)
    estimate = state.estimate + share * (target - state.estimate @ regressor)
    return LeastSquares(estimate, (state.covariance - jnp.outer(share, weighed)) / forgetting)


class FritMemory(NamedTuple):
    """What on-line tuning remembers.

    Attributes:
        gain: (n, n) that is to be used.
        rows: least-squares state of each row of the gain, leading axis n.
        error: state of the reference model that filters the error signal.
        input: of the one that filters the input.
        output: of the one that filters the output.
    """

    gain: Gain
    rows: LeastSquares
    error: Any
    input: Any
    output: Any


def regression(tuner: Any, memory: Any, output: Signal) -> tuple[Signal, Signal]:
    """Xi and eta of K xi = eta at a sample.

    Args:
        tuner: has `reference` M and `feedback` F.
        memory: its; has the states of M that filter `error`, `input` and `output`.
        output: (n,) of the plant at this sample.
    """
    filtered = tuner.reference.output(memory.output)
    eta = tuner.reference.output(memory.input) - tuner.feedback * (output - filtered)
    return tuner.reference.output(memory.error), eta


class OnlineFrit(Checked):
    """Tunes the gain K of u = F (r - y) + K e so that y = M r, from u, y and e as they come.

    Endo, Sekiguchi and Nonaka, (15)-(30), with the sign of (25) corrected: row j of K is the
    least-squares solution of K xi = eta, xi = M e, eta = M u - F (y - M y), with forgetting; the
    gain in use follows it through a low pass. F and M must commute: both diagonal, or M the same
    lag on all channels. With e the difference to a nominal model, y and u obey eta = -M d, where d
    is what the plant adds to the input: the estimate is the gain that would have made K e = -d.
    Nothing bounds the gain here.

    Attributes:
        feedback: (n,) diagonal of F.
        reference: M, the closed loop without model error.
        forgetting: lambda in (0, 1].
        smoothing: kappa in (0, 1]: K(i) = (1 - kappa) K(i-1) + kappa (estimate); 1 does not smooth.
        dead_zone: (n,) row j waits while |e_j| is less.
        initial_gain: (n, n).
        initial_covariance: P(0) of every row, times the unit matrix.
        filters_from_output: whether M y starts at y(0), as a loop at rest there would, and not at
            zero.
    """

    feedback: Signal
    reference: SampledModel
    forgetting: Annotated[Scalar, positive_share("FRIT forgetting")]
    smoothing: Annotated[Scalar, positive_share("FRIT smoothing")]
    dead_zone: Annotated[Signal, size("FRIT dead zone")]
    initial_gain: Gain
    initial_covariance: Annotated[Scalar, positive("FRIT initial covariance")] = 100.0
    filters_from_output: Bool[Array, ""] | bool = False

    def check_own(self) -> None:
        """Validate feedback and gain.

        Raises:
            InputError: One is of the wrong shape or not finite.
        """
        feedback, gain = np.asarray(self.feedback), np.asarray(self.initial_gain)
        if feedback.ndim < 1 or not np.all(np.isfinite(feedback)):
            raise InputError(f"FRIT feedback: found {feedback}, expected (n,) finite values")
        if gain.shape[-2:] != 2 * feedback.shape[-1:] or not np.all(np.isfinite(gain)):
            raise InputError(
                f"FRIT initial gain: found {gain.tolist()}, expected a finite square matrix of "
                f"{feedback.shape[-1]} rows"
            )

    def start(self, output: Signal) -> FritMemory:
        """Memory before the first sample.

        Args:
            output: (n,) first output of the plant.
        """
        gain = jnp.asarray(self.initial_gain, dtype=float)
        count = gain.shape[0]
        zero = jnp.zeros(count)
        covariance = jnp.tile(self.initial_covariance * jnp.eye(count), (count, 1, 1))
        at_rest = self.reference.start(zero)
        filtered = self.reference.start(jnp.where(self.filters_from_output, output, zero))
        return FritMemory(gain, LeastSquares(gain, covariance), at_rest, at_rest, filtered)

    def __call__(
        self, memory: FritMemory, *, error: Signal, input: Signal, output: Signal, period: Scalar
    ) -> FritMemory:
        """Memory after a sample: the gain in it is for the next one.

        Args:
            memory: before; its gain made the input.
            error: (n,) that the gain feeds back.
            input: (n,) of the plant.
            output: (n,) of the plant.
            period: to the next sample, s.
        """
        xi, eta = regression(self, memory, output)
        found = jax.vmap(recursive_least_squares, in_axes=(0, None, 0, None))(
            memory.rows, xi, eta, self.forgetting
        )
        heeded = (jnp.abs(error) >= jnp.asarray(self.dead_zone))[:, None]
        rows = LeastSquares(
            jnp.where(heeded, found.estimate, memory.rows.estimate),
            jnp.where(heeded[..., None], found.covariance, memory.rows.covariance),
        )
        followed = memory.gain + self.smoothing * (rows.estimate - memory.gain)
        return FritMemory(
            gain=jnp.where(heeded, followed, memory.gain),
            rows=rows,
            error=self.reference(memory.error, error, period),
            input=self.reference(memory.input, input, period),
            output=self.reference(memory.output, output, period),
        )
