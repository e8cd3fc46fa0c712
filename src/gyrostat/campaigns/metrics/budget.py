"""Momentum budget of a run: the momentum that each external torque adds."""

from collections.abc import Mapping
from typing import Any

import equinox as eqx

from gyrostat.campaigns.metrics.sample import Sample
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_inertial
from gyrostat.spacecraft import Actuator, Spacecraft, TorqueModel
from gyrostat.spacecraft.torque_models import commanded_torques


class Budget(eqx.Module):
    """Integrals of external torques in inertial axes, by the rectangle rule.

    Attributes:
        spacecraft: Spacecraft of the run.
        torques: Name -> environment torque.
        actuators: Name -> actuator, driven by the field of the command with its name.
    """

    spacecraft: Spacecraft
    torques: Mapping[str, TorqueModel]
    actuators: Mapping[str, Actuator]

    def start(self) -> dict[str, Vector3]:
        """Integrals before the first sample."""
        actuators = (f"actuator.{name}" for name in self.actuators)
        return {name: jnp.zeros(3) for name in (*self.torques, *actuators)}

    def __call__(
        self, gained: dict[str, Vector3], sample: Sample, period: Scalar
    ) -> dict[str, Vector3]:
        """Integrals one control period later, N·m·s."""
        every: dict[str, Any] = dict(self.torques)
        commanded = commanded_torques(self.actuators, sample.command)
        every |= {f"actuator.{item.name}": item for item in commanded}
        attitude = sample.state.attitude
        return {
            name: gained[name]
            + period * to_inertial(attitude, torque(self.spacecraft, attitude, sample.time))
            for name, torque in every.items()
        }
