"""[orbit] of a scenario: its tables in a run, and mistakes in one line."""

import shutil
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from gyrostat.control.guidance import Guided
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.rotations import error_angle, to_body, to_inertial
from gyrostat.runs.build import build
from gyrostat.runs.designs import plan
from gyrostat.runs.plans import plans_of
from gyrostat.scenario import Scenario
from gyrostat.scenario.kinds.orbits import planned_orbit
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import _read, read_scenario
from gyrostat.spacecraft.environment import EARTH
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
HEAD = """
[run]
duration = "60 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
"""
ORBIT = """
[orbit]
kind = "circular"
epoch = "2026-11-22T10:00:00Z"
altitude = "500 km"
inclination = "97.4 deg"
"""
GRADIENT = """
[[environment.torque]]
kind = "gravity_gradient"
"""
PHASE = """
[[dispersion]]
key = "orbit.phase"
distribution = "uniform"
low = 0.0
high = "360 deg"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("orbits")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, place / name)
    return place


@pytest.fixture
def read(folder):
    def make(text):
        (folder / "scenario.toml").write_text(HEAD + text, encoding="utf-8")
        return read_scenario(folder / "scenario.toml")

    return make


def setup_of(scenario, **changes):
    values = {**scenario.values, **changes}
    return build(structure_of(scenario), values, plans_of(scenario))


@dataclass(frozen=True)
class Loop:
    """What is made of a controller for flight."""

    controller: object
    digests: object = None
    ranges: object = None


def test_an_exported_controller_has_the_splines_of_the_campaign(read, monkeypatch):
    """Their first pieces, to the last bit; tables for the nominal run alone have others."""
    scenario = read(ORBIT + GRADIENT + PHASE + '[reference]\nkind = "nadir"\n')
    exported = import_module("gyrostat.exports.scenario_controller")
    monkeypatch.setattr(exported, "flight_loop", lambda name, title, made, *_: Loop(made))
    monkeypatch.setattr(exported, "plans_of", plan)  # without the trial of the parts
    made = exported.scenario_controller(scenario, "hold").controller
    leaves = jax.tree.leaves(made, is_leaf=lambda part: isinstance(part, OrbitEnvironment))
    tables = [part.splines for part in leaves if isinstance(part, OrbitEnvironment)]
    planned = planned_orbit(scenario)
    count = len(tables[0])
    assert count < len(planned.splines)
    assert (count - 1) * planned.step >= scenario.duration
    for table in tables:
        np.testing.assert_array_equal(table, planned.splines[:count])


@pytest.mark.parametrize("key", ["phase", "inclination"])
def test_an_exported_controller_begins_at_the_phase(read, monkeypatch, key):
    """Also where each run has tables of its own, which start at the phase."""
    row = '[[dispersion]]\nkey = "orbit.{}"\ndistribution = "normal"\nsigma = "0.1 deg"\n'
    text = ORBIT + 'phase = "90 deg"\n[reference]\nkind = "nadir"\n' + row.format(key)
    scenario = read(text)
    exported = import_module("gyrostat.exports.scenario_controller")
    monkeypatch.setattr(exported, "flight_loop", lambda name, title, made, *_: Loop(made))
    made = exported.scenario_controller(scenario, "hold").controller
    leaves = jax.tree.leaves(made, is_leaf=lambda part: isinstance(part, OrbitEnvironment))
    orbits = [part for part in leaves if isinstance(part, OrbitEnvironment)]
    (expected,) = setup_of(scenario).reference.modes
    assert orbits
    for orbit in orbits:
        for time in (0.0, 50.0):
            place = expected.orbit.position(time)
            np.testing.assert_allclose(orbit.position(time), place, rtol=1e-9, atol=1.0)


def test_phase_starts_the_run_later_along_the_orbit(read):
    scenario = read(ORBIT + GRADIENT + PHASE)
    orbit = plans_of(scenario).orbit
    craft = setup_of(scenario).plant
    later = setup_of(scenario, **{"orbit.phase": np.pi}).plant
    attitude = np.array([0.8, 0.6, 0.0, 0.0])
    for plant, start in ((craft, 0.0), (later, 0.5 * float(orbit.period))):
        position = np.asarray(orbit.position(start + 7.0))
        zenith = np.asarray(to_body(attitude, position))
        inertia = np.asarray(plant.spacecraft.inertia_locked())
        pull = 3.0 * EARTH / np.linalg.norm(position) ** 5 * np.cross(zenith, inertia @ zenith)
        np.testing.assert_allclose(plant.torque(attitude, 7.0), pull, rtol=1e-9, atol=1e-18)


def test_rows_of_an_orbit_are_in_the_frame_that_the_scenario_names(read, folder):
    """EME2000 and GCRS differ by 23 mas; IERS Conventions (2010), section 5.5.4."""
    times = np.arange(-600.0, 1200.0, 30.0)
    angle = np.sqrt(EARTH / 7e6**3) * times
    along, speed = np.array([np.cos(angle), np.sin(angle)]), np.sqrt(EARTH / 7e6)
    rows = np.array(
        [times, *7e6 * along, 0.0 * times, *speed * np.array([-along[1], along[0]]), 0.0 * times]
    )
    header = "time,x,y,z,vx,vy,vz"
    np.savetxt(folder / "orbit.csv", rows.T, fmt="%.17g", delimiter=",", header=header, comments="")
    start = {}
    for frame in ("GCRS", "EME2000"):
        named = f'kind = "file"\nfile = "orbit.csv"\nframe = "{frame}"\n'
        scenario = read(f'[orbit]\n{named}epoch = "2026-11-22T10:00:00Z"\n')
        start[frame] = np.asarray(planned_orbit(scenario).position(0.0))
    np.testing.assert_allclose(start["GCRS"], [7e6, 0.0, 0.0], atol=1.0)
    # pole (-16.617, -6.8192) mas, equinox -14.6 mas
    bias = np.radians(np.array([0.0, -14.6, 16.617]) / 3.6e6)
    np.testing.assert_allclose(start["EME2000"] - start["GCRS"], 7e6 * bias, atol=1e-3)


@pytest.mark.parametrize(
    ("mode", "axis"),
    [
        ('kind = "nadir"', [0.0, 0.0, 1.0]),
        ('kind = "sun"', [1.0, 0.0, 0.0]),
        ('kind = "ground_target"\nlatitude = "48 deg"\nlongitude = "11 deg"', [0.0, 0.0, 1.0]),
    ],
)
def test_references_along_the_orbit(read, mode, axis):
    scenario = read(ORBIT + f"[reference]\n{mode}\n")
    setup = setup_of(scenario)
    orbit = plans_of(scenario).orbit
    seen = setup.reference.at(setup.reference.start(), 20.0).attitude
    pointed = np.asarray(to_inertial(seen, np.array(axis)))
    place = orbit.position(20.0)
    to = {
        "nadir": -place,
        "sun": orbit.sun(20.0) - place,
        "ground_target": orbit.ground(np.radians(48.0), np.radians(11.0), 0.0, 20.0) - place,
    }[scenario.reference]
    np.testing.assert_allclose(pointed, to / np.linalg.norm(to), atol=1e-12)
    # the body starts at rest, the reference moves: the controller has it
    assert error_angle(seen, setup.reference.at(setup.reference.start(), 21.0).attitude) > 0.0


def test_the_controller_alone_has_the_position_error(read):
    """Its reference points from the wrong place; pointing errors count from the right one."""
    mode = 'kind = "ground_target"\nlatitude = "48 deg"\nlongitude = "11 deg"\n'
    text = ORBIT + f'[reference]\n{mode}position_error = ["300 m", "-2 km", "1 km"]\n'
    spread = PHASE.replace("orbit.phase", "reference.position_error.y")
    scenario = read(text + spread.replace("360 deg", "2 km"))
    assert scenario.dispersed == ("reference.position_error.y",)
    setup = build(structure_of(scenario), scenario.values, plan(scenario))
    is_guided = {"is_leaf": lambda part: isinstance(part, Guided)}
    parts = jax.tree.leaves(setup.controller, **is_guided)
    (guided,) = [part for part in parts if isinstance(part, Guided)]
    orbit = planned_orbit(scenario)
    ground = orbit.ground(np.radians(48.0), np.radians(11.0), 0.0, 20.0)
    for reference, error in (
        (setup.reference, np.zeros(3)),
        (guided.reference, [300, -2000, 1000]),
    ):
        seen = reference.at(reference.start(), 20.0).attitude
        to = ground - (orbit.position(20.0) + np.array(error))
        pointed = to_inertial(seen, np.array([0.0, 0.0, 1.0]))
        np.testing.assert_allclose(pointed, to / np.linalg.norm(to), atol=1e-12)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (ORBIT + '[reference]\nposition_error = ["1 m", 0, 0]\n', "found \\['1 m', 0, 0\\]"),
        ('[reference]\nkind = "nadir"\naltitude = "500 km"\nposition_error = [0, 0, 0]\n', "found"),
        (ORBIT + '[reference]\nkind = "nadir"\nposition_error = "1 deg"\n', "found"),
    ],
)
def test_a_position_error_that_nothing_depends_on_is_refused(read, text, found):
    with pytest.raises(InputError, match=f"reference.position_error.*{found}"):
        read(text)


def test_the_text_gives_the_same_tables(read):
    scenario = read(ORBIT + GRADIENT)
    again = Scenario.from_text(scenario.text())
    assert again.digest() == scenario.digest()
    np.testing.assert_array_equal(
        plans_of(replace(again, name="again")).orbit.splines,
        plans_of(scenario).orbit.splines,
    )


def test_own_part_gets_the_orbit(read, folder):
    (folder / "own.py").write_text(
        """from typing import Any
import jax.numpy as jnp

class Field:
    orbit: Any
    scale: float = 1.0

    def __call__(self, spacecraft, attitude, time):
        return self.scale * self.orbit.field(time)
""",
        encoding="utf-8",
    )
    part = '[[environment.torque]]\npython = "own.py:Field"\n'
    scenario = read(ORBIT + part)
    found = setup_of(scenario).plant.torque(np.array([1.0, 0.0, 0.0, 0.0]), 3.0)
    np.testing.assert_allclose(found, plans_of(scenario).orbit.field(3.0), rtol=1e-12)
    with pytest.raises(InputError, match=r"environment.torque.field: found .* without orbit"):
        read(part)


def test_an_own_compensator_inside_the_unloading_gets_the_orbit(folder):
    (folder / "inner.py").write_text(
        """from typing import Any
import equinox as eqx

class Along(eqx.Module):
    controller: Any = None
    orbit: Any = None

    def start(self, period):
        return self.controller.start(period)

    def __call__(self, memory, measurement):
        return self.controller(memory, measurement)
""",
        encoding="utf-8",
    )
    rods = "limit = [0.1, 0.1, 0.1]\n"
    text = '[compensator]\npython = "inner.py:Along"\n[[sensor]]\nkind = "magnetometer"\n'
    text += f'[unloading]\nkind = "torque_rods"\n{rods}[[actuator]]\nkind = "torque_rods"\n{rods}'
    (folder / "scenario.toml").write_text(HEAD + ORBIT + text, encoding="utf-8")
    scenario = _read(folder / "scenario.toml", force=False)
    plans = plan(scenario)
    controller = build(structure_of(scenario), scenario.values, plans).controller
    own = controller.controller
    np.testing.assert_array_equal(own.inner.orbit.splines, plans.orbit.splines)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (GRADIENT, r"altitude: found none, expected it, or a section \[orbit\]"),
        (ORBIT + GRADIENT + 'altitude = "500 km"\n', r"beside \[orbit\], expected none"),
        (ORBIT + '[environment]\nkind = "orbit"\naltitude = 5e5\n', r"found orbit beside"),
        ('[reference]\nkind = "sun"\n', r"reference: found sun without orbit"),
        (ORBIT.replace('epoch = "2026-11-22T10:00:00Z"\n', ""), "epoch: found None"),
        (ORBIT.replace("2026-11-22T10", "today"), "epoch|UTC"),
        (ORBIT.replace('"500 km"', '"-500 km"'), "above 0"),
        (ORBIT.replace('"500 km"', '"50 km"'), "height of 50 km"),
        ('[orbit]\nkind = "tle"\nlines = "nothing"\n', "line"),
        ('[orbit]\nkind = "file"\nfile = "none.oem"\n', "none.oem"),
        ('[orbit]\nkind = "moon"\n', "expected one of none, circular"),
    ],
)
def test_mistakes(read, text, message):
    with pytest.raises(InputError, match=message) as found:
        read(text)
    assert "\n" not in str(found.value)
