"""What a star tracker sees: metrics against counts, the reference path, rays, placements."""

import json
import shutil
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import gyrostat as gs
from gyrostat.core.directions import spread_evenly
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.reports.placement import write_placement
from gyrostat.runs.blind_windows import blind_windows
from gyrostat.runs.body_sky import BodySky, body_sky
from gyrostat.runs.placement import DIRECTIONS, Blocked, Exclusion, evaluated, margins, place_heads
from gyrostat.runs.reference_path import longest_outage, nominal_setup, reference_path
from gyrostat.runs.surface_placement import place_panel, view_factor
from gyrostat.runs.tracker_forecast import heads_of_run, tracker_forecasts, tracker_lines
from gyrostat.scenario.kinds.orbits import orbit_with_moon
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
HEADS = """
[[star_tracker]]
name = "left"
across_sigma = "5 arcsec"
about_sigma = "50 arcsec"
boresight = [0.0, 1.0, -0.2]
sun_exclusion = "40 deg"
earth_exclusion = "20 deg"
moon_exclusion = "51.6 deg"
rate_limit = "0.6 deg/s"
[[star_tracker]]
name = "right"
across_sigma = "5 arcsec"
about_sigma = "50 arcsec"
boresight = [-1.0, 0.0, 0.1]
sun_exclusion = "50 deg"
moon_exclusion = "102.6 deg"
rate_limit = "0.5 deg/s"
"""
SEQUENCE = """[reference]
kind = "sequence"
rate = "2 deg/s"
acceleration = 0.002
jerk = 0.002
mode = [
  { name = "sun", kind = "sun", until_time = "11 s" },
  { name = "nadir", kind = "nadir" },
]
"""
SCENARIO = f"""
[run]
duration = "120 s"
control_period = "0.5 s"
[spacecraft]
file = "cubesat.toml"
[orbit]
kind = "circular"
epoch = "2026-11-22T10:00:00Z"
altitude = "500 km"
inclination = "97.4 deg"
[controller]
kind = "three_axis"
[sensors]
kind = "star_tracker_gyro"
attitude_sigma = "60 arcsec"
tracker_periods = 4
angle_walk = 1e-5
{HEADS}
[reference]
kind = "nadir"
[[event]]
name = "lost"
kind = "sensor_dropout"
sensor = "attitude"
time = "100.2 s"
until = "107.1 s"
[guard]
[metrics]
least_availability = 0.8
[[metrics.window]]
name = "early"
until = "12 s"
[[metrics.window]]
name = "late"
from = "60 s"
until = "105 s"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tracker")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder / name)
    (folder / "scenario.toml").write_text(SCENARIO, encoding="utf-8")
    text = SCENARIO.replace(HEADS, "").replace("least_availability = 0.8\n", "")
    (folder / "no_heads.toml").write_text(text, encoding="utf-8")
    text = text.replace('[reference]\nkind = "nadir"\n', SEQUENCE)
    text = text[: text.index("[[event]]")] + text[text.index("[guard]") :]
    text = text.replace('name = "late"', 'name = "late"\nmode = "nadir"')
    (folder / "sequence.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def scenario(folder):
    return read_scenario(folder / "scenario.toml")


@pytest.fixture(scope="module")
def said():
    return []


@pytest.fixture(scope="module")
def flown(scenario, said):
    return gs.simulate(scenario, say=said.append)


def held(samples, periods):
    """Whether a sample is not older than the sampling interval, by looking back at each time."""
    return np.array([samples[max(0, k - periods + 1) : k + 1].any() for k in range(len(samples))])


def longest(known, period):
    """Length of the longest run of false entries, s."""
    return period * max(map(len, "".join("01"[int(k)] for k in known).split("1")))


def test_metrics_are_those_of_the_history(flown):
    time, heads = flown.time.values, flown.tracker_heads.values.astype(bool)
    measured = flown.attitude_measured.values.astype(bool)
    dropped = (time >= 100.2 - 1e-9) & (time < 107.1 - 1e-9)
    known = held(measured & ~dropped, 4)
    views = held(heads[:, 0], 4).astype(int) + held(heads[:, 1], 4)
    late = (time >= 60.0 - 1e-9) & (time <= 105.0 + 1e-9)
    for prefix, rows in {"": time >= 0.0, "early.": time <= 12.0, "late.": late}.items():
        name = f"{prefix}tracker_"
        assert flown.attrs[f"{name}availability"] == pytest.approx(known[rows].mean(), abs=1e-12)
        assert flown.attrs[f"{name}outage"] == pytest.approx(longest(known[rows], 0.5), abs=1e-9)
        assert flown.attrs[f"{prefix}heads_in_view"] == pytest.approx(views[rows].mean(), abs=1e-12)
    assert 6.0 <= flown.attrs["late.tracker_outage"] < 40.0
    assert 0.0 < flown.attrs["tracker_availability"] < 1.0
    assert 0.0 < flown.attrs["heads_in_view"] < 2.0


def test_a_window_that_sees_too_rarely_is_said(scenario, flown, said):
    low = [name for name in ("early", "late") if flown.attrs[f"{name}.tracker_availability"] < 0.8]
    assert low
    lines = [line for line in said if line.startswith("warning: window")]
    assert [line.split()[2].rstrip(":") for line in lines] == low
    columns = {
        f"{window}.{name}": np.array(values)
        for window in ("early", "late")
        for name, values in {
            "tracker_availability": [0.9, 0.7, 0.4],
            "tracker_outage": [1.0, 3.0, 9.0],
        }.items()
    }
    columns["late.tracker_availability"] = np.array([0.8, 0.9, 1.0])
    (line,) = blind_windows(scenario, columns)
    assert line.startswith("window early: ")
    assert "80 % of the time in 2 of 3 runs: at least 40 %, longest outage 9 s" in line


def test_only_a_tracker_with_heads_has_them(folder, scenario):
    without = read_scenario(folder / "no_heads.toml")
    names = {"tracker_outage", "late.heads_in_view"}
    assert names <= set(metrics_of(scenario))
    assert not names & set(metrics_of(without))
    assert "metrics.least_availability" not in without.values
    assert tracker_lines(without) == ([], [])
    text = SCENARIO.replace(HEADS, "")
    (folder / "wrong.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="least_availability"):
        read_scenario(folder / "wrong.toml")


def test_the_path_is_the_reference_of_a_simulation(scenario, flown):
    path = reference_path(scenario)
    np.testing.assert_array_equal(path.time, flown.time.values)
    turn = Rotation.from_quat(path.attitude, scalar_first=True).inv()
    turn *= Rotation.from_quat(flown.target.values, scalar_first=True)
    assert np.max(turn.magnitude()) < 1e-9
    np.testing.assert_array_equal(path.windows["late"], (path.time >= 60) & (path.time <= 105))
    np.testing.assert_array_equal(path.windows["early"], path.time <= 12.0)
    # the rate is that of the attitude
    later = Rotation.from_quat(path.attitude[1:], scalar_first=True)
    step = (Rotation.from_quat(path.attitude[:-1], scalar_first=True).inv() * later).as_rotvec()
    mean = 0.25 * (path.rate[1:] + path.rate[:-1])
    assert np.max(np.abs(step - mean)) < 2e-5


def test_the_modes_of_a_path_follow_each_other_between_its_rows(folder, scenario):
    nadir = reference_path(scenario)
    path = reference_path(read_scenario(folder / "sequence.toml"), 50)
    assert path.step == 2.5
    turn = Rotation.from_quat(path.attitude, scalar_first=True)
    apart = (turn.inv() * Rotation.from_quat(nadir.attitude[::5], scalar_first=True)).magnitude()
    assert np.all(apart[path.time <= 10.0] > 0.1)  # to the Sun
    arrived = np.flatnonzero(apart < 1e-9)
    assert 12.0 < path.time[arrived[0]] < 100.0
    assert np.all(apart[arrived[0] :] < 1e-9)
    # the second mode begins at 11 s, between two rows
    late = (path.time >= 11.0 + 60.0) & (path.time <= 11.0 + 105.0)
    np.testing.assert_array_equal(path.windows["late"], late)


def test_the_forecast_is_that_of_rays(scenario):
    """Cones of rays against a sphere and points, at every time of the path."""
    path, orbit = reference_path(scenario), orbit_with_moon(scenario)
    at = jax.jit(jax.vmap(lambda t: (orbit.position(t), orbit.sun(t), orbit.moon(t))))
    place, sun, moon = map(np.asarray, at(path.time))
    turn = Rotation.from_quat(path.attitude, scalar_first=True)
    sees = []
    for boresight, angles, limit in (
        ([0.0, 1.0, -0.2], (40.0, 20.0, 51.6), 0.6),
        ([-1.0, 0.0, 0.1], (50.0, 0.0, 102.6), 0.5),
    ):
        line = turn.apply(np.array(boresight) / np.linalg.norm(boresight))

        def hits(rays, place=place):
            along = -np.sum(rays * place, axis=-1)
            nearest = np.linalg.norm(place + along[..., None] * rays, axis=-1)
            return (along > 0.0) & (nearest < EARTH_RADIUS)

        side = np.cross(line, [0.3, -0.5, 0.8])
        side /= np.linalg.norm(side, axis=1)[:, None]
        blind = hits(line)
        for around in np.linspace(0.0, 2.0 * np.pi, 721):
            across = np.cos(around) * side + np.sin(around) * np.cross(line, side)
            cone = np.radians(angles[1])
            blind |= hits(np.cos(cone) * line + np.sin(cone) * across)
        for body, angle in ((sun, angles[0]), (moon, angles[2])):
            ray = body - place
            ray /= np.linalg.norm(ray, axis=1)[:, None]
            blind |= (np.sum(ray * line, axis=1) > np.cos(np.radians(angle))) & ~hits(ray)
        sees.append(~blind & (np.linalg.norm(path.rate, axis=1) <= np.radians(limit)))
    run, early, late = tracker_forecasts(scenario)
    for each, rows in (
        (run, slice(None)),
        (early, path.time <= 12.0),
        (late, path.windows["late"]),
    ):
        found = np.any(sees, axis=0)[rows]
        assert each.availability == pytest.approx(found.mean(), abs=1e-3)
        assert each.outage == pytest.approx(longest(found, 0.5), abs=0.51)
        for name, one in zip(("left", "right"), sees, strict=True):
            assert each.heads[name] == pytest.approx(one[rows].mean(), abs=1e-3)
    assert 0.0 < run.availability < 1.0
    assert {name for name, share in run.causes["left"].items() if share > 0.0} >= {"moon"}
    # the placement computes the same from Sun, Earth and Moon in body axes
    sky = body_sky(orbit, path.time, path.attitude, path.rate)
    for head, expected in zip(heads_of_run(nominal_setup(scenario)), sees, strict=True):
        axis = np.asarray(head.boresight) / np.linalg.norm(head.boresight)
        names = ("sun_exclusion", "earth_exclusion", "moon_exclusion", "rate_limit")
        exclusion = Exclusion(*(float(getattr(head, name)) for name in names))
        found = evaluated(sky, axis[None], [exclusion])
        assert found.availability == pytest.approx(expected.mean(), abs=1e-3)


def wandering_sky(seed, rows=60):
    """Sun, Earth and Moon at random."""
    random = np.random.default_rng(seed)
    lines = random.normal(size=(3, rows, 3))
    lines /= np.linalg.norm(lines, axis=2, keepdims=True)
    light, moonlit = random.random(rows) < 0.7, random.random(rows) < 0.8
    return BodySky(*lines, np.full(rows, 1.1), 1.0 * light, moonlit, random.random(rows))


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_best_heads_are_those_of_all_combinations(count):
    exclusion, directions = Exclusion(0.8, 0.3, 0.3, 0.95), spread_evenly(30)
    cone = Blocked(np.array([0.0, 0.0, -1.0]), 0.6)
    for seed in range(4):
        sky = wandering_sky(seed)
        found = place_heads(sky, exclusion, count, apart=1.0, blocked=[cone], directions=directions)
        free = directions[directions @ cone.direction < np.cos(cone.angle)]
        sees = margins(sky, free, exclusion) >= 0.0

        def aims(each, sees=sees):
            chosen = sees[:, list(each)]
            return round(chosen.any(axis=1).mean(), 3), round(chosen.mean(), 3)

        apart = [
            each
            for each in combinations(range(len(free)), count)
            if all(free[a] @ free[b] <= np.cos(1.0) for a, b in combinations(each, 2))
        ]
        best = max(map(aims, apart))
        assert (round(found.availability, 3), round(found.in_view / count, 3)) == best
        assert np.all(found.directions @ cone.direction < np.cos(0.6))


def test_a_finer_search_is_no_worse_and_keeps_the_rules():
    sky, exclusion = wandering_sky(9, 200), Exclusion(0.6, 0.2, 0.2, 0.9)
    cone = Blocked(np.array([1.0, 0.0, 0.0]), 0.5)
    coarse = place_heads(
        sky, exclusion, 2, apart=1.0, blocked=[cone], directions=spread_evenly(DIRECTIONS)
    )
    fine = place_heads(sky, exclusion, 2, apart=1.0, blocked=[cone])
    assert fine.availability >= coarse.availability - 5e-4
    first, second = fine.directions
    assert first @ second <= np.cos(1.0) + 1e-9
    assert np.all(fine.directions[:, 0] < np.cos(0.5))
    halves = [Blocked(sign * np.array([1.0, 0.0, 0.0]), 1.6) for sign in (1.0, -1.0)]
    assert place_heads(sky, exclusion, 1, blocked=halves) is None


def test_the_view_factor_is_an_integral():
    random = np.random.default_rng(0)
    rays = random.normal(size=(400_000, 3))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    for radius in (0.3, 1.1):
        for angle in (0.0, 0.2, 1.0, 1.5, 2.0, 3.0):
            normal = np.array([np.sin(angle), 0.0, np.cos(angle)])
            part = np.maximum(rays @ normal, 0.0) * (rays[:, 2] > np.cos(radius))
            found = float(view_factor(np.array(np.cos(angle)), np.array(radius)))
            assert found == pytest.approx(4.0 * part.mean(), abs=5e-3)
    assert view_factor(np.array(1.0), np.array(0.5)) == pytest.approx(np.sin(0.5) ** 2)


def test_a_panel_faces_a_sun_that_stays():
    sky = wandering_sky(1, 50)
    sun = np.array([0.6, 0.0, 0.8])
    found = place_panel(sky._replace(sun=np.tile(sun, (50, 1)), sunlight=np.ones(50)))
    assert found.direction @ sun > np.cos(np.radians(2.0))
    assert found.mean == pytest.approx(found.direction @ sun)


def test_place_writes_what_it_finds(folder, scenario, run, monkeypatch):
    results = []

    def write(result, *arguments, **options):
        results.append(result)
        write_placement(result, *arguments, **options)

    monkeypatch.setattr("gyrostat.reports.placement.write_placement", write)
    out = folder / "placed"
    words = ("place", folder / "scenario.toml", "--out", out, "--window", "late", "--json")
    code, printed, said = run(*words)
    assert code == 0, said
    content = json.loads((out / "place.json").read_text(encoding="utf-8"))
    assert json.loads(printed) == content
    assert content["attitude"] == "the reference"
    assert content["windows"] == ["late"]
    assert content["best"][0]["availability"] >= content["present"]["each"][0]
    # each head of the scenario with its own angles
    late = tracker_forecasts(scenario)[-1]
    assert content["present"]["each"] == pytest.approx([*late.heads.values()], abs=1e-9)
    assert content["present"]["availability"] == pytest.approx(late.availability, abs=1e-9)
    assert [len(heads["directions"]) for heads in content["best"]] == [1, 2]
    assert "best 2 heads: at least one sees in" in said
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "heads of the scenario" in page
    assert page.count('class="mark"') == 2 + 2 + 2
    # the picture has the directions where they are: longitude about body z, from x
    (placed,) = results
    (axes, bar) = placed.plot().axes
    drawn = {line.get_label(): line.get_xydata() for line in axes.get_lines()}
    for name, heads in (("best 2 heads", "best"), ("heads of the scenario", "present")):
        x, y, z = np.transpose(np.atleast_1d(content[heads])[-1]["directions"])
        expected = np.transpose([np.arctan2(y, x), np.arcsin(z)])
        np.testing.assert_allclose(drawn[name], expected, atol=1e-9)
    blind = next(each for each in axes.collections if each.get_array() is not None).get_array()
    assert 0.0 <= np.min(blind) < np.max(blind) <= 100.0
    assert bar.get_ylabel() == "blind (% of the time)"
    assert "data:image/png" in placed._repr_html_()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--heads", "4"), "--heads: found 4, expected 1 to 3"),
        (("--window", "noon"), "--window: found 'noon', expected one of early, late, run"),
        (("--blocked", "-z"), "--blocked: found '-z', expected DIRECTION:HALF_ANGLE"),
        (("--blocked", "-z:0deg"), "half angle 0 deg, expected one between"),
        (("--sun", "200 deg"), "--sun: found 200 deg, expected 0 to less than 180 deg"),
        (("--sun", "nan"), "--sun"),
        (("--apart", "120deg"), "--apart: found 120 deg, expected 0 to 90 deg"),
        (("--rate", "0"), "--rate: found 0 rad/s"),
        (("--emittance", "1.5"), "--emittance: found 1.5, expected 0 to 1"),
    ],
)
def test_place_refuses_in_one_line(folder, run, words, message):
    code, _, said = run("place", folder / "scenario.toml", "--out", folder / "none", *words)
    assert code == 2
    assert message in said.splitlines()[-1]
    assert not (folder / "none").exists()


def test_place_without_heads_asks_for_the_angles(folder, run):
    words = ("place", folder / "no_heads.toml", "--out", folder / "none", "--sun", "30deg")
    code, _, said = run(*words)
    assert code == 2
    assert "--earth: found none and no [[star_tracker]] in the scenario" in said
    assert longest_outage(np.array([True, False, False, True, False]), 2.0) == 4.0
