"""Friction feed-forward from a Kalman filter for each wheel."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.measured import with_wheel_friction
from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.delay_line import Sent, empty_line, is_delay, pushed
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionTorqueEstimate, FrictionTorqueFilter


class FrictionFilterMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        controller: Memory of the controller that demands the torques.
        estimate: Friction estimates of all wheels, with leading axis wheels.
        torque: Torques commanded at the last samples, the oldest first, (delay + 1, wheels), N·m.
        period: Control period, s.
    """

    controller: Any
    estimate: FrictionTorqueEstimate
    torque: Sent
    period: Scalar


class FrictionFilterFeedForward(Checked):
    """Friction feed-forward m_i = u_i + N_i, with N_i estimated without a friction model.

    The filter of Moreira, Lopes and Kuga uses the momentum of each rotor in inertial space, which
    only motor and bearing change. A wheel with a demand of exactly zero, such as a failed one, is
    not compensated. For a wheel without a tachometer measurement, the estimate is only predicted.

    Attributes:
        controller: Controller that demands the torques u_i. It gets the measurement with the field
            `wheel_friction`, the estimates N_i, (wheels,), N·m.
        filter: Filter of one wheel.
        axes: Spin axes in body axes, (3, wheels).
        inertia: Spin inertia of the rotors assumed by the controller, (wheels,), kg·m².
        torque_limit: Torque limits, (wheels,), N·m.
        delay: Number of control periods from a sample to the start of its command.
    """

    controller: Any
    filter: FrictionTorqueFilter
    axes: Float[Array, "3 wheels"]
    inertia: PerWheel
    torque_limit: PerWheel
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    def start(self, period: Scalar) -> FrictionFilterMemory:
        """Initial memory."""
        zero = jnp.zeros(self.axes.shape[-1])
        estimate = jax.vmap(self.filter.start)(zero)
        period = jnp.asarray(period, dtype=float)
        torque = empty_line(zero, self.delay + 1)
        return FrictionFilterMemory(self.controller.start(period), estimate, torque, period)

    def predicted(
        self, memory: FrictionFilterMemory, measurement: Any, command: Any
    ) -> FrictionFilterMemory:
        """Memory after a period without a sample: all estimates are predicted.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Safe command that is sent.
        """
        impulse = memory.torque[0] * memory.period
        estimate = jax.vmap(lambda e, value: self.filter.predict(e, value, memory.period))(
            memory.estimate, impulse
        )
        controller = predicted(self.controller, memory.controller, measurement, command)
        line, _ = pushed(memory.torque, command.torque)
        return FrictionFilterMemory(controller, estimate, line, memory.period)

    def __call__(self, memory: FrictionFilterMemory, measurement: Any) -> tuple[Any, Any]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `rate` (3,), rad/s, `wheel_speed` (wheels,), relative to
                the body, rad/s, `wheel_measured` (wheels,), and the fields that the controller
                needs.
        """
        axes, filter = jnp.asarray(self.axes), self.filter
        momentum = self.inertia * (measurement.wheel_speed + axes.T @ measurement.rate)
        momentum = jnp.where(measurement.wheel_measured, momentum, jnp.nan)

        def update(estimate: Any, torque: Scalar, momentum: Scalar) -> FrictionTorqueEstimate:
            estimate = filter.predict(estimate, torque * memory.period, memory.period)
            return filter.correct(estimate, momentum)

        estimate = jax.vmap(update)(memory.estimate, memory.torque[0], momentum)
        inner_measurement = with_wheel_friction(measurement, jnp.asarray(estimate.friction))
        controller, command = self.controller(memory.controller, inner_measurement)
        demand = command.torque
        torque = demand + jnp.where(demand == 0.0, 0.0, estimate.friction)
        torque = jnp.clip(torque, -self.torque_limit, self.torque_limit)
        line, _ = pushed(memory.torque, torque)
        next_memory = FrictionFilterMemory(controller, estimate, line, memory.period)
        return next_memory, command._replace(torque=torque)
