"""The exported application in NASA's core Flight System, flown in lock-step with a plant in C."""

import shutil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns.draws import noise_keys
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.random_keys import random_keys
from gyrostat.exports import scenario_controller
from gyrostat.exports.cfs import application
from gyrostat.runs.build import build
from gyrostat.runs.plans import plans_of
from gyrostat.scenario.structure import structure_of

HERE = Path(__file__).parent
SCENARIOS = HERE.parents[1] / "examples" / "scenarios"
CACHE = HERE.parents[1] / ".pytest_cache" / "cfs"
TICKS, PERIOD = 10_000, 0.1  # 1000 s
NEAR = 1e-9  # rad

pytestmark = pytest.mark.optimised_c


@pytest.fixture(scope="module")
def harness(module_at):
    """The modules of the folder cfs: the mission, plants in C, and the flight with faults."""
    mission, flights, faults = (module_at(HERE / "cfs" / f"{n}.py") for n in NAMES)
    lacking = mission.missing()
    if lacking:
        pytest.skip(lacking)
    return mission, flights, faults


NAMES = ("mission", "flights", "faults")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    """Three wheels on an air-bearing table; the fan drives one of them through zero speed."""
    folder = tmp_path_factory.mktemp("scenario")
    for path in SCENARIOS.glob("table*.toml"):
        shutil.copy(path, folder)
    text = (SCENARIOS / "carrara_kuga.toml").read_text(encoding="utf-8")
    (folder / "flown.toml").write_text(text.replace('"400 s"', '"1000 s"'), encoding="utf-8")
    return gs.read_scenario(folder / "flown.toml")


class Built(NamedTuple):
    """Mission with two applications, and a test application for each.

    Attributes:
        folder: Folder in which it runs.
        case: Table with its compensator.
        flights: Name of the application -> its flight.
    """

    folder: Path
    case: Any
    flights: dict[str, Any]


@pytest.fixture(scope="module")
def built(harness, scenario, tmp_path_factory):
    mission, flights, faults = harness
    case = faults.Case.make()
    values = jax.tree.map(jnp.asarray, dict(scenario.values))
    setup = build(structure_of(scenario), values, plans_of(scenario))
    parts = (setup.plant, setup.sensor, setup.controller, setup.start)
    recorded = [f"state.attitude[{k}]" for k in range(4)]
    flown = {
        "compensator": case.flight(flights),
        "controller": flights.Flight("controller", *parts, PERIOD, 0, "attitude[1]", recorded),
    }
    exported = application(scenario_controller(scenario, "hold"), "double", "A test.")
    controller = {name.removeprefix("controller/"): text for name, text in exported.items()}
    apps = {
        "compensator": flights.for_test("compensator", case.texts()),
        "controller": flights.for_test("controller", controller, flights.other_ids("CONTROLLER")),
        **{f"fly_{name}": flight.flyer() for name, flight in flown.items()},
    }
    folder = tmp_path_factory.mktemp("mission") / "cpu1"
    startup = "".join(flight.startup() for flight in flown.values())
    mission.Mission(CACHE).build(apps, f"{startup}!\n", folder)
    return Built(folder, case, flown)


@pytest.fixture(scope="module")
def flown(built, harness):
    """Rows of both applications, which flew 1000 s at the same time."""
    mission, _, faults = harness
    keys = {
        "compensator": jax.random.key(faults.SEED),
        "controller": random_keys(noise_keys(faults.SEED, np.zeros(1, int)))[0],
    }
    for name, flight in built.flights.items():
        text = faults.script_text([], TICKS)
        (built.folder / f"{name}.script").write_text(text, encoding="utf-8")
        flight.noise(keys[name], TICKS + 1).tofile(built.folder / f"{name}.noise")
    mission.fly(built.folder, [*built.flights])
    return {name: flight.rows(built.folder, TICKS) for name, flight in built.flights.items()}


def test_a_compensator_points_as_in_python_for_1000_s(built, flown):
    rows, last = flown["compensator"]
    history = built.case.simulated(built.case.compensator, TICKS)
    speed = history.speed.values
    assert speed.min() < 0.0 < speed.max()
    np.testing.assert_allclose(
        rows["state.attitude"], history.attitude.values[:TICKS], rtol=0.0, atol=NEAR
    )
    np.testing.assert_array_equal(rows["tick"], np.arange(1, TICKS + 1))
    assert last["Samples[0]"] == last["Ticks"] == TICKS


def test_the_controller_of_a_scenario_points_as_in_python_for_1000_s(scenario, flown, harness):
    rows, last = flown["controller"]
    history = gs.simulate(scenario, seed=harness[2].SEED, engine="native")
    attitude = np.stack([rows[f"state.attitude[{k}]"] for k in range(4)], axis=1)
    # the rotation between two unit quaternions is twice their distance
    distance = np.linalg.norm(attitude - history.attitude.values[:TICKS], axis=1)
    assert np.max(2.0 * distance) <= NEAR
    assert np.ptp(history.error.values) > 1e-3
    assert last["Samples[0]"] == last["Ticks"] == TICKS


def test_every_fault_is_counted_reported_and_survived(built, harness, tmp_path):
    mission, flights, faults = harness
    folder = tmp_path / "cpu1"
    shutil.copytree(built.folder, folder, ignore=shutil.ignore_patterns("*.done", "fly_contr*"))
    faults.write_tables(folder / "cf", faults.table_size(built.case))
    flight = built.flights["compensator"]
    result = faults.fly_case(mission, flight, folder, faults.SCRIPT, faults.TICKS)
    found = faults.differences(built.case, result, faults.SCRIPT, faults.TICKS, flights.COUNTS)
    assert found == []


@pytest.mark.parametrize("precision", ["double", "float"])
def test_the_application_compiles_without_warnings(precision, built, harness, tools, tmp_path):
    mission, *_ = harness
    flags = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wcast-qual", "-Wundef", "-pedantic"]
    flags += ["-std=c99", "-Werror", "-D_LINUX_OS_", "-D_POSIX_OS_", "-D_XOPEN_SOURCE=600"]
    for path in mission.include_folders(mission.Mission(CACHE).root):
        flags += ["-isystem", str(path)]
    app = tmp_path / "compensator"
    flags += ["-I", str(app / "fsw" / "mission_inc"), "-I", str(app / "flight")]
    for name, text in built.case.texts(precision).items():
        (app / name).parent.mkdir(parents=True, exist_ok=True)
        (app / name).write_text(text, encoding="utf-8")
    sources = [*app.glob("fsw/*/*.c"), app / "flight" / "compensator.c"]
    assert len(sources) == 5
    for source in sources:
        done = mission.run([tools.compiler(), *flags, "-fsyntax-only", str(source)])
        assert done.stderr == ""
