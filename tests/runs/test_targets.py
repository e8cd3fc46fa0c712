"""Targets, ground stations and passes in a scenario: read, refused in one line, and flown."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import gyrostat as gs
from gyrostat.codegen.evaluation import evaluated
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.keep_out_times import violations
from gyrostat.runs.passes import passes_of
from gyrostat.runs.reference_path import flown_path, nominal_setup, reference_path
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft.orbit import CircularElements
from gyrostat.spacecraft.orbit.sun import moon_position, sun_position
from gyrostat.spacecraft.orbit.time_scales import Epoch

erfa = pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
EPOCH = "2026-11-22T10:00:00Z"
HEAD = """
[run]
duration = "{duration} s"
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
ascending_node = "112 deg"
[[station]]
name = "north"
latitude = "78d13m48s"
longitude = "15.39 deg"
[reference]
kind = "{kind}"
"""
SEQUENCE = """rate = "0.5 deg/s"
acceleration = 0.001
[[reference.mode]]
name = "vega"
kind = "celestial"
right_ascension = "18h36m56.3s"
declination = "+38d47m01s"
to_sun = [1, 0, 0]
until = "pass of north"
[[reference.mode]]
name = "link"
kind = "ground_mosaic"
latitude = "78d13m48s"
longitude = "15.39 deg"
columns = 2
tile_width = "1 deg"
dwell = "20 s"
step_time = "10 s"
begin = "0 s"
until = "end of pass of north"
[[reference.mode]]
name = "last"
kind = "limb"
tangent_height = "60 km"
"""
KEEP_OUT = """
[[keep_out]]
name = "camera"
boresight = [0, 0, 1]
{} = "{} deg"
"""


@pytest.fixture
def scenario(tmp_path):
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, tmp_path)

    def write(text, kind="sequence", duration=60):
        path = tmp_path / "scenario.toml"
        path.write_text(HEAD.format(kind=kind, duration=duration) + text, encoding="utf-8")
        return path

    return write


def test_passes_are_those_of_a_search_without_tables(scenario):
    """Elements, Earth rotation and vertical straight from the libraries, every second."""
    found = passes_of(read_scenario(scenario(SEQUENCE, duration=6000)))
    epoch = Epoch.of(EPOCH)
    elements = CircularElements(500e3, np.radians(97.4), np.radians(112.0))
    times = np.arange(0.0, 6000.0)
    place = elements.trajectory(epoch, 6000.0).states(times).position
    turned = erfa.c2t06a(*epoch.tt(times), *epoch.ut1_at(times), 0.0, 0.0)
    north = (np.radians(15.39), np.radians(78.23))
    station = erfa.gd2gc(1, *north, 0.0)
    vertical = erfa.gd2gc(1, *north, 1.0) - station
    sight = np.einsum("nij,nj->ni", turned, place) - station
    elevation = np.degrees(np.arcsin(sight @ vertical / np.linalg.norm(sight, axis=1)))
    seen = np.flatnonzero(elevation > 0.0)
    (north_pass,) = (each for each in found if each.name == "north")
    assert north_pass.begin == pytest.approx(times[seen[0]], abs=1.0)
    assert north_pass.end == pytest.approx(times[seen[-1]], abs=1.0)
    assert np.degrees(north_pass.highest) == pytest.approx(elevation.max(), abs=0.01)
    # the shadow as a cylinder: some seconds from the middle of the penumbra
    sun = sun_position(epoch, times)
    sun = sun / np.linalg.norm(sun, axis=1)[:, None]
    along = np.sum(place * sun, axis=1)
    apart = np.linalg.norm(place - along[:, None] * sun, axis=1)
    dark = np.diff(((along < 0.0) & (apart < 6378137.0)).astype(int), prepend=0, append=0)
    eclipses = [(each.begin, each.end) for each in found if each.name == "eclipse"]
    expected = np.column_stack([np.flatnonzero(dark > 0), np.flatnonzero(dark < 0)])
    np.testing.assert_allclose(eclipses, expected, atol=10.0)


def test_passes_and_bright_bodies_are_those_from_the_phase_on(scenario):
    """A phase of a quarter is a quarter of a period later: with the Earth and the Sun there."""
    text = 'latitude = "0 deg"\nlongitude = "0 deg"\n' + KEEP_OUT.format("sun", 60.0)
    period = CircularElements(500e3, np.radians(97.4), np.radians(112.0)).period
    early = read_scenario(scenario(text, "ground_target", duration=6000))
    late = early.replace(**{"orbit.phase": "90 deg"})

    def intervals(definition, shift):
        found = passes_of(definition), violations(definition, reference_path(definition))
        ends = [(each.begin + shift, each.end + shift) for each in (*found[0], *found[1])]
        # those whose begin and end both runs contain
        return [e for e in ends if e[0] > 0.25 * period + 2.0 and e[1] < 6000.0 - 2.0]

    expected = intervals(early, 0.0)
    assert len(expected) >= 2
    np.testing.assert_allclose(intervals(late, 0.25 * period), expected, atol=1.1)


def test_bright_bodies_of_a_dispersed_run_are_those_of_its_own_orbit(scenario):
    more = '[[dispersion]]\nkey = "orbit.phase"\ndistribution = "uniform"\nlow = 0\nhigh = 3\n'
    text = 'latitude = "0 deg"\nlongitude = "0 deg"\n' + KEEP_OUT.format("sun", 60.0)
    definition = read_scenario(scenario(text + more, "ground_target", duration=3000))
    drawn = {"orbit.phase": 1.5}
    alone = read_scenario(scenario(text, "ground_target", duration=3000)).replace(**drawn)
    path = reference_path(alone)
    expected = violations(alone, path)
    assert expected
    assert violations(definition, path, drawn) == expected
    assert violations(definition, path) != expected


def test_modes_wait_for_a_pass_and_for_its_end(scenario):
    definition = read_scenario(scenario(SEQUENCE, duration=6000))
    begin, end = next((p.begin, p.end) for p in passes_of(definition) if p.name == "north")
    reference = nominal_setup(definition).reference

    @jax.jit
    def ends(number, time):
        mode = reference.start()._replace(number=number)
        return reference.step(mode, None, time).number > number

    for number, time in ((0, begin), (1, end)):
        assert not ends(number, time - 1.0)
        assert ends(number, time + 1.0)


def test_the_native_engine_flies_the_targets_of_the_reference(scenario):
    """It is dark at the start, so that the first mode ends at once."""
    text = SEQUENCE.replace("pass of north", "eclipse", 1)
    text = text[: text.index('until = "end of pass')]
    path = scenario(text, duration=120)
    run = gs.simulate(path, engine="native")
    setup = nominal_setup(read_scenario(path))
    assert set(np.array(run["mode"])[1:]) == {1.0}

    @evaluated  # three times: compiling takes longer
    def target(number, start, time):
        reference = setup.reference
        mode = reference.entered(reference.start(), number, start)
        return reference.at(mode, time).attitude

    for k in (20, 70, 110):
        start = float(run["mode_start"][k])
        expected = target(jnp.array(1), jnp.array(start), jnp.array(float(run["time"][k])))
        np.testing.assert_allclose(run["target"][k], expected, atol=1e-9)


def test_another_spacecraft_from_a_file_is_followed(scenario, tmp_path):
    orbit = CircularElements(500e3, np.radians(97.4), np.radians(112.0))
    times = np.arange(0.0, 400.0, 20.0)
    states = orbit.trajectory(Epoch.of(EPOCH), 500.0).states(times + 20.0)
    rows = np.column_stack([times, states.position, states.velocity])
    lines = ["time,x,y,z,vx,vy,vz", *(",".join(map(repr, row)) for row in rows.tolist())]
    (tmp_path / "other.csv").write_text("\n".join(lines), encoding="utf-8")
    definition = read_scenario(scenario('file = "other.csv"', "spacecraft"))
    reference = nominal_setup(definition).reference
    at = reference.at(reference.start(), 33.0).attitude
    boresight = Rotation.from_quat(np.array(at), scalar_first=True).apply([0.0, 0.0, 1.0])
    both = orbit.trajectory(Epoch.of(EPOCH), 500.0).states(np.array([33.0, 53.0])).position
    sight = both[1] - both[0]
    np.testing.assert_allclose(boresight, sight / np.linalg.norm(sight), atol=1e-6)
    with pytest.raises(InputError, match="key reference: file: found states from 0 s to 380 s"):
        read_scenario(scenario('file = "other.csv"', "spacecraft", duration=900))


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("pass of north", "pass of south", "'pass of south', expected .*pass of north"),
        ("pass of north", "dawn", "until: found 'dawn'"),
        (
            "to_sun = [1, 0, 0]",
            "to_sun = [1, 0, 0]\nnormal = [0, 1, 0]",
            "found several second axes",
        ),
        ("to_sun = [1, 0, 0]", "along = [0, 0, 0]", "found no second axis"),
        ("+38d47m01s", "+98d47m01s", "declination"),
        ('tangent_height = "60 km"', 'tangent_height = "-1 km"', "tangent_height"),
        (
            'tile_width = "1 deg"',
            'tile_width = "170 deg"',
            "reaches more than 80 deg from its target",
        ),
        ('latitude = "78d13m48s"', 'latitude = "139.7 deg"', "latitude"),
    ],
)
def test_mistakes_are_one_line(scenario, old, new, words):
    with pytest.raises(InputError, match=words):
        read_scenario(scenario(SEQUENCE.replace(old, new, 1)))


def test_a_condition_that_is_a_text_has_no_dispersion(scenario):
    row = '[[dispersion]]\nkey = "reference.mode.vega.until"\ndistribution = "uniform"\n'
    with pytest.raises(InputError, match=r"found reference\.mode\.vega\.until, a text"):
        read_scenario(scenario(SEQUENCE + row + "low = 1.0\nhigh = 2.0\n"))


def test_a_station_has_not_the_name_of_another_view(scenario):
    path = scenario(SEQUENCE)
    path.write_text(path.read_text().replace('name = "north"', 'name = "eclipse"'))
    with pytest.raises(InputError, match="none of eclipse, sunlight"):
        read_scenario(path)


def test_a_tangent_point_above_the_spacecraft_is_refused(scenario):
    path = scenario('tangent_height = "600 km"', "limb")
    with pytest.raises(InputError, match="found no attitude along the reference at 0 s"):
        gs.check(path)


@pytest.mark.parametrize("body", ["sun", "earth", "moon"])
def test_a_body_that_is_too_near_is_listed_with_its_times(scenario, body):
    """Along the line to a place on the ground, also through the Earth, or to the celestial pole."""
    kind, text = "ground_target", 'latitude = "0 deg"\nlongitude = "0 deg"\n'
    if body == "earth":
        kind, text = "celestial", 'right_ascension = "0 deg"\ndeclination = "90 deg"\n'
    epoch, times = Epoch.of(EPOCH), np.arange(0.0, 4001.0)
    orbit = CircularElements(500e3, np.radians(97.4), np.radians(112.0))
    place = orbit.trajectory(epoch, 4001.0).states(times).position
    turned = erfa.c2t06a(*epoch.tt(times), *epoch.ut1_at(times), 0.0, 0.0)
    sight = np.einsum("nji,j->ni", turned, erfa.gd2gc(1, 0.0, 0.0, 0.0)) - place
    sight = np.tile([0.0, 0.0, 1.0], (len(times), 1)) if body == "earth" else sight
    toward = {"sun": sun_position, "moon": moon_position}.get(body, lambda *_: 0.0)(epoch, times)
    toward = toward - place
    cosine = np.sum(sight * toward, axis=1)
    cosine /= np.linalg.norm(sight, axis=1) * np.linalg.norm(toward, axis=1)
    down = np.sum(-place * toward, axis=1)
    down /= np.linalg.norm(place, axis=1) * np.linalg.norm(toward, axis=1)
    radius = np.degrees(np.arcsin(6378137.0 / np.linalg.norm(place, axis=1)))
    angle = np.degrees(np.arccos(cosine)) - (radius if body == "earth" else 0.0)
    # the Sun is hidden when all of its disc is
    disc = 0.2665 if body == "sun" else 0.0
    hidden = np.degrees(np.arccos(np.clip(down, -1.0, 1.0))) < radius - disc
    # more than the smallest angle that is not behind the Earth
    seen = angle if body == "earth" else np.where(hidden, 180.0, angle)
    limit = max(float(np.min(seen)) + 10.0, 20.0)
    expected = seen < limit
    path = scenario(text + KEEP_OUT.format(body, limit), kind, duration=4000)
    found = violations(read_scenario(path), reference_path(read_scenario(path)))
    assert {each.body for each in found} == {body}
    listed = np.zeros(len(times), bool)
    for each in found:
        listed[round(each.begin) : round(each.end)] = True
    assert np.count_nonzero(listed[:-1] != expected[:-1]) <= 3 * len(found)
    assert 0 < np.count_nonzero(expected) < len(times)
    warnings = gs.check(path).warnings
    assert any(f"keep_out camera: found the {body.title()} too near" in line for line in warnings)


def test_the_time_with_a_body_too_near_to_any_boresight_is_a_metric(scenario):
    ahead = KEEP_OUT.format("sun", 60.0).replace("[0, 0, 1]", "[1, 0, 0]")
    above = KEEP_OUT.format("moon", 110.0).replace("[0, 0, 1]", "[0, 0, -1]")
    both = ahead + above.replace("camera", "mirror")
    run = gs.simulate(scenario(both, "nadir", duration=4000), engine="native")
    definition = read_scenario(scenario(both, "nadir", duration=4000))
    history = {name: run[name].values for name in ("attitude", "rate")}
    found = violations(definition, flown_path(definition, history))
    near = np.zeros((2, 4000), bool)
    for each in found:
        near[int(each.instrument == "mirror"), round(each.begin) : round(each.end)] = True
    counts = np.count_nonzero(near, axis=1)
    assert np.all((counts > 0) & (counts < 4000)), counts
    assert run.attrs["keep_out_time"] == np.count_nonzero(near.any(axis=0))
