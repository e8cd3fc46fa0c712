"""Campaigns whose runs have orbits of their own."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyrostat.campaigns.draws import check_draws, draw
from gyrostat.campaigns.engine import fly
from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.reports.replay_world import world_data
from gyrostat.scenario.kinds.orbits import orbit_of, own_orbits, planned_orbit
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.spacecraft.orbit import CircularElements
from gyrostat.spacecraft.orbit.atmosphere import Activity
from gyrostat.spacecraft.orbit.tables import errors_of, orbit_environment, samples_at
from gyrostat.spacecraft.orbit.time_scales import Epoch

pytest.importorskip("erfa", reason="the libraries of the extra orbit are not installed")

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
ENGINE = "native" if compiler() else "jax"
EPOCH = "2026-11-22T10:00:00Z"
TEXT = f"""
name = "dispersed orbits"
dispersion = [
  {{ key = "orbit.inclination", distribution = "normal", sigma = "1 deg" }},
  {{ key = "orbit.altitude", distribution = "uniform", low = "450 km", high = "550 km" }},
  {{ key = "orbit.phase", distribution = "uniform", low = 0.0, high = "360 deg" }},
  {{ key = "orbit.f107", distribution = "uniform", low = 80, high = 220 }},
  {{ key = "wheel.*.coulomb", distribution = "log_normal", sigma = "20 %" }},
]
[run]
duration = "30 s"
control_period = "0.5 s"
[spacecraft]
file = "{(EXAMPLES / "cubesat.toml").as_posix()}"
[controller]
kind = "three_axis"
[orbit]
kind = "circular"
epoch = "{EPOCH}"
altitude = "500 km"
inclination = "97.4 deg"
[[environment.torque]]
kind = "gravity_gradient"
[reference]
kind = "nadir"
"""


def read(folder, text):
    (folder / "scenario.toml").write_text(text, encoding="utf-8")
    return read_scenario(folder / "scenario.toml")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    return read(tmp_path_factory.mktemp("own_orbits"), TEXT)


@pytest.fixture(scope="module")
def flown(scenario):
    return fly(scenario, 5, [0, 3], keep=[3], engine=ENGINE)


def of_run(scenario, run):
    """Key -> value of a run."""
    values = draw(scenario, 5, np.array([run]))[0][0]
    return {**scenario.values, **dict(zip(scenario.dispersed, values, strict=True))}


def alone(scenario, run):
    """Scenario whose nominal values are those of a run."""
    return replace(scenario, values=of_run(scenario, run), dispersions=())


def test_a_run_flies_as_a_scenario_with_its_orbit(scenario, flown):
    """Their tables have rows at other times, which differ by the error of the interpolation."""
    given = fly(alone(scenario, 3), 5, [3], engine=ENGINE).columns
    for name in ("error_max", "momentum_peak"):
        column = flown.columns[name]
        assert column[1] == pytest.approx(given[name][0], rel=1e-5), name
        assert column[0] != pytest.approx(given[name][0], rel=1e-3), name


@pytest.mark.skipif(not compiler(), reason="needs a C compiler")
def test_both_engines_agree(scenario, flown):
    expected = fly(scenario, 5, [0, 3], engine="jax").columns
    for name, column in flown.columns.items():
        np.testing.assert_allclose(column, expected[name], rtol=1e-9, atol=1e-12, err_msg=name)


def test_the_tables_of_a_run_are_those_of_its_elements(scenario):
    """Against the models themselves, at times between the rows, from the phase on."""
    made = own_orbits(scenario, draw(scenario, 5, np.arange(4))[0])
    assert made.splines.shape[0] == 4
    assert made.splines.shape[1:] == planned_orbit(scenario).splines.shape
    own = of_run(scenario, 2)
    elements = CircularElements(
        *(own[f"orbit.{name}"] for name in ("altitude", "inclination", "ascending_node"))
    )
    later = own["orbit.phase"] / (2.0 * np.pi) * elements.period
    times = np.linspace(0.0, scenario.duration, 37)
    begin = Epoch.of(EPOCH, 0.0)
    direct = samples_at(
        elements.trajectory(begin, later + 3600.0),
        begin,
        later + times,
        Activity(own["orbit.f107"], own["orbit.f107a"], own["orbit.ap"]),
    )
    errors = errors_of(orbit_of(scenario, own, planned_orbit(scenario)), direct, times)
    density = errors.pop("density")
    assert max(errors.values()) < 1e-6
    assert density < 1e-3


def test_the_replay_shows_the_orbit_of_the_run(scenario, flown):
    history = flown.histories.dataset().isel(run=0)
    own = of_run(scenario, 3)
    frames = np.array([0, 10])
    seen = world_data(scenario, own, history, frames, planned_orbit(scenario))
    place = np.asarray(seen["position"][0])
    radius = 1.0 + own["orbit.altitude"] / 6378137.0
    assert np.linalg.norm(place) == pytest.approx(radius, rel=2e-3)


def test_orbits_that_are_not_possible_are_refused_before_a_run(tmp_path):
    scenario = read(tmp_path, TEXT.replace('"450 km"', '"1 km"'))
    found = r"run with .*orbit\.altitude .*: found a height of .*, expected 100 km or more"
    with pytest.raises(InputError, match=found):
        check_draws(scenario, 1, 20)


def test_a_step_that_does_not_suffice_is_refused():
    orbit = CircularElements(500e3, 1.7)
    with pytest.raises(InputError, match=r"interpolation error .* between rows 60 s apart"):
        orbit_environment(orbit, EPOCH, 660.0, step=60)
