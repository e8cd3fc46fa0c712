"""Gyrostat beside Basilisk: wheels that point a body, torque rods, a panel and slosh."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import run
from gyrostat.spacecraft import (
    FlexibleModes,
    Gyrostat,
    Spacecraft,
    WheelTorqueCommand,
    hinged_panel,
    spring_mass,
)
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods
from gyrostat.wheel import WheelArray, orthogonal_axes

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
COUNT, EVERY = 3000, 500


@pytest.fixture(scope="module")
def peer(module_at):
    """Basilisk, as the benchmark asks it."""
    pytest.importorskip("Basilisk", reason="found no Basilisk (bsk), of the extra peers")
    if not BENCHMARKS.is_dir():
        pytest.skip("found no benchmarks, expected those of the repository")
    return module_at(BENCHMARKS / "basilisk_peer.py")


@pytest.fixture(scope="module")
def case(module_at, peer):
    """The case of the benchmark, friction off, and Basilisk's trajectory of it."""
    case = module_at(BENCHMARKS / "pointing_case.py")
    drawn = case.Drawn(*(x[0] for x in case.draw(1)))._replace(friction=np.zeros(3))
    period = case.PERIOD
    given = {name: value.tolist() for name, value in drawn._asdict().items()}
    return case, drawn, peer.three_wheels(given, case.CRAFT, period, COUNT * period, EVERY * period)


def test_trajectories_without_friction_are_those_of_basilisk(case):
    case, drawn, theirs = case
    histories = run(*case.parts(drawn), jax.random.key(0), case.PERIOD, count=COUNT)
    rows = slice(None, None, EVERY)
    mrp = jax.vmap(rotations.to_mrp)(histories.state.attitude[rows])
    np.testing.assert_allclose(mrp, theirs["mrp"], rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(histories.record.rate[rows], theirs["rate"], rtol=0.0, atol=1e-13)
    speed = histories.state.wheel_speed[rows]
    assert np.ptp(speed) > 10.0
    np.testing.assert_allclose(speed, theirs["wheel_speed"], rtol=0.0, atol=1e-9)


def test_the_motion_under_torque_rods_is_that_of_basilisk(peer, frictionless):
    """Four rods, two of them limited, in a field that is constant in space, from rest."""
    inertia, field = np.diag([0.12, 0.10, 0.06]), np.array([2e-5, -1e-5, 3e-5])
    axes = np.array([[1.0, 0.0, 0.0, 0.6], [0.0, 1.0, 0.0, 0.8], [0.0, 0.0, 1.0, 0.0]])
    limit, dipole = [0.3, 0.2, 0.3, 0.1], np.array([0.1, -0.3, 0.25, 0.2])
    asked = {"axes": axes, "limit": limit, "field": field.tolist()}
    asked |= {"step": 0.5, "duration": 300.0, "every": 50.0}
    theirs = peer.torque_rods({"inertia": inertia, "dipole": dipole.tolist()}, **asked)
    wheels = WheelArray(orthogonal_axes(), np.full(3, 1e-30))
    rods = TorqueRods(SimpleNamespace(field=lambda time: field), np.array(limit), axes)
    plant = Gyrostat(Spacecraft(inertia, wheels), actuators={"rods": rods})
    command = SimpleNamespace(torque=np.zeros(3), rods=dipole)
    step = jax.jit(lambda state: frictionless(plant)(state, command, 0.0, 0.5)[0])
    state = plant.start()
    for k in range(600):
        state = step(state)
        if (k + 1) % 100 == 0:
            mrp, rate = theirs["mrp"][(k + 1) // 100], theirs["rate"][(k + 1) // 100]
            np.testing.assert_allclose(rotations.to_mrp(state.attitude), mrp, rtol=0.0, atol=1e-10)
            np.testing.assert_allclose(plant.rate(state), rate, rtol=1e-6, atol=1e-12)
    assert np.linalg.norm(mrp) > 0.05


CRAFT = {
    "hub_mass": 600.0,
    "hub_centre": [0.05, -0.03, 0.1],
    "hub_inertia": np.array([[700.0, 20.0, -10.0], [20.0, 550.0, 15.0], [-10.0, 15.0, 500.0]]),
    "panel_mass": 60.0,
    "panel_inertia": np.diag([50.0, 20.0, 65.0]),
    "hinge": [-1.1, 0.2, 0.3],
    "arm": 1.4,
    "panel_stiffness": 250.0,
    "panel_drag": 8.0,
    "slosh_mass": 40.0,
    "tank": [0.3, 0.8, -0.4],
    "line": [0.6, 0.0, 0.8],
    "slosh_stiffness": 80.0,
    "slosh_drag": 3.0,
    "rotor": 0.3,
}


def of_spring(stiffness, drag, inertia):
    """Frequency and damping ratio."""
    frequency = np.sqrt(stiffness / inertia)
    return {"frequency": frequency, "damping": drag / (2.0 * frequency * inertia)}


def about(arm, mass):
    """Inertia of a point."""
    return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def flexible():
    """Plant with the panel and the slosh mass of `CRAFT`, and roots of their modal masses."""
    c = {name: np.asarray(value, dtype=float) for name, value in CRAFT.items()}
    arm = np.array([-c["arm"], 0.0, 0.0])
    parts = [
        (c["hub_mass"], c["hub_centre"], c["hub_inertia"]),
        (c["panel_mass"], c["hinge"] + arm, c["panel_inertia"]),
        (c["slosh_mass"], c["tank"], np.zeros((3, 3))),
    ]
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * r for m, r, _ in parts) / mass
    inertia = sum(own + about(r - centre, m) for m, r, own in parts)
    swung = c["panel_inertia"] + about(arm, c["panel_mass"])
    panel = hinged_panel(
        *(c["panel_mass"], c["panel_inertia"], c["hinge"] - centre),
        *(c["hinge"] + arm - centre, [0.0, 1.0, 0.0]),
        **of_spring(c["panel_stiffness"], c["panel_drag"], swung[1, 1]),
        spacecraft_mass=mass,
    )
    tank = spring_mass(
        *(c["slosh_mass"], c["tank"] - centre, c["line"]),
        **of_spring(c["slosh_stiffness"], c["slosh_drag"], c["slosh_mass"]),
        spacecraft_mass=mass,
    )
    axis = np.array([[0.0], [0.0], [1.0]])
    wheels = WheelArray(axis, np.array([c["rotor"]]))
    body = Spacecraft(inertia - c["rotor"] * axis @ axis.T, wheels)
    plant = Gyrostat(body, modes=FlexibleModes.joined(panel, tank))
    plant.check()
    return plant, np.sqrt([swung[1, 1], c["slosh_mass"]])


def test_a_panel_and_slosh_approach_those_of_basilisk_with_the_square_of_their_motion(module_at):
    """Basilisk's bodies move far; the modes are of first order. Both are moved by a wheel."""
    pytest.importorskip("Basilisk", reason="found no Basilisk (bsk), of the extra peers")
    if not BENCHMARKS.is_dir():
        pytest.skip("found no benchmarks, expected those of the repository")
    peer, step, count = module_at(BENCHMARKS / "basilisk_flexible.py"), 0.01, 2000
    plant, roots = flexible()

    @jax.jit
    def fly(state, torque):
        def go(state, _):
            seen = rotations.to_mrp(state.attitude), plant.rate(state)
            after, _ = plant(state, WheelTorqueCommand(torque), 0.0, step)
            return after, (*seen, state.modal_coordinate[0] / roots[0])

        return jax.lax.scan(go, state, None, length=count + 1)[1]

    errors = []
    for share in (1.0, 0.1, 0.01):
        start = {
            "rate": share * np.array([0.02, -0.03, 0.01]),
            "angle": 0.13 * share,
            "shift": 0.05 * share,
            "torque": -0.5 * share,
        }
        theirs = peer.with_panel_and_slosh(CRAFT, start, step, count * step)
        moved = roots * np.array([start["angle"], start["shift"]])
        state = plant.start(rate=start["rate"], modal_coordinate=moved)
        ours = fly(state, jnp.array([start["torque"]]))
        pairs = zip(ours, (theirs[name] for name in ("mrp", "rate", "angle")), strict=True)
        errors.append([np.max(np.abs(own - other)) for own, other in pairs])
    assert np.all(np.array(errors[2]) < [4e-7, 2e-7, 6e-8])
    np.testing.assert_allclose(np.divide(errors[1], errors[2]), 100.0, rtol=0.02)
    np.testing.assert_allclose(np.divide(errors[0], errors[1]), 100.0, rtol=0.2)
