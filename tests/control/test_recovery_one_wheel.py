"""Recovery with one working wheel and the momentum, on the reduced gyrostat."""

from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import OneWheelRecovery
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.papers.carvalho_fenili.reduced_gyrostat import (
    ReducedGyrostat,
    ReducedSensor,
    ReducedState,
)
from gyrostat.simulation import stack
from gyrostat.simulation.loop import run
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel import WheelArray

TORQUE, MOMENTUM, ROTOR = 0.1, 3.0, 0.01
PERIOD = 0.5


class Case(NamedTuple):
    plant: ReducedGyrostat
    controller: OneWheelRecovery
    state: ReducedState
    time: float


def quaternion(rotation):
    return jnp.asarray(np.roll(rotation.as_quat(), 1))


def craft(inertia, axes=None):
    axes = np.eye(3) if axes is None else axes
    ones = jnp.ones(axes.shape[1])
    wheels = WheelArray(jnp.asarray(axes), ROTOR * ones, TORQUE * ones, MOMENTUM * ones)
    return Spacecraft(jnp.asarray(inertia), wheels)


def draw(random, *, error=0.0, cube=False, least=0.3):
    """One of three orthogonal wheels works, the others keep what they hold; the body tumbles."""
    works = np.arange(3) == random.integers(3)
    axis = np.eye(3)[works][0]
    principal = np.full(3, 12.0) if cube else np.array([8.0, 12.0, 16.0])
    turn = Rotation.random(rng=random).as_matrix()
    inertia, known = (
        turn @ np.diag(principal * factor) @ turn.T
        for factor in (1.0, 1.0 + error * random.choice([-1.0, 1.0], 3))
    )
    while True:
        body = np.where(works, random.uniform(-1.5, 1.5), random.uniform(-1.0, 1.0, 3))
        size, turned = np.linalg.norm(body), np.linalg.solve(inertia, axis)
        aside = np.linalg.norm(np.cross(body, turned)) / np.linalg.norm(turned)
        if size > 0.6 and min(abs(axis @ body), aside) > least * size:
            break
    goal, start = Rotation.random(rng=random), Rotation.random(rng=random)
    total = goal.apply(body)
    controller = OneWheelRecovery.plan(
        craft(0.5 * (known + known.T)), works, total_momentum=total, target=quaternion(goal)
    )
    body_inertia = 0.5 * (inertia + inertia.T)
    plant = ReducedGyrostat(craft(body_inertia), jnp.asarray(works), jnp.asarray(total))
    rotors = np.where(works, random.uniform(-1.0, 1.0), body)
    state = ReducedState(quaternion(start), jnp.asarray(rotors))
    return Case(plant, controller, state, float(np.trace(inertia)) / 3.0 / size)


def at_target(case):
    """The state of rest there."""
    law = case.controller
    return ReducedState(law.target, rotations.to_body(law.target, law.total_momentum))


def measured(case, state):
    return ReducedSensor(case.plant)(None, state, jax.random.key(0))[1]


@eqx.filter_jit
def flown(items, count):
    """Pointing errors, rad, rates, torques and wheel momenta."""

    def single(plant, controller, state):
        histories = run(
            plant, controller, ReducedSensor(plant), state, jax.random.key(0), PERIOD, count=count
        )
        target = controller.target
        errors = jax.vmap(lambda q: rotations.error_angle(q, target))(histories.state.attitude)
        seen = histories.measurement
        momenta = controller.rotor_inertia * seen.wheel_speed
        return errors, seen.rate, histories.command.torque, momenta

    return eqx.filter_vmap(single)(*items)


@eqx.filter_jit
def loop_slope(case, rest, works, memory):
    """Derivative of turn and momentum a period after a small turn and change of momentum."""

    def after(small):
        turn = rotations.from_rotation_vector(small[:3])
        rotors = rest.rotor_momentum.at[works].add(small[3])
        state = ReducedState(rotations.product(rest.attitude, turn), rotors)
        _, command = case.controller(memory, measured(case, state))
        state, _ = case.plant(state, command, 0.0, PERIOD)
        back = rotations.rotation_vector(rotations.error(state.attitude, case.controller.target))
        return jnp.append(back, state.rotor_momentum[works] - rest.rotor_momentum[works])

    def column(direction):
        return jax.jvp(after, (1e-9 * jnp.ones(4),), (direction,))[1]

    # column by column, which compiles sooner than all together
    return jax.lax.map(column, jnp.eye(4)).T


@pytest.mark.parametrize("cube", [True, False])
def test_settles_from_tumbling_with_an_inertia_that_is_wrong(cube):
    random = np.random.default_rng(21)
    cases = [draw(random, error=0.05, cube=cube) for _ in range(12)]
    items = tuple(stack([case[k] for case in cases]).items for k in range(3))
    errors, rates, torques, momenta = (np.asarray(x) for x in flown(items, 4200))
    for case, error, rate in zip(cases, errors, rates, strict=True):
        last = int(100.0 * case.time / PERIOD)
        assert np.all(error[last:] < np.radians(0.05))
        assert np.all(np.linalg.norm(rate[last:], axis=1) < 1e-4)
    assert np.abs(torques).max() <= TORQUE
    assert np.abs(momenta).max() <= MOMENTUM + 0.1 * ROTOR
    for case, torque in zip(cases, torques, strict=True):
        assert np.all(torque[:, ~np.asarray(case.plant.working)] == 0.0)


def test_rest_at_the_target_is_a_fixed_point():
    case = draw(np.random.default_rng(2))
    _, command = case.controller(case.controller.start(PERIOD), measured(case, at_target(case)))
    np.testing.assert_allclose(command.torque, 0.0, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_sampled_loop_is_stable_about_the_target(seed):
    case = draw(np.random.default_rng(seed), error=0.05, least=0.15)
    rest, works = at_target(case), jnp.argmax(case.plant.working)
    memory, _ = case.controller(case.controller.start(PERIOD), measured(case, rest))
    # plain numbers would be compiled in, for each case anew
    numbers = jax.tree.map(jnp.asarray, case)
    poles = np.linalg.eigvals(loop_slope(numbers, rest, works, memory))
    assert np.all(np.abs(poles) < 1.0)
    assert (np.log(np.abs(poles)) / PERIOD * case.time).max() < -0.02


@pytest.mark.parametrize("seed", range(4))
def test_damping_takes_from_what_keeps_the_body_from_rest(seed):
    # with k as far from rest, D.J^-1 D falls along the motion, whatever the attitude
    random = np.random.default_rng(seed)
    case = draw(random)
    law, inertia = case.controller, np.asarray(case.controller.inertia)
    works = int(np.argmax(case.plant.working))
    wanted = np.asarray(rotations.to_body(law.target, law.total_momentum))

    def kept(attitude):
        away = rotations.to_body(attitude, law.total_momentum) - wanted
        return 0.5 * away @ jnp.linalg.solve(inertia, away)

    def slope(attitude, excess):
        rotors = at_target(case).rotor_momentum.at[works].add(excess)
        rate = case.plant.rate(ReducedState(attitude, rotors))
        turning = rotations.rate_of_quaternion(attitude, rate)
        return float(jax.jvp(kept, (attitude,), (turning,))[1])

    for _ in range(6):
        attitude = quaternion(Rotation.random(rng=random))
        body = rotations.to_body(attitude, law.total_momentum)
        excess = law.damping_excess(body, jnp.asarray(wanted))
        assert abs(slope(attitude, 0.0)) < 1e-12
        assert slope(attitude, excess) < -1e-9


def test_two_wheels_on_one_axis_share_the_torque():
    axes = np.array([[1.0, -1.0, 0.0], [0.0, 0.0, 0.6], [0.0, 0.0, 0.8]])
    body = np.array([0.5, 0.4, 0.2])
    controller = OneWheelRecovery.plan(
        craft(np.diag([8.0, 12.0, 16.0]), axes),
        [True, True, False],
        total_momentum=body,
        target=(1.0, 0.0, 0.0, 0.0),
    )
    np.testing.assert_allclose(controller.axis, [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(controller.allocation, [0.5, -0.5, 0.0], atol=1e-12)


def test_refuses_what_it_cannot_do():
    body, still = craft(12.0 * np.eye(3)), (1.0, 0.0, 0.0, 0.0)

    def plan(works, total):
        OneWheelRecovery.plan(body, works, total_momentum=total, target=still)

    with pytest.raises(InputError, match=r"span 2 directions, expected 1"):
        plan([True, True, False], [1.0, 0.0, 0.0])
    with pytest.raises(InputError, match=r"a\.b = 0"):
        plan([True, False, False], [0.0, 0.4, 0.3])
    with pytest.raises(InputError, match=r"b x J\^-1 a = 0"):
        plan([True, False, False], [0.7, 0.0, 0.0])
    with pytest.raises(InputError, match=r"total momentum: found zero"):
        plan([True, False, False], [0.0, 0.0, 0.0])
