"""Model error compensator (MEC): makes a plant behave like its nominal model."""

from functools import partial
from typing import Any, NamedTuple, Protocol

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.adaptive.frit import FritMemory, Gain, OnlineFrit, SampledModel, Signal
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp, ravel_pytree


class Compensation(NamedTuple):
    """Signals of a compensator at a sample.

    Attributes:
        nominal_input: Input of the control law alone, (n,).
        model_error: Output of the nominal model minus output of the plant, (n,).
        gain: Gain in use, (n, n).
    """

    nominal_input: Signal
    model_error: Signal
    gain: Gain

    @classmethod
    def none(cls, nominal_input: Signal) -> "Compensation":
        """Signals for a control law without a compensator."""
        count = nominal_input.shape[0]
        return cls(nominal_input, jnp.zeros(count), jnp.zeros((count, count)))


class Law(Protocol):
    """Control law that a compensator can extend: from measurements to y, and from u to commands."""

    def start(self, period: Scalar) -> Any:
        """Initial memory."""
        ...

    def observe(self, memory: Any, measurement: Any) -> tuple[Any, Signal]:
        """New memory, and the output y, (n,)."""
        ...

    def nominal_input(self, output: Signal) -> Signal:
        """Input of the control law, (n,)."""
        ...

    def command(
        self, memory: Any, measurement: Any, input: Signal, compensation: Compensation
    ) -> Any:
        """Command for an input of the plant; it may record the signals of the compensator."""
        ...


class Integrators(eqx.Module):
    """Integrator y' = u on each channel."""

    def start(self, output: Signal) -> Signal:
        """State with this output."""
        return output

    def __call__(self, state: Signal, input: Signal, period: Scalar) -> Signal:
        """State after one period of constant input."""
        return state + period * input

    def output(self, state: Signal) -> Signal:
        """Output, equal to the state."""
        return state


class CompensatorMemory(NamedTuple):
    """State of a compensator between two samples.

    Attributes:
        law: Memory of the control law.
        model: State of the nominal model.
        tuning: State of the gain tuner; None if the gain is fixed.
        begun: Whether a first measurement has been received.
        period: Control period, s.
    """

    law: Any
    model: Any
    tuning: FritMemory | None
    begun: Bool[Array, ""]
    period: Scalar


def _closed_loop(model: SampledModel, gain: Gain, period: float) -> Float[Array, "x x"]:
    """Matrix A - B K C of a nominal model linearised at rest, over its full state."""
    zero = jnp.zeros(gain.shape[-1])
    state, unravel = ravel_pytree(model.start(zero))

    def step(state, input):
        return ravel_pytree(model(unravel(state), input, period))[0]

    carry, drive = jax.jacfwd(step, argnums=(0, 1))(state, zero)
    return carry - drive @ gain @ jax.jacfwd(lambda state: model.output(unravel(state)))(state)


class ModelErrorCompensator(Checked):
    """Model error compensator u = u_n + K (y_n - y), with the output y_n of a nominal model.

    Endo, Sekiguchi and Nonaka, (13) and (14); H. Okajima and others, "A design method of
    compensator to minimize model error", 2013. Only the input u_n of the control law drives the
    model, and the law computes u_n from the output y of the plant itself. The compensator
    approximately cancels a disturbance at the input of the plant; the smaller K is, the slower it
    does so. With integrators as the model, K is the rate of an integral action, 1/s. This is a
    controller of the loop.

    Attributes:
        law: Control law, which gives output, nominal input and command.
        model: Nominal model, from input to output. It starts at the first measured output.
        gain: Fixed gain K, (n, n); unused if there is a tuner.
        tuner: Tuner that gives the gain on line; None for a fixed gain.
    """

    law: Law
    model: SampledModel
    gain: Float[Array, "n n"]
    tuner: OnlineFrit | None = None

    def check_own(self) -> None:
        """Validate the gain.

        Raises:
            InputError: The gain is not a finite square matrix.
        """
        gain = np.asarray(self.gain, dtype=float)
        square = gain.ndim >= 2 and gain.shape[-1] == gain.shape[-2]
        if not square or not np.all(np.isfinite(gain)):
            raise InputError(
                f"compensator gain: found {gain.tolist()}, expected a finite square matrix"
            )

    def check_own_period(self, period: float) -> None:
        """Check that the compensator itself is stable at a control period.

        On a plant that equals the model, the difference to the model obeys x+ = (A - B K C) x. On
        integrators the gain must stay below 2 over the period.

        Args:
            period: Control period, s.

        Raises:
            InputError: The spectral radius of A - B K C is above 1.
        """
        gains = jnp.asarray(self.gain, dtype=float)
        closed_loop = partial(_closed_loop, period=period)
        if gains.ndim > 2:
            # gains of a batch; the models have the same leading axis
            closed_loop = eqx.filter_vmap(closed_loop, in_axes=(eqx.if_array(0), 0))
        loops = np.asarray(closed_loop(self.model, gains))
        for gain, loop in zip(
            gains.reshape(-1, *gains.shape[-2:]), loops.reshape(-1, *loops.shape[-2:]), strict=True
        ):
            radius = float(np.max(np.abs(np.linalg.eigvals(loop))))
            if radius > 1.0 + 1e-9:
                raise InputError(
                    f"compensator gain: found {np.asarray(gain).tolist()} at a control period of "
                    f"{period:g} s, with which the compensator diverges (factor {radius:.4g} per "
                    f"period); on integrators it must be below {2.0 / period:g} 1/s"
                )

    def start(self, period: Scalar) -> CompensatorMemory:
        """Initial memory."""
        zero = jnp.zeros(jnp.shape(self.gain)[-1])
        return CompensatorMemory(
            law=self.law.start(period),
            model=self.model.start(zero),
            tuning=None if self.tuner is None else self.tuner.start(zero),
            begun=jnp.array(False),
            period=jnp.asarray(period, dtype=float),
        )

    def _initialise(self, memory: CompensatorMemory, output: Signal) -> CompensatorMemory:
        initial = memory._replace(
            model=self.model.start(output),
            tuning=None if self.tuner is None else self.tuner.start(output),
            begun=jnp.array(True),
        )
        return jax.tree.map(lambda old, new: jnp.where(memory.begun, old, new), memory, initial)

    def __call__(
        self, memory: CompensatorMemory, measurement: Any
    ) -> tuple[CompensatorMemory, Any]:
        """Compute the command."""
        law, output = self.law.observe(memory.law, measurement)
        memory = self._initialise(memory, output)
        nominal = self.law.nominal_input(output)
        error = self.model.output(memory.model) - output
        tuning = memory.tuning
        gain = jnp.asarray(self.gain) if tuning is None else tuning.gain
        input = nominal + gain @ error
        if self.tuner is not None and tuning is not None:
            tuning = self.tuner(
                tuning, error=error, input=input, output=output, period=memory.period
            )
        command = self.law.command(law, measurement, input, Compensation(nominal, error, gain))
        model = self.model(memory.model, nominal, memory.period)
        return memory._replace(law=law, model=model, tuning=tuning), command
