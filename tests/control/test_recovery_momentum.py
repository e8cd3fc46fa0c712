"""Recovery with the working wheels and the momentum, on the reduced gyrostat."""

from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import MomentumRecovery
from gyrostat.control.underactuated.two_wheel_law import NO_WAY
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

TORQUE, MOMENTUM = 0.1, 3.0
ROTORS = 0.005
PYRAMID = np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], [0.8, 0.8, 0.8, 0.8]])
PYRAMID /= np.linalg.norm(PYRAMID, axis=0)


class Case(NamedTuple):
    plant: ReducedGyrostat
    controller: MomentumRecovery
    state: ReducedState
    allowed: float


def quaternion(rotation):
    return jnp.asarray(np.roll(rotation.as_quat(), 1))


def craft(inertia, axes):
    count = axes.shape[1]
    own, ones = jnp.full(count, ROTORS), jnp.ones(count)
    return Spacecraft(
        jnp.asarray(inertia), WheelArray(jnp.asarray(axes), own, TORQUE * ones, MOMENTUM * ones)
    )


def draw(random, *, error=0.0, rest=True, across=(0.3, 2.8)):
    """Three orthogonal wheels, one of which has failed with momentum in it."""
    works = np.arange(3) != random.integers(3)
    normal = np.eye(3)[~works][0]
    turn = Rotation.random(rng=random).as_matrix()
    principal = np.array([8.0, 12.0, 16.0])
    rho, held = random.uniform(*across), random.uniform(-2.0, 2.0)

    def inertia(factor):
        matrix = turn @ np.diag(principal * factor) @ turn.T
        return 0.5 * (matrix + matrix.T)

    def body():
        phase = random.uniform(-np.pi, np.pi)
        return rho * np.insert([np.cos(phase), np.sin(phase)], int(np.argmin(works)), 0) + (
            held * normal
        )

    start, rotors = Rotation.random(rng=random), body()
    total = start.apply(rotors)
    if not rest:
        start = Rotation.random(rng=random)
        rotors = np.where(works, np.clip(start.inv().apply(total), -2.9, 2.9), rotors)
    wanted, goal = body(), Rotation.random(rng=random)
    goal = goal * Rotation.align_vectors(goal.inv().apply(total)[None], wanted[None])[0]
    controller = MomentumRecovery.plan(
        craft(inertia(1.0 + error * random.choice([-1.0, 1.0], 3)), np.eye(3)),
        works,
        total_momentum=total,
        target=quaternion(goal),
    )
    plant = ReducedGyrostat(craft(inertia(1.0), np.eye(3)), jnp.asarray(works), jnp.asarray(total))
    state = ReducedState(quaternion(start), jnp.asarray(rotors))
    return Case(plant, controller, state, 100.0 + 15.0 * 16.0 / rho)


def arrays(case):
    """Its plain numbers, which would be compiled in, for each case anew."""
    return jax.tree.map(
        lambda leaf: jnp.asarray(leaf, float) if isinstance(leaf, float) else leaf, case
    )


def at_target(case):
    """The state of rest there."""
    law = case.controller.law
    return ReducedState(law.target, rotations.to_body(law.target, law.total_momentum))


def measured(case, state):
    return ReducedSensor(case.plant)(None, state, jax.random.key(0))[1]


@eqx.filter_jit
def flown(items, count, period=0.5):
    """Pointing errors, rad, and what was commanded."""

    def single(plant, controller, state):
        histories = run(
            plant, controller, ReducedSensor(plant), state, jax.random.key(0), period, count=count
        )
        target = controller.law.target
        errors = jax.vmap(lambda q: rotations.error_angle(q, target))(histories.state.attitude)
        momenta = controller.rotor_inertia * histories.measurement.wheel_speed
        return errors, histories.command.torque, momenta

    return eqx.filter_vmap(single)(*items)


@eqx.filter_jit
def _commanded(case, memory, state):
    return case.controller(memory, measured(case, state))


def commanded(case, memory, state):
    """Memory and command; no weak types, so that it is compiled once."""
    strong = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.asarray(leaf).dtype), memory)
    return _commanded(case, strong, state)


@eqx.filter_jit
def carried(plant, state, command, period):
    return plant(state, command, 0.0, period)[0]


def loop_slope(case, rest, works, memory, period):
    """Derivative of turn, momentum and what the controller remembers of it, a period later.

    By central differences next to rest, so that one program of the controller serves all tests.
    """
    target = Rotation.from_quat(np.array(rest.attitude), scalar_first=True)
    memory = jax.tree.map(np.asarray, memory)

    def after(small):
        attitude = (target * Rotation.from_rotvec(small[:3])).as_quat(scalar_first=True)
        rotors, wheels = np.array(rest.rotor_momentum), jax.tree.map(np.array, memory.wheels)
        rotors[works] += small[3:5]
        wheels.momentum[works] += small[5:7]
        wheels.torque[0, works] += small[7:9]
        wheels.drag[works] += small[9:]
        state = ReducedState(attitude, rotors)
        last, command = commanded(case, memory._replace(wheels=wheels), state)
        state = carried(case.plant, state, command, period)
        turned = target.inv() * Rotation.from_quat(np.array(state.attitude), scalar_first=True)
        return np.concatenate(
            [
                turned.as_rotvec(),
                np.asarray(state.rotor_momentum - rest.rotor_momentum)[works],
                np.asarray(last.wheels.momentum)[works] - memory.wheels.momentum[works],
                np.asarray(last.wheels.torque)[-1][works],
                np.asarray(last.wheels.drag)[works],
            ]
        )

    near, step = np.full(11, 2e-7), 1e-7 * np.eye(11)
    return np.stack([(after(near + one) - after(near - one)) / 2e-7 for one in step], axis=1)


wanted_rate = eqx.filter_jit(lambda law, *state: law(*state))


@pytest.mark.parametrize("rest", [True, False])
def test_settles_in_time_with_an_inertia_that_is_wrong(rest):
    random = np.random.default_rng(11)
    cases = [draw(random, error=0.05, rest=rest) for _ in range(24)]
    items = tuple(stack([case[k] for case in cases]).items for k in range(3))
    errors, torques, momenta = (np.asarray(x) for x in flown(items, 2000))
    for case, error in zip(cases, errors, strict=True):
        assert np.all(error[int(np.ceil(case.allowed / 0.5)) :] < np.radians(0.05))
    assert np.abs(torques).max() <= TORQUE
    # a wheel at its limit gains a little relative to a body that turns under it
    assert np.abs(momenta).max() <= MOMENTUM + 0.1 * ROTORS
    for case, torque in zip(cases, torques, strict=True):
        assert np.all(torque[:, ~np.asarray(case.plant.working)] == 0.0)


def test_rest_at_the_target_is_a_fixed_point():
    case = arrays(draw(np.random.default_rng(2)))
    memory = case.controller.start(0.5)
    for _ in range(2):
        memory, command = commanded(case, memory, at_target(case))
        np.testing.assert_allclose(command.torque, 0.0, atol=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_wanted_rate_is_one_that_the_wheels_can_choose(seed):
    random = np.random.default_rng(seed)
    case = arrays(draw(random))
    law, inertia = case.controller.law, np.asarray(case.plant.spacecraft.inertia)
    normal, total = np.array(law.normal), np.array(law.total_momentum)
    limit = 0.99 * np.linalg.norm(total)
    for _ in range(8):
        turn, held = Rotation.random(rng=random), np.clip(random.uniform(-2.0, 2.0), -limit, limit)
        rate, _ = wanted_rate(law, quaternion(turn), held, np.zeros(3), NO_WAY)
        body = turn.inv().apply(total)
        np.testing.assert_allclose(normal @ inertia @ rate, normal @ body - held, atol=1e-12)


@pytest.mark.parametrize("across", [(0.1, 0.11), (2.5, 2.8)])
def test_linear_part_has_the_rates_that_the_gains_say(across):
    # sampled quickly, the poles of the loop are exp(-rate period)
    period = 0.002
    case = arrays(draw(np.random.default_rng(4), across=across))
    memory, _ = commanded(case, case.controller.start(period), at_target(case))
    # the drag filter would answer a jump of the wheels that no torque made
    case = case._replace(
        controller=eqx.tree_at(
            lambda c: c.law.wheels.drag_time, case.controller, jnp.array(1e12, float)
        )
    )
    law, works = case.controller.law, np.flatnonzero(case.plant.working)
    # of turn and momentum alone: what is remembered stays as it is
    slope = loop_slope(case, at_target(case), works, memory, jnp.array(period))[:5, :5]
    poles = np.linalg.eigvals(slope)
    rates = np.sort(-np.log(poles.real) / period)
    assert np.abs(poles.imag).max() < 1e-4
    gain = law.wheels.gain
    np.testing.assert_allclose(rates[1:], [law.roll_gain, law.tilt_gain, gain, gain], rtol=0.02)
    assert 0.05 < rates[0] <= law.lag_gain * 1.02


def test_sampled_loop_is_stable_about_the_target():
    for seed, across in ((0, (0.1, 0.11)), (1, (2.0, 2.8))):
        case = arrays(draw(np.random.default_rng(seed), error=0.05, across=across))
        rest, works = at_target(case), np.flatnonzero(case.plant.working)
        memory, _ = commanded(case, case.controller.start(0.5), rest)
        slope = loop_slope(case, rest, works, memory, jnp.array(0.5))
        assert np.abs(np.linalg.eigvals(slope)).max() < 0.99


def test_four_wheels_less_one_reach_any_attitude():
    random = np.random.default_rng(8)
    cases = []
    for _ in range(8):
        works = np.arange(4) != random.integers(4)
        start, goal = (Rotation.random(rng=random) for _ in range(2))
        rotors = random.uniform(-1.0, 1.0, 4) * works
        rate = random.uniform(-0.05, 0.05, 3)
        body = craft(np.diag([8.0, 12.0, 16.0]), PYRAMID)
        total = start.apply(np.diag([8.0, 12.0, 16.0]) @ rate + PYRAMID @ rotors)
        # hold what the target needs: less than half of what the wheels can
        scale = min(1.0, 1.0 / np.linalg.norm(total))
        total, rotors = total * scale, rotors * scale
        controller = MomentumRecovery.plan(
            body, works, total_momentum=total, target=quaternion(goal)
        )
        plant = ReducedGyrostat(body, jnp.asarray(works), jnp.asarray(total))
        cases.append((plant, controller, ReducedState(quaternion(start), jnp.asarray(rotors))))
    items = tuple(stack([case[k] for case in cases]).items for k in range(3))
    errors = np.asarray(flown(items, 500)[0])
    assert errors[:, 400:].max() < np.radians(0.05)


def test_refuses_what_it_cannot_do():
    body = craft(12.0 * np.eye(3), np.eye(3))
    still = (1.0, 0.0, 0.0, 0.0)
    with pytest.raises(InputError, match=r"span 1 directions, expected 2 or 3"):
        MomentumRecovery.plan(
            body, [True, False, False], total_momentum=[1.0, 0.0, 0.0], target=still
        )
    with pytest.raises(InputError, match=r"across the normal of the working wheels"):
        MomentumRecovery.plan(
            body, [True, True, False], total_momentum=[0.0, 0.0, 1.0], target=still
        )
