"""Wheels with bristles on a body against an implicit solver, conservation laws and limits."""

from functools import partial
from pathlib import Path
from unittest import mock

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import (
    AirBearingTable,
    FrictionSteps,
    Gyrostat,
    Spacecraft,
    TableCommand,
    WheelFailures,
    WheelTorqueCommand,
)
from gyrostat.spacecraft.wheel_friction import net_torque
from gyrostat.wheel import Wheel, WheelArray, step_coupled_bristles
from gyrostat.wheel.coupled_bristles import TOLERANCE
from gyrostat.wheel.friction import LuGre, Stribeck

INERTIA = np.array([[0.06, 0.004, 0.0], [0.004, 0.12, -0.003], [0.0, -0.003, 0.14]])
AXES = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [0.2, -1.0, 1.0]]).T
AXES = AXES / np.linalg.norm(AXES, axis=0)
ROTORS = np.array([2.0e-5, 1.5e-5, 2.5e-5])
VISCOUS, COULOMB, STATIC, SCALE = 1e-7, 2e-5, 3e-5, 2.0
BEND = 0.01
"""Deflection of the bristles under the Coulomb torque, rad."""
ONES, PERIOD = np.ones(3), 0.25
NEVER = np.full(3, np.inf)


def lugre(*, bend=BEND, damping=1.2e-4, viscous=VISCOUS, coulomb=COULOMB):
    curve = Stribeck(
        viscous * ONES, coulomb * ONES, STATIC / COULOMB * coulomb * ONES, SCALE * ONES
    )
    return LuGre(curve, coulomb / bend * ONES, damping * ONES)


def built(friction, *, inertia=INERTIA, external=(0.0, 0.0, 0.0), failures=None, steps=None):
    """One structure for all tests, so that it is compiled once."""
    steps = FrictionSteps(NEVER, friction) if steps is None else steps
    failures = WheelFailures.none(3) if failures is None else failures
    wheels = WheelArray(AXES, ROTORS, np.full(3, np.inf), np.full(3, np.inf), friction)
    craft = Spacecraft(np.asarray(inertia), wheels)
    return Gyrostat(craft, failures, np.asarray(external), friction_steps=steps)


@eqx.filter_jit
def _carried(plant, state, torques, times, period, tolerance):
    stepping = partial(step_coupled_bristles, tolerance=tolerance)

    def tick(state, given):
        torque, time = given
        state, resolved = plant(state, WheelTorqueCommand(torque), time, period)
        return state, (state, plant.rate(state), plant.kinetic_energy(state), resolved)

    with mock.patch("gyrostat.spacecraft.wheel_friction.step_coupled_bristles", stepping):
        return jax.lax.scan(tick, state, (torques, times))[1]


COUNT = 24


def carried(plant, state, torques, *, period=PERIOD, tolerance=TOLERANCE):
    """States, body rates and kinetic energies after each of 24 periods."""
    plant.check_state(state)
    torques = np.broadcast_to(torques, (COUNT, 3))
    numbers = (torques, period * np.arange(COUNT), period, tolerance)
    found = _carried(plant, state, *(np.asarray(x, dtype=float) for x in numbers))
    *found, resolved = jax.tree.map(np.asarray, found)
    assert np.all(resolved)
    return found


rate_of = eqx.filter_jit(lambda plant, state: plant.rate(state))


def reference(plant, state, torques, *, held=()):
    """Attitude, rate, speeds and deflections in Euler's and Newton's equations, by Radau."""
    friction = plant.spacecraft.wheels.friction
    stiffness, damping = np.asarray(friction.stiffness), np.asarray(friction.damping)
    b, c, ts, ws = (np.asarray(v) for v in friction.curve.parameters().values())
    turns = np.setdiff1d(np.arange(3), held)
    axes, rotors = AXES[:, turns], ROTORS[turns]
    inertia = INERTIA + sum(ROTORS[k] * np.outer(AXES[:, k], AXES[:, k]) for k in held)
    inverse, external = np.linalg.inv(inertia), np.asarray(plant.external_torque)
    b, c, ts, ws, s0, s1 = (v[turns] for v in (b, c, ts, ws, stiffness, damping))
    n = len(turns)

    def rate(_, y, motor):
        q, w, speed, bristle = y[:4], y[4:7], y[7 : 7 + n], y[7 + n :]
        level = c + (ts - c) * np.exp(-((speed / ws) ** 2))
        bending = speed - s0 * np.abs(speed) * bristle / level
        net = motor - (s0 * bristle + s1 * bending + b * speed)
        own = inertia @ w + axes @ (rotors * (speed + axes.T @ w))
        turn = inverse @ (external - np.cross(w, own) - axes @ net)
        spin = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([spin, turn, net / rotors - axes.T @ turn, bending])

    moving = (np.asarray(part)[turns] for part in (state.wheel_speed, state.deflection))
    y, rows = np.concatenate([state.attitude, rate_of(plant, state), *moving]), []
    for motor in torques[:, turns]:
        y = solve_ivp(rate, (0.0, PERIOD), y, "Radau", rtol=1e-10, atol=1e-13, args=(motor,)).y
        y = y[:, -1]
        y[:4] /= np.linalg.norm(y[:4])
        rows.append(y)
    return np.split(np.array(rows), [4, 7, 7 + n], axis=1)


def errors(found, expected, turns=(0, 1, 2)):
    """Largest errors of attitude, rate, speeds and deflections; the last ones over `BEND`."""
    states, rates, _ = jax.tree.map(lambda x: x[: len(expected[0])], found)
    turns = list(turns)
    ours = (states.attitude, rates, states.wheel_speed[:, turns], states.deflection[:, turns])
    errors = [np.max(np.abs(a - b)) for a, b in zip(ours, expected, strict=True)]
    return np.array([*errors[:3], errors[3] / BEND])


DRIVEN = 6e-5 * np.sin(0.9 * np.arange(COUNT)[:, None] + 1.3 * np.arange(3))
EXTERNAL = (3e-6, -3e-6, 1e-6)


def test_wheels_through_zero_follow_an_implicit_solver():
    """Breakaway, slip, reversal; errors proportional to the tolerance."""
    plant = built(lugre(), external=EXTERNAL)
    start = plant.start(rate=[3e-3, -2e-3, 1e-3], wheel_speed=[1.0, 0.0, -0.3])
    expected = reference(plant, start, DRIVEN[:8])
    assert np.sum(np.diff(np.sign(expected[2]), axis=0) != 0.0) >= 3
    tolerances = 1e-7, TOLERANCE, 1e-3
    found = [errors(carried(plant, start, DRIVEN, tolerance=t), expected) for t in tolerances]
    assert np.all(found[1] < [1e-8, 1e-8, 2e-5, 5e-5])
    assert np.all(found[0] < 0.05 * found[1])
    assert np.all(found[1] < 0.1 * found[2])


@pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
def test_lanes_agree_with_jax():
    """Three runs together, of which one slips far from zero and one starts with bent bristles."""
    plant = built(lugre(), external=EXTERNAL)
    speeds = ([1.0, 0.0, -0.3], [60.0, 80.0, -70.0], [0.2, -2.0, 15.0])
    starts = [plant.start(rate=[3e-3, -2e-3, 1e-3], wheel_speed=speed) for speed in speeds]
    starts[2] = plant.start(wheel_speed=speeds[2], deflection=0.5 * BEND)

    def flown(start):
        numbers = (DRIVEN, PERIOD * np.arange(COUNT), np.asarray(PERIOD), np.asarray(TOLERANCE))
        return _carried(plant, start, *numbers)[0]

    every = jax.tree.map(lambda *x: np.stack(x), *starts)
    found = lanes(flown, (True,), (every,))(every)
    for run, start in enumerate(starts):
        states = carried(plant, start, DRIVEN)[0]
        for name, theirs in states._asdict().items():
            if theirs is not None:
                ours = getattr(found, name)[run]
                most = 1e-10 * np.max(np.abs(theirs))
                np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=most, err_msg=name)


def test_momentum_is_conserved_and_energy_lost():
    """Undriven, with the largest damping for which the bristles are passive."""
    damping = float(np.min(lugre(viscous=2e-6, damping=0.0).largest_passive_damping()))
    friction = lugre(viscous=2e-6, damping=0.99 * damping)
    assert np.all(friction.is_passive())
    plant = built(friction)
    start = plant.start(rate=[0.03, -0.02, 0.01], wheel_speed=[2.0, -3.0, 0.5], deflection=0.0)
    states, rates, kinetic = carried(plant, start, 0.0)
    np.testing.assert_array_equal(states.momentum, np.tile(start.momentum, (COUNT, 1)))
    rotors = (ROTORS * states.wheel_speed) @ AXES.T
    locked = INERTIA + AXES @ np.diag(ROTORS) @ AXES.T
    body = rates @ locked + rotors
    size = np.linalg.norm(start.momentum)
    np.testing.assert_allclose(np.linalg.norm(body, axis=1), size, rtol=1e-13)
    energy = kinetic + np.sum(0.5 * friction.stiffness * states.deflection**2, axis=1)
    first = float(eqx.filter_jit(plant.kinetic_energy)(start))
    assert np.max(np.diff(energy, prepend=first)) < TOLERANCE * first
    assert energy[-1] < 0.5 * first


def test_on_a_huge_body_each_wheel_is_one_on_a_bench():
    plant = built(lugre(), inertia=1e9 * np.eye(3))
    start = plant.start(wheel_speed=[1.0, 0.0, -0.3])
    states, _, _ = carried(plant, start, DRIVEN)

    @jax.jit
    def bench(friction, rotor, start, torques):
        table = AirBearingTable(1e9, Wheel(rotor, 1.0, friction))

        def tick(state, torque):
            state, _ = table(state, TableCommand(torque), 0.0, PERIOD)
            return state, state

        speed, bristle = start
        state = table.start(speed=speed)._replace(bristle=bristle)
        return jax.lax.scan(tick, state, torques)[1]

    one = jax.tree.map(lambda x: np.asarray(x)[0], lugre())
    for k in range(3):
        own = (np.asarray(start.wheel_speed)[k], np.asarray(start.deflection)[k])
        alone = bench(one, ROTORS[k], own, DRIVEN[:, k])
        assert np.max(np.abs(alone.speed - states.wheel_speed[:, k])) < 2e-5
        assert np.max(np.abs(alone.bristle - states.deflection[:, k])) < 5e-5 * BEND


def test_stiff_bristles_are_dry_friction(module_at):
    """Towards the plant that sticks, in proportion to the largest deflection."""
    plain = module_at(Path(__file__).with_name("gyrostat_reference.py"))
    curve = tuple(np.asarray(v) for v in lugre().curve.parameters().values())
    dry = plain.Reference(INERTIA, AXES, ROTORS, curve)
    start = built(lugre()).start(rate=[3e-3, -2e-3, 1e-3], wheel_speed=[1.0, 0.0, -0.3])
    y = np.concatenate([start.attitude, [3e-3, -2e-3, 1e-3], start.wheel_speed])
    rows = []
    for torque in DRIVEN:
        y = dry.carry(y, torque, PERIOD)
        rows.append(y)
    speeds = np.array(rows)[:, 7:]
    assert np.sum(speeds == 0.0) >= 2
    off = []
    for bend in (1e-2, 1e-3, 1e-4):
        # a constant damping ratio
        plant = built(lugre(bend=bend, damping=1.2e-4 * np.sqrt(BEND / bend)))
        start = plant.start(rate=[3e-3, -2e-3, 1e-3], wheel_speed=[1.0, 0.0, -0.3])
        states, _, _ = carried(plant, start, DRIVEN)
        off.append(np.max(np.abs(states.wheel_speed - speeds)))
    assert off[1] < 0.5 * off[0]
    assert off[2] < 0.5 * off[1]


def test_presliding_is_a_spring_that_comes_back_and_does_not_creep():
    torque = 0.05 * COULOMB
    held, freed = np.full((COUNT, 3), torque), np.zeros((COUNT, 3))
    plant = built(lugre(), inertia=1e9 * np.eye(3))
    states, _, _ = carried(plant, plant.start(), held, period=10.0)
    bent = torque / np.asarray(plant.spacecraft.wheels.friction.stiffness)
    np.testing.assert_allclose(states.deflection[-1], bent, rtol=1e-6)
    # a wheel that crept would slip: its speed bounds the angle, here over 240 s
    assert np.max(np.abs(states.wheel_speed[4:])) < 1e-9
    last = jax.tree.map(lambda x: x[-1], states)
    states, _, _ = carried(plant, last, freed, period=10.0)
    assert np.max(np.abs(states.deflection[-1])) < 1e-3 * bent[0]


def test_a_seized_wheel_is_part_of_the_body():
    failures = WheelFailures.none(3).seizes(1, 0.0)
    plant = built(lugre(), external=EXTERNAL, failures=failures)
    start = plant.start(rate=[3e-3, -2e-3, 1e-3], wheel_speed=[1.0, 0.0, -0.3])
    found = carried(plant, start, DRIVEN)
    assert np.all(found[0].wheel_speed[:, 1] == 0.0)
    expected = reference(plant, start, DRIVEN[:4], held=(1,))
    assert np.all(errors(found, expected, turns=(0, 2)) < [1e-8, 1e-8, 2e-5, 5e-5])


def test_far_from_zero_friction_is_the_curve_and_steps_to_a_new_one():
    """Exactly: the momentum of a wheel that slips, before and after a step of the friction."""
    after = 3.0 * COULOMB
    steps = FrictionSteps(np.array([np.inf, 3.0, np.inf]), lugre(coulomb=after))
    plant = built(lugre(viscous=0.0), inertia=1e9 * np.eye(3), steps=steps)
    steps = eqx.tree_at(lambda s: s.friction.curve.viscous, steps, np.zeros(3))
    plant = eqx.tree_at(lambda p: p.friction_steps, plant, steps)
    states, _, _ = carried(plant, plant.start(wheel_speed=100.0), 0.0)
    lost = -np.diff(ROTORS * np.asarray(states.wheel_speed), axis=0) / PERIOD
    np.testing.assert_allclose(lost[:11], COULOMB, rtol=1e-9)
    np.testing.assert_allclose(lost[12:, 1], after, rtol=1e-9)
    np.testing.assert_allclose(lost[12:, 2], COULOMB, rtol=1e-9)


def test_in_steady_slip_the_net_torque_is_that_of_the_curve():
    state = built(lugre()).start(wheel_speed=[5.0, -1.0, 0.3])
    curve = net_torque(lugre().curve, DRIVEN[1], state)
    np.testing.assert_allclose(net_torque(lugre(), DRIVEN[1], state), curve, rtol=1e-12)
    assert np.all(np.abs(curve - DRIVEN[1]) > 0.9 * COULOMB)


def test_deflections_that_do_not_fit_are_refused():
    plant = built(lugre())
    state = plant.start()
    with pytest.raises(InputError, match="deflection: found none"):
        plant.check_state(state._replace(deflection=None))
    with pytest.raises(InputError, match=r"deflection: found shape \(2,\)"):
        plant.check_state(state._replace(deflection=jnp.zeros(2)))
    dry = Gyrostat(Spacecraft(INERTIA, WheelArray(AXES, ROTORS)))
    with pytest.raises(InputError, match="expected none with viscous-coulomb friction"):
        dry.start(deflection=0.1)
