"""Controller of one's own for own_controller.toml."""

from typing import Annotated, Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

import gyrostat as gs
from gyrostat.control import PseudoInverse


class Command(NamedTuple):
    """Command of the controller; further fields would be recorded with it."""

    torque: Any  # motor torques, (wheels,), N·m


class AttitudePD(eqx.Module):
    """Proportional and derivative attitude control, with the torque distributed over the wheels."""

    kp: Annotated[float, gs.Key("N·m/rad", meaning="Proportional gain.", least=0.0)]
    kd: Annotated[float, gs.Key("N·m·s/rad", meaning="Derivative gain.", least=0.0)] = 0.03
    spacecraft: Any = None  # given: the spacecraft as the controller knows it

    def start(self, period):
        """Return the memory before the first sample: none is needed."""
        return ()

    def __call__(self, memory, measurement):
        """Return the memory and the command."""
        attitude, wheels = measurement.attitude, self.spacecraft.wheels
        error = 2.0 * attitude[1:] * jnp.sign(attitude[0])
        torque = -self.kp * error - self.kd * measurement.rate
        works = jnp.ones(wheels.count, bool)
        # the motor torques act on the body with the opposite sign
        return memory, Command(PseudoInverse()(wheels.axes, wheels.torque_limit, works, -torque))
