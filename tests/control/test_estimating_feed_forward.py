"""Friction compensation by estimated momenta, against rotors and bodies whose motion is known."""

import dataclasses
from typing import Any, ClassVar, NamedTuple

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.control import EstimatingFeedForward
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft, SpacecraftMeasurement
from gyrostat.wheel import WheelArray, pyramid_axes
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

PERIOD, COUNT, DELAY = 0.25, 400, 2
AXES, ROTORS = pyramid_axes(4), np.full(4, 2e-5)
INERTIA = np.array([[0.06, 0.002, 0.0], [0.002, 0.12, -0.001], [0.0, -0.001, 0.14]])
INVERSE = np.linalg.inv(INERTIA)
LIMIT, SPEED_SIGMA, RATE_SIGMA = 1e-3, 0.1, 3.5e-5
NOMINAL = Stribeck(np.full(4, 1e-7), np.full(4, 2e-5), np.full(4, 3e-5), np.full(4, 2.0))
TRUE = ViscousCoulomb(np.full(4, 1.2e-7), np.array([2.6e-5, 1.5e-5, 2e-5, 3e-5]))
STARTS = np.array([6.0, -8.0, 12.0, -5.0])
"""Initial wheel speeds, rad/s."""
USED = [0, 1, 3]
"""Wheels of which a torque is demanded."""
NO_FRICTION = ViscousCoulomb(np.zeros(4), np.zeros(4))


class Torques(NamedTuple):
    torque: object


class Demands(eqx.Module):
    """Torques that brake the wheels through zero speed, none of the third wheel, or that swing."""

    size: ClassVar[np.ndarray] = 1e-6 * np.array([-1.0, 1.2, 0.0, 0.8])
    swing: Any = 1.0
    frequency: Any = 0.0

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, samples, measurement):
        share = self.swing * jnp.cos(self.frequency * samples)
        return samples + 1.0, Torques(share * self.size)

    def predicted(self, samples, measurement, command):
        return samples + 100.0


def compensator(friction=NOMINAL, delay=DELAY, **changes):
    craft = Spacecraft(INERTIA, WheelArray(AXES, ROTORS, LIMIT, 1.0, friction))
    made = EstimatingFeedForward.tune(
        Demands(),
        craft,
        speed_sigma=SPEED_SIGMA,
        rate_sigma=RATE_SIGMA,
        period=PERIOD,
        delay=delay,
    )
    return dataclasses.replace(made, **changes)


def sample(speed, rate=None, attitude=(1.0, 0.0, 0.0, 0.0)):
    rate = np.zeros(3) if rate is None else rate
    given = (jnp.asarray(value, dtype=float) for value in (attitude, rate, speed))
    return SpacecraftMeasurement(*given, jnp.ones(4, bool))


def sampled(momenta):
    """Sample of a body whose total momentum stays at zero; its small turn is neglected."""
    rate = -INVERSE @ (AXES @ (momenta - ROTORS * STARTS))
    return sample(momenta / ROTORS - AXES.T @ rate, rate)


@eqx.filter_jit
def loop(law, friction, momenta, count, delay):
    """Speeds in inertial space, added torques and recorded friction; last memory and momenta."""

    def step(carry, k):
        memory, momenta, under_way = carry
        seen = sampled(momenta)
        memory, command = law(memory, seen)
        line = jnp.concatenate([under_way, command.torque[None]])
        torque = friction.torque(seen.wheel_speed, jnp.where(seen.wheel_speed < 0.0, -1.0, 1.0))
        after = momenta + PERIOD * (line[0] - torque)
        added = command.torque - Demands.size
        return (memory, after, line[1:]), (momenta / ROTORS, added, command.friction_torque)

    begin = (law.start(PERIOD), momenta, jnp.zeros((delay, 4)))
    (memory, momenta, _), every = jax.lax.scan(step, begin, jnp.arange(count))
    return *every, memory, momenta


def flown(law, friction, factor=30.0, count=COUNT, delay=None):
    """Results of `loop` for initial speeds of a factor times `STARTS`."""
    delay, momenta = law.delay if delay is None else delay, factor * ROTORS * STARTS
    # laws that differ by numbers share a program
    law, friction = jax.tree.map(lambda x: np.asarray(x, float), (law, friction))
    every = loop(law, friction, momenta, count, delay)
    return *(np.asarray(each) for each in every[:3]), *every[3:]


LEVEL = ViscousCoulomb(np.zeros(4), np.full(4, 2.6e-5))
KNOWN = ViscousCoulomb(np.zeros(4), np.full(4, 2e-5))
"""Constant friction torques: that of the wheels, and a model that is 23 % below."""


def test_the_friction_of_turning_wheels_is_found():
    speed, added, found, *_ = flown(compensator(), TRUE)
    true = np.asarray(TRUE.torque(speed, np.sign(speed)))
    # it changes by the viscous torque, which the estimate follows with a lag of about 3 s
    np.testing.assert_allclose(found[100:, USED], true[100:, USED], rtol=2e-3)
    assert np.all(added[:, 2] == -Demands.size[2])


def test_constant_friction_is_found_exactly():
    _, added, found, *_ = flown(compensator(KNOWN), LEVEL)
    expected = 2.6e-5 * np.sign(STARTS[:2])
    np.testing.assert_allclose(found[-1, :2], expected, rtol=1e-9)
    np.testing.assert_allclose(added[-1, :2], expected, rtol=1e-9)


@pytest.mark.parametrize(("largest", "compensated"), [(3.0, 6e-5), (6.0, 1e-4)])
def test_friction_is_compensated_up_to_the_stated_multiple_of_the_model(largest, compensated):
    """The wheels have five times the friction of the model."""
    worn = ViscousCoulomb(np.zeros(4), np.full(4, 1e-4))
    _, _, found, *_ = flown(compensator(KNOWN, gain=0.0, largest=largest), worn, factor=500.0)
    np.testing.assert_allclose(np.abs(found[-1, USED]), compensated, rtol=1e-6)


def test_the_momentum_lost_to_friction_is_returned():
    """Friction that is larger than expected: each wheel gets the momentum that was demanded."""
    demanded = 30.0 * STARTS[USED] + Demands.size[USED] / ROTORS[USED] * PERIOD * (COUNT - 1)
    errors = {}
    for gain in (1.0, 0.0):
        speed, *_ = flown(compensator(KNOWN, delay=0, gain=gain), LEVEL)
        errors[gain] = np.abs(speed[-1, USED] - demanded)
    assert np.max(errors[1.0]) < 1e-9
    assert np.min(errors[0.0]) > 0.1


def test_wheels_without_friction_get_what_is_demanded():
    _, added, found, *_ = flown(compensator(NO_FRICTION), NO_FRICTION, 1.0)
    assert np.max(np.abs(added[:, USED])) < 1e-9 * np.max(np.abs(Demands.size))
    assert np.all(found == 0.0)
    # also if the wheels do not move as they should
    _, _, found, *_ = flown(compensator(NO_FRICTION), TRUE, 1.0)
    assert np.all(found == 0.0)


def test_an_unknown_command_delay_disturbs_the_estimate():
    wrong = []
    for told in (DELAY, 0):
        law = compensator(KNOWN, delay=told, controller=Demands(20.0, 0.1))
        *_, found, _, _ = flown(law, LEVEL, delay=DELAY)
        wrong.append(np.max(np.abs(np.abs(found[200:, :2]) / 2.6e-5 - 1.0)))
    assert wrong[0] < 1e-3
    assert wrong[1] > 0.05


def test_momentum_and_external_torque_by_independent_books():
    """Any motion of body and wheels that keeps H = H_0 + T t, whatever moves the wheels."""
    law, random, count = compensator(), np.random.default_rng(3), 1600
    time = PERIOD * np.arange(count)[:, None]
    torque = np.array([3e-6, -2e-6, 1e-6])
    total = np.array([2e-3, -1e-3, 3e-3]) + torque * time
    turn = Rotation.from_rotvec(np.array([0.3, -0.2, 0.1]) * np.sin(0.01 * time))
    momenta = 1e-3 * np.cos(0.3 * time + np.arange(4.0))
    momenta += 1e-4 * random.normal(size=momenta.shape)
    rate = np.linalg.solve(INERTIA, (turn.inv().apply(total) - momenta @ AXES.T).T).T
    speed, attitude = momenta / ROTORS - rate @ AXES, np.roll(turn.as_quat(), 1, axis=1)

    def step(estimate, seen):
        estimate = law.filter.correct(estimate, sample(*seen))
        found = estimate.whole.momentum, estimate.whole.torque
        return law.filter.predict(estimate, jnp.zeros(4), PERIOD), found

    run = jax.jit(lambda seen: jax.lax.scan(step, law.filter.start(), seen)[1])
    found, external = run((speed, rate, attitude))
    # the filter starts without knowing the torque
    np.testing.assert_allclose(found[:800], total[:800], rtol=0.0, atol=3e-7)
    np.testing.assert_allclose(found[800:], total[800:], rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(external[-1], torque, rtol=1e-6)


def test_tachometers_and_gyro_are_weighted_by_their_noise():
    """Against the least squares of all measurements, each over its standard deviation."""
    law, random = compensator(), np.random.default_rng(4)
    counted, carried = 1e-3 * random.normal(size=4), 1e-3 * random.normal(size=3)
    noise = np.linalg.cholesky(RATE_SIGMA**2 * INERTIA @ INERTIA.T)
    rows = np.concatenate([np.eye(4) / (ROTORS * SPEED_SIGMA), np.linalg.solve(noise, AXES)])
    seen = np.concatenate([counted / (ROTORS * SPEED_SIGMA), np.linalg.solve(noise, carried)])
    expected = np.linalg.lstsq(rows, seen, rcond=None)[0]
    found = counted + law.filter.weight @ (carried - AXES @ counted)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    covariance = np.linalg.inv(rows.T @ rows)
    np.testing.assert_allclose(law.filter.variance, np.diag(covariance), rtol=1e-9)


def test_at_its_limit_the_motor_stays_there_and_nothing_winds_up():
    """The limit is below the friction, so that the wheels lose speed all the time."""
    limited = compensator(delay=0, torque_limit=np.full(4, 2.5e-5))
    speed, added, _, memory, momenta = flown(limited, LEVEL, count=100)
    assert np.max(np.abs(added + Demands.size)) <= 2.5e-5 * (1.0 + 1e-12)
    assert np.all(np.diff(np.abs(speed[:, :2]), axis=0) < 0.0)
    lost = np.abs(memory.demanded - momenta)[:2]
    assert np.all(lost < 2.6e-5 * 5.0 * PERIOD)


def test_without_samples_the_estimates_are_predicted():
    """Once the friction is known, the predicted momenta are those of the rotors."""
    law = compensator(KNOWN, delay=0)
    *_, memory, momenta = flown(law, LEVEL)

    @jax.jit
    def missed(memory, momenta):
        _, command = law(memory, sampled(momenta))
        for _ in range(3):
            # the command is that of the first sample that is missing
            memory = law.predicted(memory, sampled(momenta), command)
            momenta = momenta + PERIOD * (command.torque - 2.6e-5 * np.sign(STARTS))
        return memory, momenta

    memory, momenta = missed(memory, momenta)
    found = np.asarray(memory.estimate.wheels.momentum)
    np.testing.assert_allclose(found[:2], momenta[:2], rtol=1e-9)
    assert np.max(np.abs((memory.demanded - found)[:2])) < 1e-12
    assert float(memory.controller) == COUNT + 300.0


@pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
def test_both_engines_agree():
    """Commands for given speeds that pass zero, others in each lane."""
    law, random = compensator(), np.random.default_rng(5)
    every = np.linspace(1.0, -1.0, 80)[:, None] * STARTS * np.array([1.0, 0.6, 0.2])[:, None, None]
    every = every + 0.1 * random.normal(size=every.shape)

    def torques(speeds):
        def step(memory, speed):
            memory, command = law(memory, sample(speed))
            return memory, (command.torque, command.friction_torque, command.estimated_speed)

        return jax.lax.scan(step, law.start(PERIOD), speeds)[1]

    found = lanes(torques, (True,), (every,))(every)
    expected = jax.jit(jax.vmap(torques))(jnp.asarray(every))
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-16)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"delay": -1}, "command delay: found -1"),
        ({"band": 0.0}, "speed band of the compensator: found 0"),
        ({"doubt": -0.1}, "doubt of the compensator: found -0.1"),
        ({"largest": 0.0}, "largest compensated friction: found 0"),
    ],
)
def test_wrong_parameters_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        compensator(**changes).check()


def command_after(law, speed, momentum, torque, demanded, under_way, started=1.0):
    """Command, memory and corrected momentum after a sample that agrees with the estimate."""
    begin = law.start(PERIOD)
    walk = begin.estimate.wheels._replace(
        momentum=momentum,
        torque=torque,
        momentum_variance=np.full(4, 1e-12),
        covariance=np.zeros(4),
        torque_variance=np.full(4, 1e-14),
    )
    whole = begin.estimate.whole._replace(
        momentum=AXES @ momentum, started=np.full(3, started), momentum_variance=np.full(3, 1e-20)
    )
    estimate = begin.estimate._replace(whole=whole, wheels=walk)
    memory = begin._replace(estimate=estimate, demanded=demanded, under_way=under_way)
    after, command = law(memory, sample(speed))
    return command, after, law.filter.correct(estimate, sample(speed)).wheels


def test_the_command_is_that_of_the_equations():
    """The law of the docstring in NumPy: two commands are under way, speeds of both signs."""
    law = compensator()
    law = eqx.tree_at(lambda law: law.controller.swing, law, 0.5)
    demand = 0.5 * Demands.size
    speed = np.array([40.0, -30.0, 20.0, 0.02])
    momentum, torque = ROTORS * speed, 1e-6 * np.array([2.0, -1.0, 0.5, -0.2])
    under_way = 1e-6 * np.array([[1.0, 2.0, 0.0, -1.0], [-3.0, 1.0, 0.0, 2.0]])
    breakaway = np.asarray(NOMINAL.static)
    for lost in (1e-6, 1e-3):  # within the limit of its torque, and beyond
        demanded = momentum + PERIOD * (under_way.sum(axis=0) + 2.0 * torque) + lost
        command, memory, walk = command_after(law, speed, momentum, torque, demanded, under_way)
        np.testing.assert_allclose(walk.momentum, momentum, rtol=1e-9)
        ahead = momentum + PERIOD * (under_way.sum(axis=0) + 2.0 * torque)
        middle = (ahead + 0.5 * PERIOD * demand) / ROTORS
        certain = middle * ROTORS / (3.0 * np.sqrt(walk.momentum_variance))
        drive = np.clip((demand - torque) / (0.6 * breakaway), -2.0, 2.0) + certain
        sense = np.where(drive < 0.0, -1.0, 1.0)
        model = np.asarray(NOMINAL.torque(sense * np.abs(middle), sense))
        friction = np.minimum(np.abs(drive), 1.0) * model
        returned = np.minimum(lost, 2.0 * breakaway)  # the gain is 1 / s
        wanted = np.where(demand == 0.0, 0.0, demand + friction - torque + returned)
        np.testing.assert_allclose(command.estimated_speed, middle, rtol=1e-6)
        np.testing.assert_allclose(command.friction_torque, friction - torque, rtol=1e-6)
        np.testing.assert_allclose(command.torque, wanted, rtol=1e-6, atol=1e-14)
        # a friction torque whose sign is not known can jump
        doubt = (1.0 - np.minimum(np.abs(certain), 1.0) ** 2) * (0.5 * breakaway) ** 2
        variance = np.asarray(memory.estimate.wheels.torque_variance)
        # the walk of a period, which depends on the speed, is below 3e-14
        np.testing.assert_allclose(
            variance, np.maximum(walk.torque_variance, doubt), rtol=0, atol=3e-14
        )
        assert 0.2 < np.abs(certain[3]) < 0.8
        # h_u loses what the limit of the returned momentum cuts off
        kept = np.where(demand == 0.0, ahead, ahead + returned + PERIOD * demand)
        np.testing.assert_allclose(memory.demanded, kept, rtol=1e-6)
