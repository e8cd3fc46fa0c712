"""Flexible modes on a body with wheels, against Lagrange's equations and closed solutions."""

import dataclasses
import importlib.util
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.spatial.transform import Rotation

from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import simulate
from gyrostat.spacecraft import (
    ChangingPlant,
    DrivenGyrostat,
    FlexibleModes,
    Gyrostat,
    Imbalance,
    ImbalancedGyrostat,
    PlantChange,
    Spacecraft,
    SpacecraftSensor,
    WheelFailures,
    WheelTorqueCommand,
    hinged_panel,
    spring_mass,
)
from gyrostat.wheel import Driver, WheelArray
from gyrostat.wheel.friction import Stribeck

INERTIA = np.array([[10.0, 0.5, 0.2], [0.5, 12.0, -0.3], [0.2, -0.3, 15.0]])
PYRAMID = np.array([[1.0, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1]]).T / np.sqrt(3.0)
ROTORS = np.array([0.010, 0.012, 0.009, 0.011])
DRY = (np.full(4, 2e-5), np.full(4, 1e-3), np.full(4, 1.3e-3), np.full(4, 0.4))
VISCOUS = (np.full(4, 2e-4), np.zeros(4), np.zeros(4), np.full(4, 1e9))
SMOOTH = (np.zeros(4), np.zeros(4), np.zeros(4), np.full(4, 1e9))
EXTERNAL = np.array([1e-3, 2e-3, -1e-3])
MODES = FlexibleModes(
    frequency=np.array([2.0, 5.0]),
    damping=np.array([0.005, 0.01]),
    participation=np.array([[1.5, 0.2, 0.1], [-0.3, 1.8, 0.7]]),
    translation=np.array([[0.1, 0.3, 0.0], [0.0, 0.2, 0.3]]),
)
FREE = WheelFailures.none(4)


def built(curve=DRY, modes=MODES, external=(0.0, 0.0, 0.0), failures=FREE, inertia=INERTIA):
    """Always two modes and one structure, so that it is compiled once."""
    wheels = WheelArray(PYRAMID, ROTORS, np.full(4, np.inf), np.full(4, np.inf), Stribeck(*curve))
    return Gyrostat(
        Spacecraft(np.asarray(inertia), wheels), failures, np.asarray(external), modes=modes
    )


@eqx.filter_jit
def _steps(plant, state, torque, duration, count):
    def step(_, carried):
        state, fine = carried
        state, resolved = plant(state, WheelTorqueCommand(torque), 0.0, duration)
        return state, fine & resolved

    return jax.lax.fori_loop(0, count, step, (state, jnp.array(True)))


def flown(plant, state, torque, duration, count=1):
    """State after some equal steps; the numbers as arrays, so that it is compiled once."""
    numbers = (np.asarray(torque, dtype=float), np.asarray(duration), np.asarray(count))
    state, resolved = _steps(plant, state, *numbers)
    assert resolved
    return state


def matrices(modes):
    """Participation, and matrices of mass, damping and stiffness."""
    mass = np.eye(modes.count) - modes.translation @ modes.translation.T
    frequency = modes.frequency
    drag = np.diag(2.0 * modes.damping * frequency)
    return modes.participation, mass, drag, np.diag(frequency**2)


@eqx.filter_jit
def plainly(plant, state):
    """State of the reference: attitude, rates, wheel speeds, modal coordinates and rates."""
    rates = plant.record(state, WheelTorqueCommand(jnp.zeros(4))).modal_rate
    parts = (state.attitude, plant.rate(state), state.wheel_speed, state.modal_coordinate, rates)
    return jnp.concatenate(parts)


@eqx.filter_jit
def energy(plant, state):
    """Kinetic energy and that of the springs."""
    return plant.kinetic_energy(state) + plant.modes.strain_energy(state.modal_coordinate)


rate_of = eqx.filter_jit(lambda plant, state: plant.rate(state))


@pytest.fixture(scope="module")
def reference():
    path = Path(__file__).with_name("gyrostat_reference.py")
    spec = importlib.util.spec_from_file_location("gyrostat_reference", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return lambda curve, external=(0.0, 0.0, 0.0): module.Reference(
        INERTIA, PYRAMID, ROTORS, curve, external, matrices(MODES)
    )


def test_lagrange_equations_are_followed_with_fourth_order(reference):
    """20 s with turning wheels, viscous friction, an external torque and two coupled modes."""
    craft, torque = built(VISCOUS, external=EXTERNAL), np.array([1e-3, -2e-3, 3e-3, 0.0])
    start = craft.start(
        rate=[0.02, -0.03, 0.01],
        wheel_speed=[50.0, 60.0, -55.0, 43.0],
        modal_coordinate=[0.1, -0.05],
        modal_rate=[0.0, 0.2],
    )
    plain, sense = reference(VISCOUS, EXTERNAL), np.array([1.0, 1.0, -1.0, 1.0])
    wanted = solve_ivp(
        plain.rate,
        (0.0, 20.0),
        plainly(craft, start),
        args=(sense, torque),
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
    ).y[:, -1]
    coarse, fine, longest = (
        np.abs(plainly(craft, flown(craft, start, torque, 20.0 / n, n)) - wanted)
        for n in (4_000, 8_000, 40)
    )
    assert np.max(fine) < 4e-9
    assert 15.0 < np.max(coarse[:7]) / np.max(fine[:7]) < 17.0
    assert 15.0 < np.max(coarse[-4:]) / np.max(fine[-4:]) < 17.0
    # steps of 0.5 s are cut into segments of 0.1 rad of the fastest mode
    assert np.max(longest[-4:]) < 1e-5


def test_wheels_that_stick_and_cross_follow_the_event_located_reference(reference):
    """10 s with crossings, rests and breakaways of wheels on a body that vibrates."""
    craft, plain = built(), reference(DRY)
    start = craft.start(
        rate=[0.02, -0.03, 0.01],
        wheel_speed=[0.3, -0.5, 0.0, 1.0],
        modal_coordinate=[0.05, -0.02],
    )
    torques = 3e-3 * np.sin(0.3 * np.arange(20)[:, None] + 1.3 * np.arange(4))
    wanted = [np.asarray(plainly(craft, start))]
    for torque in torques:
        wanted.append(plain.carry(wanted[-1], torque, 0.5))
    wanted, errors = np.array(wanted[1:]), []
    for substeps in (50, 200):
        state, states = start, []
        for torque in torques:
            state = flown(craft, state, torque, 0.5 / substeps, substeps)
            states.append(plainly(craft, state))
        speeds = np.array(states)[:, 7:11]
        np.testing.assert_array_equal(speeds == 0.0, wanted[:, 7:11] == 0.0)
        errors.append(np.abs(states - wanted))
    for part, most in ((slice(0, 7), 1e-9), (slice(7, 11), 1e-9), (slice(11, None), 3e-9)):
        coarse, fine = (np.max(error[:, part]) for error in errors)
        assert fine < most
        assert fine < coarse / 200.0
    assert np.sum(speeds == 0.0) >= 4
    assert np.sum(np.diff(np.sign(speeds), axis=0) != 0.0) >= 5


def test_total_momentum_stays_to_the_last_bit_while_wheels_stick():
    craft = built()
    start = craft.start(
        rate=[0.02, -0.03, 0.01], wheel_speed=[3.0, -5.0, 0.0, 2.0], modal_coordinate=[0.1, -0.1]
    )
    after = flown(craft, start, np.zeros(4), 0.5, 100)
    np.testing.assert_array_equal(after.momentum, start.momentum)
    assert np.any(np.asarray(after.wheel_speed) == 0.0)
    y = np.asarray(plainly(craft, after))
    locked = INERTIA + PYRAMID @ np.diag(ROTORS) @ PYRAMID.T
    body = locked @ y[4:7] + PYRAMID @ (ROTORS * y[7:11]) + MODES.participation.T @ y[13:]
    in_space = Rotation.from_quat(y[:4], scalar_first=True).apply(body)
    np.testing.assert_allclose(in_space, start.momentum, rtol=0.0, atol=1e-13)


def test_energy_is_conserved_without_friction_damping_and_torque():
    undamped = dataclasses.replace(MODES, damping=np.zeros(2))
    craft = built(SMOOTH, undamped)
    start = craft.start(
        rate=[0.1, -0.2, 0.05], wheel_speed=[30.0, -50.0, 10.0, 20.0], modal_coordinate=[0.3, -0.2]
    )

    first = float(energy(craft, start))
    errors = [
        abs(float(energy(craft, flown(craft, start, np.zeros(4), 20.0 / n, n))) - first)
        for n in (2000, 4000)
    ]
    assert errors[1] < 2e-9 * first
    # the amplitude of a mode loses with the fifth power of the step
    assert 30.0 < errors[0] / errors[1] < 34.0


def test_energy_falls_by_what_bearings_and_dampers_take(reference):
    craft, plain, sense = built(), reference(DRY), np.array([1.0, -1.0, 1.0, 1.0])
    start = craft.start(
        rate=[0.01, 0.02, -0.01], wheel_speed=[8.0, -9.0, 7.0, 6.0], modal_coordinate=[0.1, 0.05]
    )
    torque = np.array([1e-3, -2e-3, 1e-3, 5e-4])
    drag = 2.0 * MODES.damping * MODES.frequency

    def rate(t, y):
        given = torque - plain.sliding(y[7:11], sense)
        return np.append(
            plain.rate(t, y[:15], sense, torque), given @ y[7:11] - drag @ y[13:15] ** 2
        )

    y = np.append(plainly(craft, start), 0.0)
    work = solve_ivp(rate, (0.0, 5.0), y, method="DOP853", rtol=1e-12, atol=1e-13).y[-1, -1]
    after = flown(craft, start, torque, 0.0025, 2000)
    first, last = (energy(craft, state) for state in (start, after))
    np.testing.assert_allclose(last - first, work, rtol=1e-8)


def test_a_free_body_raises_frequency_and_damping_ratio():
    """On a free body of inertia J a mode has omega and zeta over sqrt(1 - delta² / J)."""
    inertia, delta, frequency, damping = 4.0, 1.2, 3.0, 0.01
    craft = built(
        SMOOTH,
        FlexibleModes(
            np.array([frequency, 7.0]),
            np.array([damping, 0.0]),
            np.array([[0.0, 0.0, delta], [0.0, 0.0, 0.0]]),
            np.zeros((2, 3)),
        ),
        inertia=inertia * np.eye(3),
    )
    start = craft.start(modal_coordinate=[0.1, 0.0])
    after = flown(craft, start, np.zeros(4), 0.004, 5000)
    mass = 1.0 - delta**2 / inertia
    free, ratio = frequency / np.sqrt(mass), damping / np.sqrt(mass)
    turned = free * np.sqrt(1.0 - ratio**2)
    phase = 20.0 * turned
    decayed = 0.1 * np.exp(-ratio * free * 20.0)
    wanted = decayed * (np.cos(phase) + ratio * free / turned * np.sin(phase))
    np.testing.assert_allclose(after.modal_coordinate, [wanted, 0.0], rtol=0.0, atol=2e-9)
    # the momentum is zero: the body turns against the mode
    turn = 2.0 * np.arcsin(float(after.attitude[3]))
    np.testing.assert_allclose(turn, delta / inertia * (0.1 - wanted), rtol=0.0, atol=2e-9)


def test_a_seized_wheel_jerks_the_body_without_its_modes():
    failing = dataclasses.replace(built(), failures=FREE.seizes(2, 0.0))
    start = failing.start(wheel_speed=[0.0, 0.0, 100.0, 0.0])
    after = flown(failing, start, np.zeros(4), 1e-6)
    left = np.asarray(INERTIA - MODES.coupling().inertia)
    axis, rotor = PYRAMID[:, 2], ROTORS[2]
    others = np.delete(np.arange(4), 2)
    # the others rest in their bearings, and turn with the body
    left = left + (PYRAMID[:, others] * ROTORS[others]) @ PYRAMID[:, others].T
    response = np.linalg.solve(left, axis)
    impulse = 100.0 / (1.0 / rotor + axis @ response)
    np.testing.assert_allclose(rate_of(failing, after), impulse * response, rtol=1e-5)
    np.testing.assert_allclose(after.modal_coordinate, 0.0, atol=1e-6)


# --- geometry


def about(arm, mass):
    """Inertia of a point."""
    return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def cloud(panel, hub, line):
    """Mass matrix of a hub of points with points that move in directions `line`, about the centre.

    Coordinates: position (3), rotation (3) and the deflection.
    """
    mass = np.zeros((7, 7))
    total = sum(m for m, _ in panel) + sum(m for m, _ in hub)
    centre = sum(m * np.asarray(r) for m, r in [*panel, *hub]) / total
    for points, moves in ((hub, False), (panel, True)):
        for m, r in points:
            r = np.asarray(r) - centre
            jacobian = np.zeros((3, 7))
            jacobian[:, :3] = np.eye(3)
            jacobian[:, 3:6] = np.cross(np.eye(3), r).T
            if moves:
                jacobian[:, 6] = line(r + centre)
            mass += m * jacobian.T @ jacobian
    return mass, centre, total


RANDOM = np.random.default_rng(8)
HUB = [(m, r) for m, r in zip(RANDOM.uniform(2.0, 9.0, 7), RANDOM.normal(size=(7, 3)), strict=True)]
PANEL = [
    (m, r + np.array([2.0, 0.3, 0.1]))
    for m, r in zip(RANDOM.uniform(0.2, 0.8, 5), RANDOM.normal(size=(5, 3)), strict=True)
]


def on_free_body(modes, inertia):
    """Squared frequencies of the modes on a free body without wheels."""
    participation, mass, _, stiffness = matrices(modes)
    return eigh(stiffness, mass - participation @ np.linalg.solve(inertia, participation.T))[0]


def test_a_hinged_panel_is_that_of_its_points():
    axis, hinge, frequency = np.array([0.6, 0.0, 0.8]), np.array([1.2, 0.1, -0.2]), 1.7
    mass, centre, total = cloud(PANEL, HUB, lambda r: np.cross(axis, r - hinge))
    weights = np.array([m for m, _ in PANEL])
    middle = weights @ np.array([r for _, r in PANEL]) / np.sum(weights)
    inertia = sum(about(r - middle, m) for m, r in PANEL)
    modes = hinged_panel(
        np.sum(weights),
        inertia,
        hinge - centre,
        middle - centre,
        2.0 * axis,
        frequency=frequency,
        damping=0.01,
        spacecraft_mass=total,
    )
    modes.check()
    stiffness = np.zeros((7, 7))
    swung = sum(about(r - hinge, m) for m, r in PANEL)
    stiffness[6, 6] = frequency**2 * axis @ swung @ axis
    wanted = eigh(stiffness, mass)[0][-1]
    found = on_free_body(jax.tree.map(np.asarray, modes), mass[3:6, 3:6])
    np.testing.assert_allclose(found, [wanted], rtol=1e-12)
    assert wanted > 1.1 * frequency**2


def test_slosh_masses_are_their_points_also_two_together():
    frequencies, lines = (1.7, 2.3), np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0]])
    first, second = PANEL[:2]
    total = sum(m for m, _ in [*HUB, first, second])
    centre = sum(m * np.asarray(r) for m, r in [*HUB, first, second]) / total
    modes = FlexibleModes.joined(
        *(
            spring_mass(m, r - centre, line, frequency=w, damping=0.01, spacecraft_mass=total)
            for (m, r), line, w in zip((first, second), 3.0 * lines, frequencies, strict=True)
        )
    )
    mass = np.zeros((8, 8))
    for m, r in [*HUB, first, second]:
        jacobian = np.zeros((3, 8))
        jacobian[:, :3], jacobian[:, 3:6] = np.eye(3), np.cross(np.eye(3), r - centre).T
        for k, point in enumerate((first, second)):
            if r is point[1]:
                jacobian[:, 6 + k] = lines[k]
        mass += m * jacobian.T @ jacobian
    stiffness = np.zeros((8, 8))
    stiffness[6, 6], stiffness[7, 7] = (
        m * w**2 for (m, _), w in zip((first, second), frequencies, strict=True)
    )
    wanted = eigh(stiffness, mass)[0][-2:]
    found = on_free_body(jax.tree.map(np.asarray, modes), mass[3:6, 3:6])
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


# --- wrappers, engines, refusals


class Sines(eqx.Module):
    """Motor torques, sines of different phase, N·m."""

    def start(self, period):
        return jnp.zeros(())

    def __call__(self, memory, measurement):
        return memory + 1.0, WheelTorqueCommand(3e-3 * jnp.sin(0.3 * memory + 1.3 * jnp.arange(2)))


@pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
def test_both_engines_agree_while_wheels_stick_on_a_body_that_vibrates():
    wheels = WheelArray(np.eye(3)[:, :2], 0.01, friction=Stribeck(2e-5, 4e-3, 5e-3, 0.4))
    one = FlexibleModes([3.0], [0.005], [[1.5, 0.2, 0.1]])
    plant = Gyrostat(Spacecraft(INERTIA, wheels), modes=one)
    start = plant.start(rate=[0.02, -0.03, 0.01], wheel_speed=[0.3, 0.0], modal_coordinate=0.05)
    ours, theirs = (
        simulate(
            *(plant, Sines(), SpacecraftSensor(plant)),
            start=start,
            duration=10.0,
            control_period=0.2,
            engine=engine,
        )
        for engine in ("native", "jax")
    )
    assert int(ours.status) == 0
    assert np.any(ours.wheel_speed[1:] == 0.0)
    assert np.any(ours.wheel_speed[1:] != 0.0)
    for name in ("attitude", "rate", "wheel_speed", "modal_coordinate", "modal_rate"):
        scale = float(np.max(np.abs(theirs[name])))
        np.testing.assert_allclose(ours[name], theirs[name], rtol=0.0, atol=1e-10 * scale)
    assert ours.modal_coordinate.dims == ("time", "modal")
    assert ours.modal_coordinate.attrs == {"long_name": "modal coordinate", "units": "√kg·m"}
    assert ours.modal_rate.attrs["units"] == "√kg·m/s"


def wider(plant):
    """A deployment: the participation of the modes grows."""
    return eqx.tree_at(
        lambda p: p.gyrostat.gyrostat.modes.participation, plant, replace_fn=lambda d: 1.2 * d
    )


def test_wrappers_keep_the_modes():
    """Balanced wheels and ideal motors under every wrapper fly as without it."""
    inner = dataclasses.replace(built(VISCOUS), failures=None)
    inner = dataclasses.replace(inner, spacecraft=dataclasses.replace(inner.spacecraft, mass=50.0))
    none = Imbalance(np.zeros(4), np.zeros(4), np.zeros((3, 4)))
    driven = DrivenGyrostat(ImbalancedGyrostat(inner, none), Driver(), 0.05)
    motion = {"rate": [0.02, -0.03, 0.01], "wheel_speed": 20.0, "modal_coordinate": [0.05, -0.02]}
    torque = np.array([1e-3, -2e-3, 3e-3, 0.0])
    started = eqx.filter_jit(lambda plant: plant.start(**motion))
    begun = started(driven)
    state, resolved = eqx.filter_jit(driven)(begun, WheelTorqueCommand(torque), 0.0, 0.01)
    assert resolved
    after = flown(built(VISCOUS), started(inner), torque, 0.01)
    for name in ("attitude", "momentum", "wheel_speed", "modal_coordinate", "modal_momentum"):
        np.testing.assert_allclose(getattr(state, name), getattr(after, name), rtol=1e-12)
    plant = ChangingPlant(driven, (PlantChange("deployed", 0.5, wider),))
    plant.check()
    start = started(plant)
    plant.check_state(start)
    later = start._replace(elapsed=np.array(1.0))
    # the momenta of the modes stay, the body rate steps
    rate = np.asarray(rate_of(plant, later))
    np.testing.assert_array_equal(rate, rate_of(wider(driven), begun))
    assert np.max(np.abs(rate - rate_of(plant, start))) > 1e-3


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"participation": 3.0 * MODES.participation}, "as least inertia of the body"),
        ({"translation": 3.0 * MODES.translation}, "of the mass of the spacecraft"),
        ({"frequency": np.array([2.0, 0.0])}, "mode frequency: found 0, expected"),
        ({"damping": np.array([0.1, -0.1])}, "mode damping: found -0.1"),
        ({"damping": np.zeros(3)}, r"mode damping: found shape \(3,\), expected \(2,\)"),
        ({"participation": np.zeros((2, 2))}, r"mode participation: found shape \(2, 2\)"),
        ({"participation": np.full((2, 3), np.nan)}, "participation of a mode: found nan"),
    ],
)
def test_modes_that_cannot_be(change, found):
    with pytest.raises(InputError, match=found):
        built(modes=dataclasses.replace(MODES, **change)).check()


def test_a_start_without_its_modes_is_refused():
    craft = built()
    start = craft.start()
    with pytest.raises(InputError, match="modal_momentum: found none, expected that of 2 modes"):
        craft.check_state(start._replace(modal_momentum=None))
    with pytest.raises(InputError, match=r"modal_coordinate: found shape \(3,\), expected \(2,\)"):
        craft.check_state(start._replace(modal_coordinate=np.zeros(3)))
    with pytest.raises(InputError, match="modal_coordinate: found"):
        built(modes=None).start(modal_coordinate=0.1)
