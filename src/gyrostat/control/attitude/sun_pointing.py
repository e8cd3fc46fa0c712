"""Sun pointing: one body axis towards the measured direction of the Sun, by wheels."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np

from gyrostat.control.allocation.allocation import PseudoInverse, within_limits
from gyrostat.control.measured import measured
from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.checked import Checked, direction, positive, signed
from gyrostat.core.jax64 import jnp
from gyrostat.core.traced_once import one_function
from gyrostat.spacecraft import Spacecraft, WheelTorqueCommand
from gyrostat.wheel.array import listed, zeros

LEAST_CURRENT = 0.3
"""Length of the direction from sun cells below which the Sun is not seen, relative to sunlight."""


def measured_sun(measurement: Any) -> Vector3:
    """Direction of the Sun in body axes, a unit vector, (3,), or zero if it is not seen.

    Args:
        measurement: Measurement with `sun_sensor` (3,), or else with `coarse_sun_sensors` (6,), the
            cells on the faces of a cube, in the order +x, -x, +y, -y, +z, -z.

    Raises:
        InputError: The measurement has neither.
    """
    if hasattr(measurement, "coarse_sun_sensors") and not hasattr(measurement, "sun_sensor"):
        cells = measurement.coarse_sun_sensors
        along, threshold = cells[0::2] - cells[1::2], LEAST_CURRENT
    else:
        along, threshold = measured(measurement, "sun_sensor", "sun pointing"), 0.0
    squared = along @ along
    return jnp.where(squared > threshold**2, along / jnp.sqrt(jnp.maximum(squared, 1e-300)), 0.0)


class SunPointing(Checked):
    """Sun pointing by wheels: A u = -w x H - k J (w_d - w), w_d = k_t e, limited in size.

    e is the rotation that turns the body axis to the Sun, the shortest one. If the Sun is opposite
    to the axis, the body turns about any axis across it. If the Sun is not seen, w_d is
    `search_rate`: by default the rate is damped only. The rate about the Sun is damped in any case.
    The law does not use the attitude. The wheels share the torque by the pseudo-inverse.

    Attributes:
        spacecraft: Spacecraft model of the controller; every wheel works.
        axis: Body axis that shall point to the Sun, (3,), of any length.
        turn_gain: Gain k_t from angle to commanded rate, 1/s.
        rate_gain: Gain k of the rate loop, 1/s.
        largest_rate: Largest commanded rate, rad/s.
        search_rate: Commanded rate while the Sun is not seen, body axes, (3,), rad/s.
    """

    spacecraft: Spacecraft
    axis: Annotated[Vector3, direction("axis of the sun pointing")] = eqx.field(
        converter=listed, default_factory=lambda: np.array([0.0, 0.0, 1.0])
    )
    turn_gain: Annotated[Scalar, positive("turn gain", "1/s")] = 0.05
    rate_gain: Annotated[Scalar, positive("rate gain", "1/s")] = 0.2
    largest_rate: Annotated[Scalar, positive("largest rate", "rad/s")] = 0.02
    search_rate: Annotated[Vector3, signed("size of the search rate", "rad/s")] = zeros()

    def start(self, period: Scalar) -> tuple[()]:
        """Initial memory; empty."""
        return ()

    def __call__(self, memory: tuple[()], measurement: Any) -> tuple[tuple[()], WheelTorqueCommand]:
        """Compute the wheel torques.

        Args:
            memory: Empty memory.
            measurement: Measurement with `sun_sensor` or `coarse_sun_sensors`, see `measured_sun`,
                `rate` (3,), rad/s, and `wheel_speed` (wheels,), rad/s.

        Raises:
            InputError: The measurement has no sensor of the Sun.
        """
        torque = self._torque(measured_sun(measurement), measurement.rate, measurement.wheel_speed)
        return memory, WheelTorqueCommand(torque)

    @one_function
    def _torque(self, sun: Vector3, rate: Vector3, wheel_speed: PerWheel) -> PerWheel:
        """Wheel torques, (wheels,), N·m.

        Args:
            sun: Measured direction of the Sun, (3,); zero for none.
            rate: Measured rate, (3,), rad/s.
            wheel_speed: Measured wheel speeds, (wheels,), rad/s.
        """
        wheels = self.spacecraft.wheels
        axes, inertia = jnp.asarray(wheels.axes), jnp.asarray(self.spacecraft.inertia)
        target_rate = jnp.where(sun @ sun > 0.0, self._turn_rate(sun), self.search_rate)
        absolute = wheels.inertia * (wheel_speed + axes.T @ rate)
        momentum = inertia @ rate + axes @ absolute
        demand = -jnp.cross(rate, momentum) - self.rate_gain * (inertia @ (target_rate - rate))
        limit = jnp.ones(wheels.count) * wheels.torque_limit
        torque = PseudoInverse()(axes, limit, jnp.ones(wheels.count, bool), demand)
        return within_limits(torque, limit)

    def _turn_rate(self, sun: Vector3) -> Vector3:
        """Commanded rate, (3,), rad/s, towards a direction of the Sun."""
        axis = jnp.asarray(self.axis)
        axis = axis / jnp.sqrt(axis @ axis)
        normal, cosine = jnp.cross(axis, sun), axis @ sun
        sine = jnp.sqrt(normal @ normal)
        # any axis across: from the body axis with the smallest component along `axis`
        unit = (jnp.arange(3) == jnp.argmin(jnp.abs(axis))).astype(float)
        spare = jnp.cross(axis, unit)
        spare = spare / jnp.sqrt(spare @ spare)
        opposite = (sine < 1e-6) & (cosine < 0.0)
        about = jnp.where(opposite, spare, normal / jnp.maximum(sine, 1e-12))
        rate = jnp.minimum(self.turn_gain * jnp.arctan2(sine, cosine), self.largest_rate)
        return rate * about
