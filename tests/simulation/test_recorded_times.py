"""With a command delay: what a controller records stands at its sample, actuators get it later."""

from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest

from gyrostat.codegen.simd import compiler
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import simulate

PERIOD, COUNT = 0.1, 40
ENGINES = ["jax", *(["native"] if compiler() else [])]


class Motion(NamedTuple):
    position: float
    rate: float


class Aim(NamedTuple):
    """The plant takes `push` alone."""

    target: float
    push: float
    seen: float


class Cart(eqx.Module):
    """A unit mass; it may hand its whole command on to a compiled function and into a scan."""

    hands_on: bool = eqx.field(static=True, default=False)

    def diverged(self, state):
        return jnp.abs(state.position) > 1e6

    def record(self, state, command):
        return Pushed(command.push)

    def __call__(self, state, command, time, duration):
        if not self.hands_on:
            return pushed(state, command, duration), jnp.array(True)

        def step(carry, _):
            state, command = carry
            return (jax.jit(pushed)(state, command._replace(seen=0.0), duration), command), None

        (state, _), _ = jax.lax.scan(step, (state, command), length=1)
        return state, jnp.array(True)


class Pushed(NamedTuple):
    given: float


def pushed(state, command, duration):
    rate = state.rate + command.push * duration
    return Motion(state.position + 0.5 * (state.rate + rate) * duration, rate)


class Sight(eqx.Module):
    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, state


class Following(eqx.Module):
    """Leads the cart after a target that moves from the first sample on."""

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, measurement):
        target = 2.0 + 0.7 * memory * PERIOD
        push = 0.3 * (target - measurement.position) + 0.8 * (0.7 - measurement.rate)
        return memory + 1.0, Aim(target, push, measurement.position)


def fly(delay, engine="jax", plant=None):
    return simulate(
        Cart() if plant is None else plant,
        Following(),
        Sight(),
        start=Motion(jnp.array(1.9), jnp.array(0.7)),
        duration=PERIOD * COUNT,
        control_period=PERIOD,
        command_delay=delay,
        engine=engine,
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_only_what_moves_the_plant_is_delayed(engine):
    delay = 3
    data = fly(delay, engine)
    target = 2.0 + 0.7 * data.time.values
    np.testing.assert_allclose(data.target, target, rtol=1e-14)
    np.testing.assert_array_equal(data.seen, data.measured_position)
    np.testing.assert_array_equal(data.measured_position, data.position)
    made = 0.3 * (target - data.position.values) + 0.8 * (0.7 - data.rate.values)
    np.testing.assert_array_equal(data.push[:delay], 0.0)
    np.testing.assert_allclose(data.push[delay:], made[:-delay], rtol=1e-12, atol=1e-15)
    # the plant records what acts
    np.testing.assert_array_equal(data.given, data.push)
    # it is 0.1 behind at first, and no further until the first command acts
    error = (data.target - data.position).values
    np.testing.assert_allclose(error[: delay + 1], 0.1, rtol=1e-12)


def test_a_command_that_is_handed_on_as_a_whole_is_told_apart_too():
    alone, handed = fly(2), fly(2, plant=Cart(hands_on=True))
    for name in alone.data_vars:
        np.testing.assert_array_equal(handed[name], alone[name], err_msg=name)
