"""Slews of a scenario around keep-out cones: against bodies and attitudes from other sources."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

import gyrostat as gs
from gyrostat.codegen.evaluation import evaluated
from gyrostat.control.guidance import reference_at
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.followed import taken_changes
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.runs.slew_lines import slew_lines
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft.orbit import CircularElements
from gyrostat.spacecraft.orbit.sun import sun_position
from gyrostat.spacecraft.orbit.time_scales import Epoch

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
EPOCH = Epoch.of("2026-11-22T10:00:00Z")
ORBIT = CircularElements(500e3, np.radians(97.4), np.radians(148.0))
HEAD = """
[run]
duration = "700 s"
control_period = "1 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
torque_time = "none"
[orbit]
kind = "circular"
epoch = "2026-11-22T10:00:00Z"
altitude = "500 km"
inclination = "97.4 deg"
ascending_node = "148 deg"
[[keep_out]]
name = "camera"
boresight = [0, 0, 1]
sun = "35 deg"
[[keep_out]]
name = "tracker"
boresight = [0, 2, -1]
sun = "60 deg"
earth = "20 deg"
[reference]
"""


def attitude(along, across, turned=0.0):
    """Attitude whose z axis is at two angles from the Sun, deg, as text."""
    sun = sun_position(EPOCH, np.zeros(1))[0]
    first = sun / np.linalg.norm(sun)
    second = np.cross([0.0, 0.0, 1.0], first)
    second /= np.linalg.norm(second)
    axes = np.stack([second, np.cross(first, second), first], axis=1)  # z to the Sun
    local = Rotation.from_euler("YXZ", [along, across, turned], degrees=True)
    quaternion = (Rotation.from_matrix(axes) * local).as_quat(scalar_first=True)
    return str(quaternion.tolist())


LEFT, RIGHT = attitude(-60.0, 5.0), attitude(60.0, 5.0)
SLEWS = f"""kind = "slews"
rate = "1 deg/s"
[[reference.slew]]
name = "first"
time = "0 s"
target = {LEFT}
[[reference.slew]]
name = "across"
time = "250 s"
target = {RIGHT}
keep_out = "camera"
"""
MODES = f"""kind = "sequence"
rate = "1 deg/s"
keep_out_margin = 0
[[reference.mode]]
name = "left"
kind = "fixed"
target = {LEFT}
until_time = "2 s"
[[reference.mode]]
name = "right"
kind = "fixed"
target = {RIGHT}
keep_out = "camera"
until_time = "250 s"
[[reference.mode]]
name = "down"
kind = "nadir"
along = [0, -1, 0]
keep_out = ["camera", "tracker"]
[[reference.mode]]
name = "safe"
kind = "fixed"
target = {LEFT}
keep_out = "camera"
[[reference.transition]]
to = "safe"
rate_above = "5 deg/s"
[start]
attitude = {LEFT}
"""
"""A run from the first target on; the slew starts within the samples that an export tests."""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenario")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder)

    def write(text, changes=()):
        text = HEAD + text
        for was, now in dict(changes).items():
            assert was in text
            text = text.replace(was, now, 1)
        path = folder / "scenario.toml"
        path.write_text(text)
        return path

    return write


@pytest.fixture(scope="module")
def sequence(scenario):
    """Scenario of modes, read and planned."""
    return read_scenario(scenario(MODES))


@pytest.fixture(scope="module")
def slews(scenario):
    """Scenario of a list of slews, read and planned."""
    return read_scenario(scenario(SLEWS))


@evaluated  # once for each mode: compiling takes longer
def entered(reference, mode, to, begin):
    return reference.entered(mode, to, begin)


@evaluated
def motion(reference, mode, times):
    return jax.vmap(lambda time: reference.at(mode, time))(times)


def commanded(definition, times):
    """Attitude of the nominal reference at times between the samples, and its changes."""
    setup = nominal_setup(definition)
    speed, reference = jnp.asarray(setup.start.wheel_speed), setup.reference
    mode = jax.tree.map(np.asarray, reference.start(watched=False))
    changes = taken_changes(reference, speed, 1.0, definition.count) if reference.changes.to else []
    begins = [0.0, *(each.start for each in changes), np.inf]
    rows = []
    for k, begin in enumerate(begins[:-1]):
        if k:
            mode = entered(reference, mode, np.asarray(changes[k - 1].to), np.asarray(begin))
        attitude = motion(reference, mode, times).attitude
        rows.append(attitude[(times >= begin) & (times < begins[k + 1])])
    return Rotation.from_quat(np.concatenate(rows), scalar_first=True), changes


def distances(turned, boresight, times):
    """Angles of a boresight from the Sun and from the limb of the Earth, deg."""
    place = ORBIT.trajectory(EPOCH, 800.0).states(times).position
    sight = turned.apply(boresight / np.linalg.norm(boresight))
    angles = []
    for toward in (sun_position(EPOCH, times) - place, -place):
        cosine = np.sum(sight * toward, axis=1) / np.linalg.norm(toward, axis=1)
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
    return angles[0], angles[1] - np.degrees(np.arcsin(6378137.0 / np.linalg.norm(place, axis=1)))


def nearest(turned, times, down):
    """Smallest angles of the camera and the tracker from the Sun, and of the latter from Earth."""
    sun, _ = distances(turned, np.array([0.0, 0.0, 1.0]), times)
    tracker_sun, earth = distances(turned, np.array([0.0, 2.0, -1.0]), times)
    return np.min(sun), np.min(tracker_sun[down]), np.min(earth[down])


def test_commanded_attitude_is_outside_of_all_cones_between_samples(sequence):
    """The second slew ends at a target that turns, which moves the cones by several degrees."""
    times = np.arange(0.0, 640.0, 0.125)
    turned, changes = commanded(sequence, times)
    assert [each.pair for each in changes] == [(0, 1), (1, 2)]
    assert [each.start for each in changes] == [2.0, 252.0]
    down = times >= 252.0
    around, alone = nearest(turned, times, down), []
    assert around[0] == pytest.approx(35.0, abs=0.5)
    assert np.all(np.array(around) >= [35.0, 60.0, 20.0])
    # about the eigenaxes, both slews pass through a cone: 35 and 60 deg
    for begin, end in ((2.0, 252.0), (252.0, 450.0)):
        ends = turned[np.searchsorted(times, [begin, end])]
        turn = Slerp([0.0, 1.0], ends)(np.linspace(0.0, 1.0, 200))
        alone.append(nearest(turn, np.full(200, begin), slice(None)))
    assert alone[0][0] < 35.0
    assert alone[1][1] < 60.0
    # the native engine flies what JAX computes
    run = gs.simulate(sequence, engine="native")
    flown = Rotation.from_quat(np.asarray(run["target"])[:640], scalar_first=True)
    assert np.max((turned[::8].inv() * flown).magnitude()) < 1e-9
    starts = np.array([0.0, *(each.start for each in changes)])
    modes = np.searchsorted(starts, np.asarray(run["time"]), side="right") - 1
    np.testing.assert_array_equal(np.asarray(run["mode"]), modes)
    np.testing.assert_array_equal(np.asarray(run["mode_start"]), starts[modes])
    # and with its rate: 0.19 deg at most, 0.32 deg without the rate
    assert np.max(np.asarray(run["error"])) < np.radians(0.25)


def test_slews_of_a_list_lead_around_a_cone(slews):
    times = np.arange(0.0, 600.0, 0.125)
    turned, _ = commanded(slews, times)
    sun, _ = distances(turned, np.array([0.0, 0.0, 1.0]), times)
    # a margin of 0.01 rad is the default
    assert 35.0 + np.degrees(0.01) <= np.min(sun[times >= 250.0]) < 35.7
    end = Rotation.from_quat(json.loads(RIGHT), scalar_first=True)
    assert (turned[-1].inv() * end).magnitude() < 1e-7
    (line,) = slew_lines(slews)
    assert "slew.across: the slew from first leads around the cones of camera, 16" in line


def loads(definition):
    """Rate, and torque and momentum of the wheels, by Euler's equation along a planned slew."""
    setup = nominal_setup(definition)
    planned, craft = setup.reference.modes[0], setup.plant.spacecraft
    times = np.linspace(250.0, float(planned.ends()[1]), 2000)
    motion = jax.jit(jax.vmap(lambda time: reference_at(planned, time)))(times)
    assert np.linalg.norm(setup.start.momentum) < 1e-12
    rate, change = np.asarray(motion.rate), np.asarray(motion.acceleration)
    axes = np.asarray(craft.wheels.axes)
    share, held = np.linalg.pinv(axes), np.asarray(craft.wheels.inertia * setup.start.wheel_speed)
    torque = share @ (change @ np.asarray(craft.inertia)).T
    momentum = -share @ (rate @ np.asarray(craft.inertia_locked())).T
    return craft.wheels, rate, torque, momentum + (held - share @ axes @ held)[:, None]


def test_wheels_have_the_torque_and_momentum_of_a_planned_slew(slews):
    wheels, rate, torque, momentum = loads(slews)
    assert np.max(np.abs(torque)) <= 0.8 * np.min(wheels.torque_limit) * 1.001
    assert np.max(np.abs(momentum)) <= 0.9 * np.min(wheels.momentum_limit) * 1.001
    assert np.max(np.linalg.norm(rate, axis=1)) <= np.radians(1.0) * 1.001


def test_a_slew_loses_time_to_keep_wheels_from_passing_zero(scenario):
    spun = {"[reference]\n": "[start]\nwheel_speed = [40, -40, 40, -40]\n[reference]\n"}
    crossings = []
    for text in (SLEWS, SLEWS.replace("rate =", 'crossing_time = "1000 s"\nrate =')):
        *_, momentum = loads(read_scenario(scenario(text, spun)))
        crossings.append(np.count_nonzero(np.any(momentum * momentum[:, :1] < 0.0, axis=1)))
    assert crossings[0] > 0
    assert crossings[1] == 0


def test_exported_c_follows_the_same_slew(sequence, tmp_path, tools):
    out = tmp_path / "flight"
    said = []
    gs.export(sequence, out, to="c", say=said.append)
    assert not any("keep_out" in line for line in said)
    lines = slew_lines(sequence)
    assert any("safe: the slew from down finds its way around" in line for line in lines)
    tools.build(out, "-c", "controller.c")
    tools.build(out, "controller.o", "controller_test.c", "-lm", "-o", "program")
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    for name in ("command.target[3]", "transition.bows[1][2]"):
        assert f"{name}: as in Python" in done.stdout


RING = {
    'sun = "35 deg"': 'sun = "55 deg"',
    "[0, 2, -1]": "[0, 0, -1]",
    'sun = "60 deg"\nearth = "20 deg"': 'sun = "118 deg"',
    'keep_out = "camera"': 'keep_out = ["camera", "tracker"]',
}
"""The boresight is between 55 and 62 deg from the Sun, on both sides of it."""


def dispersed(key, low, high):
    return f'[[dispersion]]\nkey = "{key}"\ndistribution = "uniform"\nlow = {low}\nhigh = {high}\n'


@pytest.mark.parametrize(
    ("text", "changes", "message"),
    [
        (SLEWS + dispersed("reference.rate", 0.01, 0.017), {}, "found reference.rate, expected no"),
        (SLEWS + dispersed("reference.slew.first.time", 0, 9), {}, "found reference.slew.first.ti"),
        (
            MODES + dispersed("reference.mode.left.until_time", 2, 9),
            {},
            "found reference.mode.left",
        ),
        (MODES, {'sun = "35 deg"': 'sun = "62 deg"'}, "right.keep_out: found the start of the"),
        (SLEWS, {'sun = "35 deg"': 'sun = "62 deg"'}, "across.keep_out: found the start of the"),
        (SLEWS, {'time = "250 s"': 'time = "30 s"'}, "across.time: found 30 s, expected the end"),
        (
            MODES,
            {'name = "left"': 'name = "left"\nkeep_out = "camera"'},
            "left.keep_out: found it in a mode to which no slew leads",
        ),
        (SLEWS, RING, "across.keep_out: found no way for the slew from first at 250 s around"),
        (SLEWS, {'keep_out = "camera"': 'keep_out = "kamera"'}, "expected one of camera, tracker"),
        (SLEWS, {'keep_out = "camera"': "keep_out = []"}, "expected one of camera, tracker"),
    ],
)
def test_a_slew_that_cannot_be_planned_is_one_line(scenario, run, text, changes, message):
    code, _, said = run("check", scenario(text, changes))
    assert code == 2
    (line,) = said.splitlines()
    assert re.search(re.escape(message), line)
