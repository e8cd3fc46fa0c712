"""Wheels on bristles against an implicit solver, and the rest of a held wheel over hours."""

import itertools
from math import exp

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.jax64 import jax, jnp
from gyrostat.papers.moreira_lopes_kuga.bench_wheel import BenchWheel, TorqueCommand
from gyrostat.spacecraft import AirBearingTable, TableCommand
from gyrostat.wheel import Wheel, step_dry_friction
from gyrostat.wheel.friction import LuGre, Stribeck
from gyrostat.wheel.rodas import integrate

CURVE = Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
BENT = LuGre(CURVE, 0.8795e-2, 2.2e-3)
J, TABLE, MOTOR = 1.5e-3, 0.495, 0.0228


def table(friction, **options):
    return AirBearingTable(TABLE, Wheel(J, MOTOR, friction), **options)


@jax.jit
def _carried(plant, state, currents, duration):
    def tick(state, current):
        state, resolved = plant(state, TableCommand(current), 0.0, duration)
        return state, (state, resolved)

    return jax.lax.scan(tick, state, currents)


PART = 100
"""Currents in one call, so that it is compiled once."""


def carried(plant, state, currents, duration):
    """The table under one held current after another."""
    plant, state = jax.tree.map(lambda leaf: np.asarray(leaf, float), (plant, state))
    held = np.pad(currents, (0, -len(currents) % PART), mode="edge")
    parts = []
    for part in np.split(held, len(held) // PART):
        state, found = _carried(plant, state, part, np.asarray(duration))
        parts.append(found)
    return jax.tree.map(lambda *leaves: np.concatenate(leaves)[: len(currents)], *parts)


def reference(friction, currents, duration, fan):
    """Speed, deflection, attitude and rate by Radau, an interval at a time."""
    y, rows = np.zeros(4), []
    b, c, ts, ws = (float(v) for v in friction.curve.parameters().values())
    stiffness, damping = float(friction.stiffness), float(friction.damping)

    def rate(_, y, current):
        w, z, _, omega = y.tolist()
        level = c + (ts - c) * exp(-((w / ws) ** 2))
        z_rate = w - stiffness * abs(w) * z / level
        torque = stiffness * z + damping * z_rate + b * w
        turn = (fan - MOTOR * current + torque) / TABLE
        return [(MOTOR * current - torque) / J - turn, z_rate, omega, turn]

    for current in currents.tolist():
        y = solve_ivp(rate, (0.0, duration), y, "Radau", rtol=1e-11, atol=1e-15, args=(current,)).y[
            :, -1
        ]
        rows.append(y)
    return np.array(rows)


@pytest.mark.parametrize("stiffer", [1.0, 1e4])
def test_agrees_with_an_implicit_solver(stiffer):
    """Through breakaway, sliding, reversal and presliding; bristles soft, and stiff as metal."""
    friction = LuGre(CURVE, stiffer * BENT.stiffness, np.sqrt(stiffer) * BENT.damping)
    currents = np.repeat([0.06, -0.05, -0.06, 0.02, 0.03], 12)
    plant = table(friction, external_torque=1e-4)
    states, resolved = carried(plant, plant.start(), currents, 0.5)
    assert np.all(resolved)
    expected = reference(friction, currents, 0.5, 1e-4)
    found = np.column_stack([states.speed, states.bristle, states.attitude, states.rate])
    scale = np.max(np.abs(expected), axis=0)
    assert np.max(np.abs(found - expected) / scale) < 1e-6


def test_a_held_wheel_does_not_creep():
    """A constant current below breakaway for 10 000 s: bent, at rest, and not drifting."""
    plant = table(BENT)
    current = 0.8 * 0.8795e-3 / MOTOR
    states, resolved = carried(plant, plant.start(), np.full(1000, current), 10.0)
    assert np.all(resolved)
    settled = states.bristle[5:]
    np.testing.assert_allclose(settled, MOTOR * current / BENT.stiffness, rtol=1e-6)
    turned = states.wheel_angle
    # friction regularised over 0.01 rad/s would have turned the wheel by 100 rad
    assert abs(turned[-1] - turned[10]) < 1e-5
    assert np.max(np.abs(states.speed[10:])) < 1e-8


def test_presliding_is_a_damped_spring():
    """Small oscillation about the bent state: frequency and damping of the linear system."""
    plant = table(BENT)
    current = 0.1 * 0.8795e-3 / MOTOR
    times = 0.02
    states, _ = carried(plant, plant.start(), np.full(200, current), times)
    inertia = J * TABLE / (J + TABLE)
    omega = np.sqrt(BENT.stiffness / inertia)
    damping = (BENT.damping + CURVE.viscous) / (2.0 * inertia * omega)
    t = times * np.arange(1, 201)
    damped = omega * np.sqrt(1.0 - damping**2)
    steady = MOTOR * current / BENT.stiffness
    decay = np.exp(-damping * omega * t)
    expected = steady * (
        1.0 - decay * (np.cos(damped * t) + damping * omega / damped * np.sin(damped * t))
    )
    # the bristles slip a little at a tenth of the level: to that order the spring is linear
    assert np.max(np.abs(states.bristle - expected)) < 0.12 * steady


def test_momentum_is_conserved():
    plant = table(BENT)
    start = plant.start(speed=3.0)
    states, _ = carried(plant, start, np.tile([0.05, -0.05], 50), 0.3)
    momentum = plant.momentum(states)
    np.testing.assert_allclose(momentum, float(plant.momentum(start)), rtol=1e-12)


def test_sensitivities_are_those_of_differences():
    def end(coulomb, stiffness):
        curve = Stribeck(4.83e-6, coulomb, 0.9055e-3, 0.418879)
        plant = table(LuGre(curve, stiffness, BENT.damping))
        currents = jnp.asarray([0.06] * 5 + [-0.05] * 5)
        return _carried(plant, plant.start(), currents, 0.5)[0].speed

    # one program for both parameters, and for the differences
    slope_along = jax.jit(lambda point, tangent: jax.jvp(end, point, tangent))

    point = (0.8795e-3, BENT.stiffness)
    for k in range(2):
        step = 1e-4 * point[k]
        ahead, behind = (
            tuple(p + (s * step if i == k else 0.0) for i, p in enumerate(point)) for s in (1, -1)
        )
        tangent = tuple(1.0 if i == k else 0.0 for i in range(2))
        values = [float(slope_along(moved, tangent)[0]) for moved in (ahead, behind)]
        difference = (values[0] - values[1]) / (2.0 * step)
        slope = float(slope_along(point, tangent)[1])
        assert slope == pytest.approx(difference, rel=1e-4)


def test_the_integrator_is_of_fourth_order():
    """Fixed steps on a stiff problem with forcing, against Radau."""
    from gyrostat.wheel.rodas import _step

    def field(y, t):
        return jnp.array([-20.0 * (y[0] - jnp.cos(t)), 0.3 * y[0] * y[1] - jnp.sin(t)])

    exact = solve_ivp(
        lambda t, y: np.array([-20.0 * (y[0] - np.cos(t)), 0.3 * y[0] * y[1] - np.sin(t)]),
        (0.0, 2.0),
        [0.0, 1.0],
        "Radau",
        rtol=1e-13,
        atol=1e-14,
    ).y[:, -1]
    errors = []
    step = jax.jit(lambda y, t, h: _step(field, y, t, h)[0])
    for count in (40, 80, 160):
        y = jnp.array([0.0, 1.0])
        for k in range(count):
            y = step(y, 2.0 * k / count, 2.0 / count)
        errors.append(np.max(np.abs(np.asarray(y) - exact)))
    assert np.all(np.diff(-np.log2(errors)) > 3.6)


def test_a_tree_is_carried_as_its_numbers():
    """A rotation coupled to a decay, its state in two parts: closed form, size and shape kept."""
    decay = 3.0

    def field(state, time):
        turning, fading = state
        return jnp.array([-turning[1], turning[0]]), -decay * fading

    start = (jnp.array([1.0, 0.0]), jnp.array(2.0))
    scale = (jnp.ones(2), jnp.ones(()))
    (turned, faded), resolved = integrate(field, start, 2.0, scale=scale, tolerance=1e-10)
    assert bool(resolved)
    np.testing.assert_allclose(turned, [np.cos(2.0), np.sin(2.0)], rtol=1e-8)
    assert float(faded) == pytest.approx(2.0 * np.exp(-2.0 * decay), rel=1e-6)
    assert faded.shape == ()


@pytest.mark.parametrize("size", [1, 2, 5])
def test_elimination_is_that_of_lapack(size):
    from gyrostat.wheel.rodas import _eliminator

    random = np.random.default_rng(size)
    matrix = random.standard_normal((size, size)) + 4.0 * np.eye(size)
    right = random.standard_normal(size)
    found = _eliminator([list(row) for row in matrix])(list(right))
    np.testing.assert_allclose(np.array(found), np.linalg.solve(matrix, right), rtol=1e-12)


def test_too_hard_an_interval_is_said():
    """A pole inside the interval cannot be passed, and is not passed over in silence."""
    _, resolved = integrate(
        lambda y, t: y**2, jnp.array([1.0]), 2.0, scale=jnp.ones(1), tolerance=1e-8
    )
    assert not bool(resolved)


def test_bristles_are_not_taken_for_static_friction():
    from gyrostat.wheel import Motion
    from gyrostat.wheel.response import _FixedBench

    bench = _FixedBench(BENT, Wheel(J, MOTOR, BENT), 0.1, 0.0)
    with pytest.raises(TypeError, match="found LuGre"):
        step_dry_friction(bench, Motion(jnp.array(0.0), ()), 1.0)


def test_ever_stiffer_bristles_become_dry_friction():
    """Twenty seconds from rest, the whole bend of the curve passed in a small part of it."""
    torque, seconds = 2e-3, 20.0

    @jax.jit
    def speed(stiffness):
        plant = BenchWheel(Wheel(J, MOTOR, LuGre(CURVE, stiffness, 2.2e-3)))
        state, resolved = plant(plant.start(), TorqueCommand(torque), 0.0, seconds)
        return state.speed, resolved

    plant = BenchWheel(Wheel(J, MOTOR, CURVE))
    dry = plant(plant.start(), TorqueCommand(torque), 0.0, seconds)[0].speed
    gaps = []
    for stiffness in 10.0 ** np.arange(-2, 15, 2):
        found, resolved = speed(stiffness)
        assert resolved
        gaps.append(abs(float(found - dry)) / float(dry))
    # a hundred times stiffer, about a tenth of the difference, down to the error of the steps
    steps = itertools.pairwise(gaps[2:])
    assert all(after < 0.2 * before + 1e-8 for before, after in steps)
    assert gaps[-1] < 1e-8


def test_the_end_of_an_interval_moves_with_its_length():
    """The derivative by the duration is the acceleration there."""
    plant = BenchWheel(Wheel(J, MOTOR, BENT))

    def after(duration):
        return plant(plant.start(), TorqueCommand(2e-3), 0.0, duration)[0]

    state, change = jax.jit(lambda duration: jax.jvp(after, (duration,), (1.0,)))(2.0)
    wanted = (2e-3 - BENT.torque(state.speed, state.bristle)) / J
    # the last step is no more exact than its tolerance
    np.testing.assert_allclose(change.speed, wanted, rtol=1e-7)


def test_a_state_that_is_no_number_is_said_at_once():
    plant = BenchWheel(Wheel(J, MOTOR, BENT))
    state = plant.start(speed=np.nan)
    assert not plant(state, TorqueCommand(1e-3), 0.0, 1.0)[1]
