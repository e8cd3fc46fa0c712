"""Friction feed-forward from a Kalman filter on each wheel."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.missing_sample import predicted
from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.delay_line import Sent, empty_line, is_delay, pushed
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionTorqueEstimate, FrictionTorqueFilter


class FrictionFilterMemory(NamedTuple):
    """Between two samples.

    Attributes:
        controller: what the controller remembers.
        estimate: of every wheel.
        torque: (delay + 1, wheels) commanded at the last samples, the oldest first, N·m.
        period: control period, s.
    """

    controller: Any
    estimate: FrictionTorqueEstimate
    torque: Sent
    period: Scalar


class FrictionFilterFeedForward(Checked):
    """m_i = u_i + N_i, with N_i the friction torque that a filter finds without a friction model.

    The filter of Moreira, Lopes and Kuga on the momentum of each rotor in space, which motor and
    bearing alone change. A wheel of which the controller demands exactly nothing, as of a failed
    one, gets nothing; one whose tachometer is lost is predicted on.

    Attributes:
        controller: that demands the torques u_i.
        filter: of one wheel.
        axes: (3, wheels) spin axes in body axes.
        inertia: (wheels,) of the rotors as the controller knows them, kg·m².
        torque_limit: (wheels,) N·m.
        delay: control periods from a sample to the start of its command.
    """

    controller: Any
    filter: FrictionTorqueFilter
    axes: Float[Array, "3 wheels"]
    inertia: PerWheel
    torque_limit: PerWheel
    delay: Annotated[int, is_delay] = eqx.field(static=True, default=0)

    def start(self, period: Scalar) -> FrictionFilterMemory:
        """Nothing measured yet."""
        none = jnp.zeros(self.axes.shape[-1])
        estimate = jax.vmap(self.filter.start)(none)
        period = jnp.asarray(period, dtype=float)
        torque = empty_line(none, self.delay + 1)
        return FrictionFilterMemory(self.controller.start(period), estimate, torque, period)

    def predicted(
        self, memory: FrictionFilterMemory, measurement: Any, command: Any
    ) -> FrictionFilterMemory:
        """Memory one period later without a sample: every estimate predicted.

        Args:
            memory: from the last sample.
            measurement: last one that was accepted.
            command: that is sent.
        """
        impulse = memory.torque[0] * memory.period
        estimate = jax.vmap(lambda e, given: self.filter.predict(e, given, memory.period))(
            memory.estimate, impulse
        )
        controller = predicted(self.controller, memory.controller, measurement, command)
        sent, _ = pushed(memory.torque, command.torque)
        return FrictionFilterMemory(controller, estimate, sent, memory.period)

    def __call__(self, memory: FrictionFilterMemory, measurement: Any) -> tuple[Any, Any]:
        """Command the wheels.

        Args:
            memory: from the last sample.
            measurement: has `rate` (3,), rad/s, `wheel_speed` (wheels,) relative to the body,
                rad/s, and `wheel_measured` (wheels,), beside what the controller needs.
        """
        axes, filter = jnp.asarray(self.axes), self.filter
        momentum = self.inertia * (measurement.wheel_speed + axes.T @ measurement.rate)
        momentum = jnp.where(measurement.wheel_measured, momentum, jnp.nan)

        def learnt(estimate: Any, torque: Scalar, momentum: Scalar) -> FrictionTorqueEstimate:
            estimate = filter.predict(estimate, torque * memory.period, memory.period)
            return filter.correct(estimate, momentum)

        estimate = jax.vmap(learnt)(memory.estimate, memory.torque[0], momentum)
        controller, command = self.controller(memory.controller, measurement)
        demanded = command.torque
        torque = demanded + jnp.where(demanded == 0.0, 0.0, estimate.friction)
        torque = jnp.clip(torque, -self.torque_limit, self.torque_limit)
        sent, _ = pushed(memory.torque, torque)
        after = FrictionFilterMemory(controller, estimate, sent, memory.period)
        return after, command._replace(torque=torque)
