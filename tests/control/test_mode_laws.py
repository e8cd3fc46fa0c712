"""Laws of modes: what the others say of the wheels outlives a law that says nothing of them."""

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from gyrostat.control.guidance import ModeLaws
from gyrostat.core.arrays import PerWheel
from gyrostat.core.jax64 import jnp


class Torques(NamedTuple):
    torque: PerWheel


class Known(NamedTuple):
    torque: PerWheel
    works: PerWheel


class Silent:
    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        return memory, Torques(measurement)


class Knowing(Silent):
    def __call__(self, memory, measurement):
        return memory, Known(measurement, measurement < 1.0)


def test_lost_wheels_are_remembered_while_another_law_is_active():
    laws = ModeLaws((Knowing(), Silent()), jnp.array([0.0, 1.0]), (False, False), 2)
    memory, works = laws.start(1.0), []
    for mode, measurement in ((1, [2.0, 0.0]), (0, [2.0, 0.0]), (1, [0.0, 0.0]), (0, [0.0, 0.0])):
        now = SimpleNamespace(attitude=jnp.array([1.0, 0.0, 0.0, 0.0]))
        at = SimpleNamespace(mode=SimpleNamespace(number=jnp.array(mode)))
        active = laws.toward(SimpleNamespace(at=at, now=now))
        memory, command = active(memory, jnp.array(measurement))
        works.append(np.asarray(command.works).tolist())
    assert works == [[True, True], [False, True], [False, True], [True, True]]
