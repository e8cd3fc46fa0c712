"""The reduced gyrostat, against the full one and against its own invariants."""

import equinox as eqx
import numpy as np
import pytest

from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.papers.carvalho_fenili.reduced_gyrostat import (
    ReducedGyrostat,
    ReducedSensor,
    ReducedState,
)
from gyrostat.spacecraft import Gyrostat, Spacecraft, WheelTorqueCommand
from gyrostat.wheel import WheelArray

INERTIA = jnp.array([[12.0, 1.0, -0.5], [1.0, 9.0, 0.7], [-0.5, 0.7, 14.0]])
ROTORS = jnp.array([0.02, 0.03, 0.01])
CRAFT = Spacecraft(INERTIA, WheelArray(jnp.eye(3), ROTORS, 0.1 * jnp.ones(3), 3.0 * jnp.ones(3)))
ATTITUDE = rotations.normalised(jnp.array([0.8, 0.1, -0.4, 0.3]))


def plant(working=(True, True, True), total=(0.6, -1.1, 0.8)):
    return ReducedGyrostat(CRAFT, jnp.array(working), jnp.array(total))


def test_moves_as_the_full_one():
    full = Gyrostat(CRAFT)
    start = full.start(attitude=ATTITUDE, rate=(0.03, -0.05, 0.02), wheel_speed=(20.0, -9.0, 4.0))
    reduced = plant(total=start.momentum)
    rotors = ROTORS * (start.wheel_speed + full.rate(start))
    state = ReducedState(start.attitude, rotors)
    command = WheelTorqueCommand(jnp.array([0.04, -0.07, 0.02]))
    step, short = eqx.filter_jit(full), eqx.filter_jit(reduced)
    for k in range(40):
        start, _ = step(start, command, jnp.array(0.5 * k), jnp.array(0.5))
        state, _ = short(state, command, jnp.array(0.5 * k), jnp.array(0.5))
    assert rotations.error_angle(state.attitude, start.attitude) < 1e-6
    np.testing.assert_allclose(
        ReducedSensor(reduced)(None, state, jax.random.key(0))[1].wheel_speed * ROTORS,
        ROTORS * start.wheel_speed,
        atol=1e-7,
    )


def test_step_is_of_fourth_order():
    reduced = plant()
    command = WheelTorqueCommand(jnp.array([0.1, -0.05, 0.02]))
    start = ReducedState(ATTITUDE, jnp.array([0.3, -0.2, 0.1]))
    step = eqx.filter_jit(reduced)

    def after(count):
        state = start
        for _ in range(count):
            state, _ = step(state, command, jnp.array(0.0), jnp.array(8.0 / count))
        return state.attitude

    exact = after(256)
    coarse, fine = (rotations.error_angle(after(n), exact) for n in (8, 16))
    assert 3.5 < np.log2(coarse / fine) < 4.7


def test_limits_and_failed_wheels():
    reduced = plant(working=(True, True, False))
    start = ReducedState(ATTITUDE, jnp.array([0.0, 2.95, 0.5]))
    seen = reduced.relative_momentum(start)
    state, _ = reduced(start, WheelTorqueCommand(jnp.array([-9.0, 9.0, 9.0])), 0.0, 1.0)
    # what is left of the second wheel is told from its speed relative to the body
    np.testing.assert_allclose(state.rotor_momentum, [-0.1, 2.95 + 3.0 - seen[1], 0.5], atol=1e-15)


def test_refuses_a_momentum_that_is_none():
    with pytest.raises(InputError, match="total momentum: found"):
        plant(total=(0.0, np.nan, 1.0)).check()
