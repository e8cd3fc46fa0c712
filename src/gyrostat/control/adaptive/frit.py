"""Fictitious reference iterative tuning (FRIT), on line by recursive least squares.

The loop u = F (r - y) + K e, in which a gain K feeds back an error signal e, should respond like a
reference model, y = M r. The fictitious reference is the one that would have given the recorded
input. Solving the loop for it gives the condition K M e = M u - F (y - M y), which is linear in K
and contains only recorded signals. Y. Wakasa and others, "Online controller tuning via FRIT and
recursive least-squares", 2013.
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
    """Dynamic model that steps by the control period, without direct feedthrough."""

    def start(self, output: Signal) -> Any:
        """State with this output; an equilibrium if the model has one at this output."""
        ...

    def __call__(self, state: Any, input: Signal, period: Scalar) -> Any:
        """State after one period, s, of constant input."""
        ...

    def output(self, state: Any) -> Signal:
        """Output of a state."""
        ...


class FirstOrderLags(Checked):
    """First-order lag y' = rate (gain u - y) on each channel, exact for a constant input.

    Attributes:
        rate: Reciprocal of the time constant, (n,), 1/s.
        gain: Steady-state gain, (n,) or one for all channels.
    """

    rate: Annotated[Signal, positive("lag rate", "1/s")]
    gain: Signal | float = 1.0

    def start(self, output: Signal) -> Signal:
        """Equilibrium state with this output."""
        return output

    def __call__(self, state: Signal, input: Signal, period: Scalar) -> Signal:
        """State after one period of constant input."""
        decay = jnp.exp(-jnp.asarray(self.rate) * period)
        return decay * state + (1.0 - decay) * self.gain * input

    def output(self, state: Signal) -> Signal:
        """Output, equal to the state."""
        return state


class LeastSquares(NamedTuple):
    """State of a recursive least-squares estimate of a row k in k x = y.

    Attributes:
        estimate: Estimate of the row k, (n,).
        covariance: Covariance matrix P, (n, n), the inverse of the accumulated information.
    """

    estimate: Signal
    covariance: Gain


def recursive_least_squares(
    state: LeastSquares, regressor: Signal, target: Scalar, forgetting: Scalar
) -> LeastSquares:
    """One step of recursive least squares with exponential forgetting.

    Endo, Sekiguchi and Nonaka, (27) and (28): after N steps the estimate minimises the sum of
    forgetting^(N - i) (k x_i - y_i)^2 and of forgetting^N (k - k_0)' P_0^-1 (k - k_0).

    Args:
        state: State before the step.
        regressor: Regressor x, (n,).
        target: Target value y.
        forgetting: Forgetting factor lambda in (0, 1]; 1 means no forgetting.
    """
    weighed = state.covariance @ regressor
    share = weighed / (forgetting + regressor @ weighed)
    estimate = state.estimate + share * (target - state.estimate @ regressor)
    return LeastSquares(estimate, (state.covariance - jnp.outer(share, weighed)) / forgetting)


class FritMemory(NamedTuple):
    """State of the on-line tuning.

    Attributes:
        gain: Gain for the next input, (n, n).
        rows: Least-squares state of each row of the gain, with leading axis n.
        error: State of the reference model that filters the error signal.
        input: State of the reference model that filters the input.
        output: State of the reference model that filters the output.
    """

    gain: Gain
    rows: LeastSquares
    error: Any
    input: Any
    output: Any


def regression(tuner: Any, memory: Any, output: Signal) -> tuple[Signal, Signal]:
    """Signals xi and eta of the regression K xi = eta at a sample.

    Args:
        tuner: Tuner with `reference` M and `feedback` F.
        memory: State of the tuner, with the states of M that filter `error`, `input` and `output`.
        output: Output of the plant at this sample, (n,).
    """
    filtered = tuner.reference.output(memory.output)
    eta = tuner.reference.output(memory.input) - tuner.feedback * (output - filtered)
    return tuner.reference.output(memory.error), eta


class OnlineFrit(Checked):
    """On-line tuning of the gain K in u = F (r - y) + K e, so that y = M r.

    Endo, Sekiguchi and Nonaka, (15)-(30), with the sign of (25) corrected. Row j of K is the
    least-squares solution of K xi = eta with forgetting, where xi = M e and eta = M u - F (y - M
    y). The gain in use follows the estimate through a low-pass filter. F and M must commute: both
    are diagonal, or M is the same lag on all channels.

    If e is the difference to a nominal model, y and u satisfy eta = -M d, where d is the
    disturbance at the input of the plant. The estimate is then the gain with which K e = -d. This
    class does not bound the gain; see `SafeFrit`.

    Attributes:
        feedback: Diagonal of F, (n,).
        reference: Reference model M, the closed loop without model error.
        forgetting: Forgetting factor lambda in (0, 1].
        smoothing: Smoothing factor kappa in (0, 1]: K(i) = (1 - kappa) K(i-1) + kappa (estimate); 1
            means no smoothing.
        dead_zone: Dead zone of the error, (n,). Row j is not updated while |e_j| is smaller.
        initial_gain: Initial gain, (n, n).
        initial_covariance: Initial covariance P(0) of every row, as a factor of the unit matrix.
        filters_from_output: Whether M y starts at y(0), as for a loop at rest there, instead of at
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
            InputError: The feedback or the gain has the wrong shape or is not finite.
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
        """Initial memory.

        Args:
            output: First output of the plant, (n,).
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
        """Update at a sample; the gain in the result is for the next sample.

        Args:
            memory: Memory from the last sample; its gain gave `input`.
            error: Error signal that the gain feeds back, (n,).
            input: Input of the plant, (n,).
            output: Output of the plant, (n,).
            period: Time to the next sample, s.
        """
        xi, eta = regression(self, memory, output)
        update = jax.vmap(recursive_least_squares, in_axes=(0, None, 0, None))(
            memory.rows, xi, eta, self.forgetting
        )
        active = (jnp.abs(error) >= jnp.asarray(self.dead_zone))[:, None]
        rows = LeastSquares(
            jnp.where(active, update.estimate, memory.rows.estimate),
            jnp.where(active[..., None], update.covariance, memory.rows.covariance),
        )
        gain = memory.gain + self.smoothing * (rows.estimate - memory.gain)
        return FritMemory(
            gain=jnp.where(active, gain, memory.gain),
            rows=rows,
            error=self.reference(memory.error, error, period),
            input=self.reference(memory.input, input, period),
            output=self.reference(memory.output, output, period),
        )
