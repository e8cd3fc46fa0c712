"""Momentum budget of a run: the momentum that each external torque adds."""

from collections.abc import Mapping
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_inertial
from gyrostat.core.types import Vector
from gyrostat.scenario.metrics.metric import Column, RunEnd
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.spacecraft import AnyActuator, Spacecraft, TorqueModel
from gyrostat.spacecraft.torque_models import commanded_torques

BUDGET = Column("N·m·s", "Size of the momentum that this external torque adds in the run.")
"""Column of each external torque."""


def gained(torque: str) -> str:
    """Name of the metric of an external torque."""
    return f"gained.{torque}"


class Budget(eqx.Module):
    """Integrals of external torques in inertial axes, by the rectangle rule.

    Attributes:
        spacecraft: Spacecraft of the run.
        torques: Name -> environment torque.
        actuators: Name -> actuator, driven by the field of the command with its name.
        period: Control period, s.
    """

    spacecraft: Spacecraft
    torques: Mapping[str, TorqueModel]
    actuators: Mapping[str, AnyActuator]
    period: Scalar

    def start(self) -> dict[str, Vector3]:
        """Integrals before the first sample."""
        actuators = (f"actuator.{name}" for name in self.actuators)
        return {name: jnp.zeros(3) for name in (*self.torques, *actuators)}

    def __call__(
        self, memory: dict[str, Vector3], sample: Sample, is_last: Bool[Array, ""]
    ) -> dict[str, Vector3]:
        """Integrals one control period later, N·m·s; nothing comes after the last sample."""
        period = jnp.where(is_last, 0.0, self.period)
        torques: dict[str, Any] = dict(self.torques)
        states = getattr(sample.state, "actuators", None)
        actuator_torques = commanded_torques(self.actuators, sample.command, states, sample.time)
        torques |= {f"actuator.{item.name}": item for item in actuator_torques}
        attitude = sample.state.attitude
        return {
            name: memory[name]
            + period * to_inertial(attitude, torque(self.spacecraft, attitude, sample.time))
            for name, torque in torques.items()
        }

    @classmethod
    def results(cls, memory: Any, end: RunEnd) -> dict[str, Vector]:
        """Momentum that each torque adds, (runs,), N·m·s."""
        return {gained(name): np.linalg.norm(sums, axis=-1) for name, sums in memory.items()}
