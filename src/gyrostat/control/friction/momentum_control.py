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
    """Motor torque through a control period, and what it rests on.

    Attributes:
        torque: constant part, N·m.
        fading_torque: N·m, fading with `fading_rate`.
        fading_rate: 1/s.
        estimated_momentum: N·m·s.
        estimated_friction: N·m.
        reference_momentum: N·m·s.
        innovation: measured minus predicted momentum, N·m·s.
        innovation_sigma: what the estimator expects of it, N·m·s.
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
    """u = N - gamma (h - h_ref) on the filter without a friction model.

    Moreira, Lopes and Kuga, eqs. (8), (11), (15), (16): between measurements h runs on as the
    filter predicts it, so that the second part fades with gamma.

    Attributes:
        estimator: of momentum and friction torque.
        gain: gamma, 1/s.
        reference: h_ref over time, s -> N·m·s; a function of JAX arrays.
    """

    estimator: FrictionTorqueFilter
    gain: Annotated[Scalar, size("momentum gain", "1/s")]
    reference: Profile = eqx.field(static=True)

    def start(self, period: Scalar) -> _Memory:
        """Nothing measured yet."""
        return _Memory(self.estimator.start(), jnp.array(0), period)

    def __call__(self, memory: _Memory, measurement: Any) -> tuple[_Memory, MomentumCommand]:
        """Command a torque; `measurement` has `momentum`, N·m·s."""
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
    """The same law, held through the period, on the filter that carries the friction model.

    Attributes:
        estimator: of speed and friction scale.
        gain: gamma, 1/s, well below the control rate.
        reference: h_ref over time, s -> N·m·s; a function of JAX arrays.
    """

    estimator: FrictionScaleFilter
    gain: Annotated[Scalar, size("momentum gain", "1/s")]
    reference: Profile = eqx.field(static=True)

    def start(self, period: Scalar) -> _Memory:
        """Nothing measured yet."""
        return _Memory(self.estimator.start(), jnp.array(0), period)

    def __call__(self, memory: _Memory, measurement: Any) -> tuple[_Memory, MomentumCommand]:
        """Command a torque; `measurement` has `momentum`, N·m·s."""
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
    """u = -gamma (Y - h_ref) on the measurement alone.

    Moreira, Lopes and Kuga, eq. (18), with its sign corrected; a negative gain is what is printed.

    Attributes:
        gain: gamma, 1/s.
        reference: h_ref over time, s -> N·m·s; a function of JAX arrays.
    """

    gain: Scalar
    reference: Profile = eqx.field(static=True)

    def start(self, period: Scalar) -> _Memory:
        """Nothing measured yet."""
        return _Memory((), jnp.array(0), period)

    def __call__(self, memory: _Memory, measurement: Any) -> tuple[_Memory, MomentumCommand]:
        """Command a torque; `measurement` has `momentum`, N·m·s."""
        reference = self.reference(memory.sample * memory.period)
        torque = -self.gain * (measurement.momentum - reference)
        zero = jnp.zeros_like(torque)
        command = MomentumCommand(
            torque, zero, zero, measurement.momentum, zero, reference, zero, zero
        )
        return memory._replace(sample=memory.sample + 1), command
