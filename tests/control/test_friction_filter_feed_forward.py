"""Friction that is found and compensated, by the books of rotors whose friction is known."""

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest

from gyrostat.control import FrictionFilterFeedForward
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionTorqueFilter
from gyrostat.spacecraft import SpacecraftMeasurement

PERIOD, COUNT, DELAY = 0.25, 400, 2
AXES = np.array([[1.0, 0.0, 0.6, 0.0], [0.0, 1.0, 0.8, 0.0], [0.0, 0.0, 0.0, 1.0]])
FRICTION = np.array([2e-3, -1e-3, 1.5e-3, 5e-4])
ROTORS = np.full(4, 0.015)
RATE = np.array([0.02, -0.01, 0.03])


class Torques(NamedTuple):
    torque: object


class Demands:
    """Of the last wheel nothing, of the others torques that change."""

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, samples, measurement):
        demand = 3e-3 * jnp.sin(0.2 * samples + jnp.arange(4.0))
        return samples + 1.0, Torques(demand * jnp.array([1.0, 1.0, 1.0, 0.0]))


COMPENSATED = FrictionFilterFeedForward(
    Demands(), FrictionTorqueFilter(1e-4, 1e-5, 0.01), AXES, ROTORS, np.full(4, 0.1), DELAY
)


def flown(compensator, lost=COUNT):
    """What is added to the demands; the tachometer of the first wheel is lost from a sample on."""

    def step(carry, k):
        memory, momentum, under_way = carry
        measured = jnp.ones(4, bool).at[0].set(k < lost)
        relative = momentum / ROTORS - AXES.T @ RATE
        seen = jnp.where(measured, relative, 1e3)
        sample = SpacecraftMeasurement(jnp.zeros(4), jnp.asarray(RATE), seen, measured)
        memory, command = compensator(memory, sample)
        momentum = momentum + PERIOD * (under_way[0] - FRICTION)
        under_way = jnp.concatenate([under_way[1:], command.torque[None]])
        demand = Demands()(k * 1.0, sample)[1].torque
        return (memory, momentum, under_way), command.torque - demand

    # by the loop, what is commanded at a sample acts from so many later on
    start = (compensator.start(PERIOD), jnp.zeros(4), jnp.zeros((DELAY, 4)))
    return np.array(jax.jit(lambda: jax.lax.scan(step, start, jnp.arange(COUNT))[1])())


def test_the_friction_of_each_wheel_is_found_and_added():
    added = flown(COMPENSATED)
    np.testing.assert_allclose(added[-50:, :3], np.tile(FRICTION[:3], (50, 1)), rtol=1e-6)
    assert np.all(added[:, 3] == 0.0)


def test_without_its_tachometer_a_wheel_keeps_the_friction_that_it_had():
    added = flown(COMPENSATED, lost=300)
    np.testing.assert_allclose(added[300:, 0], FRICTION[0], rtol=1e-6)


def test_a_delay_that_is_not_told_disturbs_what_is_found():
    added = flown(dataclasses.replace(COMPENSATED, delay=0))
    assert np.max(np.abs(added[-50:, :3] / FRICTION[:3] - 1.0)) > 0.05


def test_the_sum_keeps_the_limit_of_the_wheel():
    limited = dataclasses.replace(COMPENSATED, torque_limit=np.full(4, 3e-3))
    memory = limited.start(PERIOD)._replace(controller=np.array(8.0))
    _, command = jax.jit(lambda memory, seen: limited(memory, seen))(memory, seen())
    assert np.max(np.abs(command.torque)) <= 3e-3


def seen():
    return SpacecraftMeasurement(np.zeros(4), np.zeros(3), -1.0 / ROTORS, np.ones(4, bool))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"delay": -1}, "command delay: found -1"),
        ({"filter": FrictionTorqueFilter(0.0, 1.0, 1.0)}, "momentum_sigma: found 0"),
    ],
)
def test_what_cannot_work_is_refused(changes, message):
    with pytest.raises(InputError, match=message):
        dataclasses.replace(COMPENSATED, **changes).check()
