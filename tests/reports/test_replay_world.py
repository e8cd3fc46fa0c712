"""Earth, Sun, velocity and ground target in the page of a run along an orbit."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.image import imread
from scipy.ndimage import minimum_filter
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import GroundTarget, Pointing, to_earth, to_sun
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.reports import campaign_run
from gyrostat.reports.replay import replay_data
from gyrostat.scenario.kinds.orbits import orbit_of, planned_orbit
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """
[run]
duration = "60 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
kind = "three_axis"
[orbit]
kind = "circular"
epoch = "2026-06-21T10:12:00Z"
altitude = "500 km"
inclination = "97.4 deg"
ascending_node = "112 deg"
phase = "21 deg"
[reference]
kind = "sequence"
rate = "1 deg/s"
acceleration = 0.001
mode = [
  { name = "sun", kind = "sun", until_time = "20 s" },
  { name = "down", kind = "nadir", until_time = "20 s" },
  { name = "aim", kind = "ground_target", latitude = "24.7 deg", longitude = "46.7 deg" },
]
[metrics]
boresight = [0.0, 0.0, 1.0]
field_of_view = "12 deg"
"""
COUNT, AIM = 241, 200
"""Number of samples, and one at which the ground target is tracked."""
SUN, GROUND = np.array([[217, 154, 0], [160, 36, 143]]) / 255.0


def axis_of(attitude, axis):
    """Inertial directions of a body axis, (rows, 3)."""
    return Rotation.from_quat(attitude, scalar_first=True).apply(axis)


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    folder = tmp_path_factory.mktemp("world")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder / name)

    def made(text):
        (folder / "scenario.toml").write_text(text, encoding="utf-8")
        return read_scenario(folder / "scenario.toml")

    return made


@pytest.fixture(scope="module")
def shown(read):
    """Scenario, orbit, values of the run and histories of a body that follows each mode exactly."""
    scenario = read(SCENARIO)
    orbit = orbit_of(scenario, scenario.values, planned_orbit(scenario))
    time, mode = 0.25 * np.arange(COUNT), np.repeat([0.0, 1.0, 2.0], [80, 80, 81])
    axes = {"axis": [0.0, 0.0, 1.0], "second": [1.0, 0.0, 0.0]}
    profiles = [
        Pointing.of(orbit, to_sun, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        Pointing.of(orbit, to_earth, **axes),
        Pointing.of(orbit, GroundTarget(np.radians(24.7), np.radians(46.7)), **axes),
    ]
    every = np.array([jax.jit(jax.vmap(profile))(time) for profile in profiles])
    attitude = every[mode.astype(int), np.arange(COUNT)]
    history = xr.Dataset(
        {
            "attitude": (("time", "quaternion"), attitude),
            "target": (("time", "quaternion"), attitude),
            "mode": ("time", mode),
            "error": ("time", np.full(COUNT, 1e-3)),
            "rate": (("time", "axis"), np.full((COUNT, 3), 1e-3)),
            "wheel_speed": (("time", "wheel"), np.full((COUNT, 4), 100.0)),
            "torque": (("time", "wheel"), np.zeros((COUNT, 4))),
        },
        coords={"time": time},
    )
    return scenario, orbit, {"status": 0, "ended": 60.0}, history


def test_directions_are_those_that_the_modes_point_at(shown):
    scenario, orbit, values, history = shown
    motion = replay_data(scenario, values, history, planned_orbit(scenario))
    world, target = motion["world"], np.array(motion["target"])
    position = np.array(world["position"])
    modes = {name: [k for k in range(COUNT) if world["mode"][k] == name] for name in world["mode"]}
    assert [len(rows) for rows in modes.values()] == [80, 80, 81]
    sun, down, aim = modes.values()
    np.testing.assert_allclose(
        np.array(world["sun"])[sun], axis_of(target[sun], [1, 0, 0]), atol=2e-5
    )
    nadir = -position / np.linalg.norm(position, axis=1, keepdims=True)
    np.testing.assert_allclose(nadir[down], axis_of(target[down], [0, 0, 1]), atol=5e-6)
    ahead = axis_of(target[down], [1, 0, 0])  # of a circle, but for the oblateness
    np.testing.assert_allclose(np.array(world["velocity"])[down], ahead, atol=2e-3)
    assert all(world["ground"][k] is None for k in (*sun, *down))
    ground = np.array([world["ground"][k] for k in aim])
    way = ground - position[aim]
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    np.testing.assert_allclose(way, axis_of(target[aim], [0, 0, 1]), atol=2e-5)
    # geodetic latitude 24.7 deg of the WGS 84, seen by spherical trigonometry
    up = np.degrees(np.arcsin(ground[:, 2] / np.linalg.norm(ground, axis=1)))
    flattened = np.degrees(np.arctan((1.0 - 1.0 / 298.257223563) ** 2 * np.tan(np.radians(24.7))))
    np.testing.assert_allclose(
        up, flattened, atol=0.2
    )  # the axis of the Earth has moved since 2000
    np.testing.assert_allclose(position[8], orbit.position(2.0) / EARTH_RADIUS, atol=1e-6)
    assert set(world["light"]) == {1.0}
    assert motion["field_of_view"] == pytest.approx(np.radians(12.0))


def test_without_an_orbit_there_are_no_surroundings(read, shown):
    text = re.sub(r"\[orbit\].*?(?=\[reference\])", "", SCENARIO, flags=re.DOTALL)
    text = re.sub(r"\[reference\].*?(?=\[metrics\])", "", text, flags=re.DOTALL)
    motion = replay_data(read(text), *shown[2:], planned_orbit(read(text)))
    assert motion["world"] is None
    assert set(map(tuple, motion["target"])) == {(1.0, 0.0, 0.0, 0.0)}


@pytest.mark.parametrize("view", ['"0 deg"', '"181 deg"', '"1 m"'])
def test_a_field_of_view_that_cannot_be_is_refused(read, view):
    with pytest.raises(InputError, match=r"key metrics\.field_of_view.*found"):
        read(SCENARIO.replace('"12 deg"', view))


def test_a_browser_draws_the_surroundings(shown, tmp_path, monkeypatch):
    """Angles in its text, and the places of Sun and ground target in axes of the orbit."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    if browser is None:
        pytest.skip("chromium is not installed")
    scenario, orbit, values, history = shown
    monkeypatch.setattr(campaign_run, "metric_rows", lambda *_: [])
    page, picture = tmp_path / "run.html", tmp_path / "motion.png"
    page.write_text(campaign_run.run_page(scenario, values, history, "world", "x"))
    assert not re.search(r'(src|href)="(?!#)|url\((?!#)|fetch\(|@import', page.read_text())
    command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1050,1700"]
    command.append(f"--user-data-dir={tmp_path / 'b'}")
    address = f"{page.as_uri()}#frame={AIM}"
    drawn = subprocess.run(
        [*command, "--dump-dom", address], capture_output=True, text=True, timeout=60
    ).stdout
    time = history.time.values[AIM]
    position, velocity = np.asarray(orbit.position(time)), np.asarray(orbit.velocity(time))
    sun = np.asarray(orbit.sun(time)) - position
    sight = axis_of(history.attitude.values[AIM], [0, 0, 1])
    told = re.search(r'<div class="around">mode aim; boresight to ([^<]*) deg; sunlit<', drawn)
    assert told is not None
    found = [float(part.split()[-1]) for part in told[1].split(", ")]
    lengths = [np.linalg.norm(each) for each in (position, sun, velocity)]
    cosines = [
        sight @ each / n for each, n in zip((-position, sun, velocity), lengths, strict=True)
    ]
    np.testing.assert_allclose(found, [*np.degrees(np.arccos(cosines)), 0.0], atol=0.011)

    subprocess.run([*command, f"--screenshot={picture}", address], check=True, timeout=60)
    image = imread(picture)[:, :, :3]

    def place(colour, reach):
        """Centre of a disc of a colour, pixels to the right and down."""
        inside = minimum_filter(np.linalg.norm(image - colour, axis=2) < 0.05, reach)
        return np.mean(np.argwhere(inside), axis=0)[::-1]

    up, side = position / lengths[0], np.cross(position, velocity)
    side /= np.linalg.norm(side)
    rows = np.stack([np.cross(side, up), side, up])

    def seen(direction):
        """Pixels from the centre, seen from 0.7 and 0.45 rad, 130 pixels a unit."""
        x, y, z = rows @ direction
        deep = np.cos(0.7) * x + np.sin(0.7) * y
        right = -np.sin(0.7) * x + np.cos(0.7) * y
        return 1.5 * 130.0 * np.array([right, np.sin(0.45) * deep - np.cos(0.45) * z])

    expected = seen(sun / lengths[1]) - seen(sight)
    np.testing.assert_allclose(place(SUN, 7) - place(GROUND, 4), expected, atol=1.5)
