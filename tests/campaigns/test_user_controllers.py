"""Own controllers in a scenario: the same runs in every process, engine and repetition."""

import ast
import json
import runpy
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns import Job, Store, run_campaign
from gyrostat.campaigns.jobs import work, work_here
from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.runs import plans
from gyrostat.runs.plans import plans_of
from gyrostat.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

pytestmark = pytest.mark.skipif(not compiler(), reason="found no C compiler")

MISSION = '''"""Controller of a mission."""

from typing import Annotated, NamedTuple

import equinox as eqx
import jax.numpy as jnp
from parts.allocation import allocated

from gyrostat.scenario.schema import Key
from gyrostat.spacecraft import Spacecraft


class Command(NamedTuple):
    torque: jnp.ndarray
    pointed: jnp.ndarray


class Pointer(eqx.Module):
    """Proportional and derivative control."""

    kp: Annotated[float, Key("N·m", least=0.0, positive=True)]
    kd: float = 0.2
    bias: jnp.ndarray = eqx.field(default_factory=lambda: jnp.zeros(3))
    weights: jnp.ndarray = eqx.field(default_factory=lambda: jnp.eye(3))
    spacecraft: Spacecraft = None

    def start(self, period):
        return {"time": 0.0, "sum": jnp.zeros(3)}

    def __call__(self, memory, measurement):
        q = measurement.attitude
        error = 2.0 * q[1:] * jnp.sign(q[0])
        torque = -self.kp * self.weights @ error - self.kd * measurement.rate + self.bias
        memory = {"time": measurement.time, "sum": memory["sum"] + error}
        return memory, Command(allocated(self.spacecraft, torque), jnp.sqrt(error @ error))
'''
ALLOCATION = """from gyrostat.core.linear import inverse_definite

from . import constants


def allocated(spacecraft, torque):
    axes = spacecraft.wheels.axes
    return -constants.SHARE * axes.T @ (inverse_definite(axes @ axes.T) @ torque)
"""
SCENARIO = """
[run]
duration = "20 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
attitude_error = ["1 deg", 0.0, "-1 deg"]
[controller]
python = "mission.py:Pointer"
kp = "20 mN·m"
kd = "0.2 N·m/(rad/s)"
weights = [[1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0]]
[sensors]
attitude_sigma = "0.003 deg"
rate_sigma = "0.002 deg/s"
[[dispersion]]
key = "controller.kp"
distribution = "normal"
sigma = "10 %"
[[dispersion]]
key = "controller.weights.1.1"
distribution = "uniform"
low = "-10 %"
high = "10 %"
"""
RUNS = 70


@pytest.fixture(scope="module")
def mission(folder, tmp_path_factory):
    """Folder with scenario.toml and its Python files."""
    made = tmp_path_factory.mktemp("mission")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        (made / name).write_text((folder / name).read_text())
    (made / "scenario.toml").write_text(SCENARIO)
    (made / "mission.py").write_text(MISSION)
    (made / "parts").mkdir()
    (made / "parts" / "allocation.py").write_text(ALLOCATION)
    (made / "parts" / "constants.py").write_text("SHARE = 1.0\n")
    return made


@pytest.fixture(scope="module")
def own(mission):
    return read_scenario(mission / "scenario.toml")


@pytest.fixture(scope="module")
def finished(own, tmp_path_factory):
    """Campaign that was interrupted after its first block and resumed from the scenario's text."""
    out = tmp_path_factory.mktemp("own-campaign")

    def stop(done, total):
        if done:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(own, out, runs=RUNS, seed=3, on_progress=stop, block=32)
    again = Scenario.from_text(json.loads((out / "campaign.json").read_text())["scenario"])
    run_campaign(again, out, runs=RUNS, seed=3, block=32, keep=[5], worst=1)
    return out


def first_torque(scenario):
    """Torque commanded after the first sample, (wheels,), N·m."""
    values = {key: np.asarray(value) for key, value in scenario.values.items()}
    # the program that has checked the scenario when it was read
    _, (_, command), *_ = plans._first_sample(structure_of(scenario), values, plans_of(scenario))
    return command.torque


def column(found, runs):
    return {name: np.asarray(values)[runs] for name, values in found.items()}


def table_of(folder):
    found = Store(folder).read_table()
    return {name: found[name].to_numpy() for name in found.column_names}


def same(one, other):
    assert one.keys() == other.keys()
    for name, values in one.items():
        np.testing.assert_array_equal(values, other[name], err_msg=name)


def test_the_files_and_what_they_import_are_part_of_the_scenario(own):
    paths = [source.path for source in own.sources]
    assert paths == ["mission.py", "parts/allocation.py", "parts/constants.py"]
    assert own.values["controller.kp"] == 0.02
    assert own.values["controller.kd"] == 0.2
    assert own.values["controller.bias.z"] == 0.0
    assert own.values["controller.weights.1.1"] == 1.5
    changed = replace(own.sources[2], text="SHARE = 0.9\n")
    assert replace(own, sources=(*own.sources[:2], changed)).digest() != own.digest()
    assert Scenario.from_text(own.text()) == own


def test_a_resumed_campaign_has_the_runs_of_one_that_was_not_interrupted(own, finished, tmp_path):
    run_campaign(own, tmp_path / "whole", runs=RUNS, seed=3, worst=1)
    same(table_of(finished), table_of(tmp_path / "whole"))
    found = table_of(finished)
    assert np.all(found["status"] == 0)
    assert np.ptp(found["controller.kp"]) > 0.0


def test_processes_and_threads_give_the_same_bits(finished):
    campaign = Store(finished).known()
    job = Job(campaign, (0, 3, 69), (), -1)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        flown = pool.submit(work, job).result().columns
    # a table has errors over time beside its numbers
    numbers = {name: values for name, values in flown.items() if values.ndim == 1}
    same(numbers, column(table_of(finished), [0, 3, 69]))
    same(work_here(job).columns, flown)


def test_both_engines_agree(own, finished):
    from gyrostat.campaigns.engine import fly

    flown = fly(own, 3, [0, 1, 69], engine="jax").columns
    for name, values in column(table_of(finished), [0, 1, 69]).items():
        np.testing.assert_allclose(flown[name], values, rtol=1e-10, atol=1e-13, err_msg=name)


def test_a_run_is_replayed_without_the_files(finished, mission, monkeypatch):
    """The campaign has the texts; what the files contain later has no effect."""
    (mission / "mission.py").rename(mission / "moved.py")
    try:
        history = gs.replay(finished, 7)
    finally:
        (mission / "moved.py").rename(mission / "mission.py")
    assert "pointed" in history
    assert history.torque.shape == (81, 4)


def test_a_changed_file_is_another_campaign(mission, finished):
    (mission / "parts" / "constants.py").write_text("SHARE = 0.9\n")
    try:
        changed = read_scenario(mission / "scenario.toml")
    finally:
        (mission / "parts" / "constants.py").write_text("SHARE = 1.0\n")
    with pytest.raises(InputError, match="found a campaign with another scenario"):
        run_campaign(changed, finished, runs=RUNS, seed=3, block=32)


def test_nothing_of_an_own_part_is_stored(own, monkeypatch):
    from gyrostat.campaigns import native

    for module in (native, plans):
        monkeypatch.setattr(module, "private_cache", lambda: pytest.fail("stored or looked up"))
    monkeypatch.setattr(native, "trace", lambda *given: pytest.fail("traced"))
    with pytest.raises(pytest.fail.Exception, match="traced"):
        native.program_of(structure_of(own), plans.plans_of.__wrapped__(own))


def test_an_own_compensator_and_estimator_wrap_the_controller(mission, own):
    wrappers = """
from typing import Any
import equinox as eqx

class Wrapper(eqx.Module):
    controller: Any
    share: float = 0.5

    def start(self, period):
        return self.controller.start(period)

    def __call__(self, memory, measurement):
        memory, command = self.controller(memory, measurement._replace(rate=measurement.rate))
        return memory, command._replace(torque=self.share * command.torque)
"""
    (mission / "wrappers.py").write_text(wrappers)
    text = SCENARIO + '[compensator]\npython = "wrappers.py:Wrapper"\nshare = 0.4\n'
    text += '[estimator]\npython = "wrappers.py:Wrapper"\nshare = 0.5\n'
    (mission / "wrapped.toml").write_text(text)
    made = first_torque(read_scenario(mission / "wrapped.toml"))
    np.testing.assert_allclose(made, 0.4 * 0.5 * first_torque(own), rtol=1e-12)


SCRIPT = """
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

import gyrostat as gs
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft import Spacecraft
from parts.constants import SHARE

print("script", __name__)
GAIN = np.array([1.0, 1.0, 1.0]) / 3.0
scenario = gs.read_scenario("scenario.toml")


class Command(NamedTuple):
    torque: jnp.ndarray


def scaled(vector):
    return 3.0 * GAIN * vector * SHARE


class Mine:
    kp: float
    kd: float = 0.2
    spacecraft: Spacecraft = None

    def start(self, period):
        return None

    def __call__(self, memory, measurement):
        q = measurement.attitude
        torque = scaled(-self.kp * 2.0 * q[1:] * jnp.sign(q[0]) - self.kd * measurement.rate)
        axes = self.spacecraft.wheels.axes
        return memory, Command(-axes.T @ (inverse_definite(axes @ axes.T) @ torque))


def mine(kp):
    made = Mine()
    made.kp = kp
    return made


made = scenario.replace(controller=mine(0.02), dispersions=scenario.dispersions[:1])
with open("script.json", "w") as file:
    file.write(made.text())
"""


def test_a_class_of_a_script_is_extracted_with_what_it_uses(mission, own):
    """The script runs once; its class, in another process, gives the command of the file's."""
    (mission / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=mission, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert (done.stdout, done.stderr) == ("script __main__\n", "")
    made = Scenario.from_text((mission / "script.json").read_text())
    assert made.controller == "script_Mine.py:Mine"
    assert [source.path for source in made.sources] == ["parts/constants.py", "script_Mine.py"]
    assert "read_scenario" not in made.sources[1].text
    plain = own.replace(**{"controller.weights": np.eye(3)})
    np.testing.assert_allclose(first_torque(made), first_torque(plain), rtol=1e-12)


def test_few_lines_beside_a_controller_fly_a_thousand_runs(monkeypatch):
    """The example has at most five, and its class can be extracted."""
    path = Path(__file__).parents[2] / "examples" / "own_controller_campaign.py"
    tree = ast.parse(path.read_text())
    beside = [
        node
        for node in tree.body[1:]  # after the docstring
        if not isinstance(node, ast.ClassDef | ast.Import | ast.ImportFrom)
    ]
    assert len(beside) + 1 <= 5  # and import gyrostat
    flown = []

    def campaign(scenario, runs, out, *, controller, force):
        flown.append((read_scenario(scenario).replace(controller=controller), runs))
        raise KeyboardInterrupt

    monkeypatch.setattr(gs, "campaign", campaign, raising=False)
    with pytest.raises(KeyboardInterrupt):
        runpy.run_path(str(path), run_name="__main__")
    ((scenario, runs),) = flown
    assert runs == 1000
    assert scenario.values["controller.kp"] == 0.004
    assert scenario.compensator == "estimating"
