"""Three wheels that point a body without friction, and torque rods: gyrostat beside Basilisk."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gyrostat.core import rotations
from gyrostat.core.jax64 import jax
from gyrostat.simulation import run
from gyrostat.spacecraft import Gyrostat, Spacecraft
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
