"""A thousand runs of a controller of one's own: python examples/own_controller_campaign.py."""

from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import jax.numpy as jnp

import gyrostat as gs
from gyrostat.control import PseudoInverse


class Command(NamedTuple):
    torque: Any


class AttitudePD(eqx.Module):
    kp: float
    kd: float = 0.03
    spacecraft: Any = None

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        attitude, wheels = measurement.attitude, self.spacecraft.wheels
        error = 2.0 * attitude[1:] * jnp.sign(attitude[0])
        torque = -self.kp * error - self.kd * measurement.rate
        works = jnp.ones(wheels.count, bool)
        return memory, Command(PseudoInverse()(wheels.axes, wheels.torque_limit, works, -torque))


scenario = Path(__file__).parent / "scenarios" / "zero_crossing.toml"
runs = gs.campaign(scenario, 1000, "demo-out/own", controller=AttitudePD(kp=0.004), force=True)
print(runs["error_p99.7"].quantile(0.95).item(), "rad")
