"""Wheel momentum control, with and without a friction estimate."""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Int

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, size
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import (
    FrictionScaleEstimate,
    FrictionScaleFilter,
    FrictionTorqueEstimate,
    FrictionTorqueFilter,
)

Profile = Callable[[Scalar], Scalar]


class MomentumCommand(NamedTuple):
    """Motor torque over a control period, and the estimates behind it.

    Attributes:
        torque: Constant term, N·m.
        fading_torque: Initial value of the decaying term, N·m.
        fading_rate: Rate of its exponential decay, 1/s.
        estimated_momentum: Estimated wheel momentum, N·m·s.
        estimated_friction: Estimated friction torque, N·m.
        reference_momentum: Reference momentum, N·m·s.
        innovation: Measured minus predicted momentum, N·m·s.
        innovation_sigma: Standard deviation of the innovation according to the estimator, N·m·s.
    """

    torque: Annotated[Scalar, "N·m"]
    fading_torque: Annotated[Scalar, "N·m"]
    fading_rate: Annotated[Scalar, "1/s"]
    estimated_momentum: Annotated[Scalar, "N·m·s"]
    estimated_friction: Annotated[Scalar, "N·m"]
    reference_momentum: Annotated[Scalar, "N·m·s"]
    innovation: Annotated[Scalar, "N·m·s"]
    innovation_sigma: Annotated[Scalar, "N·m·s"]


class _Memory(NamedTuple):
    estimate: Any
    sample: Int[Array, ""]
    period: Scalar


class FrictionTorqueControl(Checked):
    """Control law u = N - gamma (h - h_ref), with a filter without a friction model.

    Moreira, Lopes and Kuga, eqs. (8), (11), (15), (16). Between measurements h is the prediction of
    the filter, so that the second term decays with gamma.

    Attributes:
        estimator: Filter of momentum and friction torque.
        gain: Gain gamma, 1/s.
        reference: Reference momentum h_ref as a function of time, s -> N·m·s; a function of JAX
            arrays.
    """

    estimator: FrictionTorqueFilter
    gain: Annotated[Scalar, size("momentum gain", "1/s")]
    reference: Profile = eqx.field(static=True)

    def start(self, period: Scalar) -> _Memory:
        """Initial memory."""
        return _Memory(self.estimator.start(), jnp.array(0), period)

    def __call__(self, memory: _Memory, measurement: Any) -> tuple[_Memory, MomentumCommand]:
        """Compute the torque command; `measurement` has `momentum`, N·m·s."""
        estimate: FrictionTorqueEstimate = memory.estimate
        estimate = self.estimator.correct(estimate, measurement.momentum)
        reference = self.reference(memory.sample * memory.period)
        error = estimate.momentum - reference
        command = MomentumCommand(
            torque=estimate.friction,
            fading_torque=-self.gain * error,
            fading_rate=self.gain,
            estimated_momentum=estimate.momentum,
            estimated_friction=estimate.friction,
            reference_momentum=reference,
            innovation=estimate.innovation,
            innovation_sigma=jnp.sqrt(estimate.innovation_variance),
        )
        impulse = estimate.friction * memory.period
        impulse += error * jnp.expm1(-self.gain * memory.period)
        predicted = self.estimator.predict(estimate, impulse, memory.period)
        return _Memory(predicted, memory.sample + 1, memory.period), command


class FrictionScaleControl(Checked):
    """Control law u = N - gamma (h - h_ref), constant over a period, with a friction-model filter.

    Attributes:
        estimator: Filter of speed and friction scale.
        gain: Gain gamma, 1/s, well below the control rate.
        reference: Reference momentum h_ref as a function of time, s -> N·m·s; a function of JAX
            arrays.
    """

    estimator: FrictionScaleFilter
    gain: Annotated[Scalar, size("momentum gain", "1/s")]
    reference: Profile = eqx.field(static=True)

    def start(self, period: Scalar) -> _Memory:
        """Initial memory."""
        return _Memory(self.estimator.start(), jnp.array(0), period)

    def __call__(self, memory: _Memory, measurement: Any) -> tuple[_Memory, MomentumCommand]:
        """Compute the torque command; `measurement` has `momentum`, N·m·s."""
        inertia = self.estimator.wheel.inertia
        estimate: FrictionScaleEstimate = memory.estimate
        estimate = self.estimator.correct(estimate, measurement.momentum / inertia)
        reference = self.reference(memory.sample * memory.period)
        friction, _ = self.estimator.friction(estimate)
        torque = friction - self.gain * (inertia * estimate.speed - reference)
        command = MomentumCommand(
            torque=torque,
            fading_torque=jnp.zeros_like(torque),
            fading_rate=jnp.zeros_like(torque),
            estimated_momentum=inertia * estimate.speed,
            estimated_friction=friction,
            reference_momentum=reference,
            innovation=inertia * estimate.innovation,
            innovation_sigma=inertia * jnp.sqrt(estimate.innovation_variance),
        )
        current = torque / self.estimator.wheel.motor_constant
        predicted = self.estimator.predict(estimate, current, memory.period)
        return _Memory(predicted, memory.sample + 1, memory.period), command


class ProportionalMomentumControl(eqx.Module):
    """Control law u = -gamma (Y - h_ref) with the measured momentum Y.

    Moreira, Lopes and Kuga, eq. (18), with its sign corrected; a negative gain gives the printed
    equation.

    Attributes:
        gain: Gain gamma, 1/s.
        reference: Reference momentum h_ref as a function of time, s -> N·m·s; a function of JAX
            arrays.
    """

    gain: Scalar
    reference: Profile = eqx.field(static=True)

    def start(self, period: Scalar) -> _Memory:
        """Initial memory."""
        return _Memory((), jnp.array(0), period)

    def __call__(self, memory: _Memory, measurement: Any) -> tuple[_Memory, MomentumCommand]:
        """Compute the torque command; `measurement` has `momentum`, N·m·s."""
        reference = self.reference(memory.sample * memory.period)
        torque = -self.gain * (measurement.momentum - reference)
        zero = jnp.zeros_like(torque)
        command = MomentumCommand(
            torque, zero, zero, measurement.momentum, zero, reference, zero, zero
        )
        return memory._replace(sample=memory.sample + 1), command
