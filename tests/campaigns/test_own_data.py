"""Data files of user-defined parts: their content is part of the scenario, wherever it runs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.campaigns.own import packages
from gyrostat.campaigns.scenario import Scenario
from gyrostat.core.errors import InputError
from gyrostat.core.user_data import LARGEST_DATA
from gyrostat.core.user_modules import Source

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """
[run]
duration = "4 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
attitude_error = ["2 deg", 0.0, "-1 deg"]
[controller]
python = "mission.py:PD"
data = ["weights.npz", "tables/rate.csv"]
[[dispersion]]
key = "controller.scale"
distribution = "normal"
sigma = "10 %"
"""
HEAD = """
from pathlib import Path
from typing import Any, NamedTuple
import equinox as eqx
import jax.numpy as jnp
import numpy as np

class Command(NamedTuple):
    torque: Any

"""
PD = """
class PD(eqx.Module):
    scale: float = 1.0
    spacecraft: Any = None

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        {read}
        error = 2.0 * measurement.attitude[1:] * jnp.sign(measurement.attitude[0])
        torque = self.scale * (KP * error + kd * measurement.rate)
        return memory, Command(jnp.linalg.pinv(self.spacecraft.wheels.axes) @ torque)
"""
FILES = (
    'KP = np.load(Path(__file__).parent / "weights.npz")["kp"]\n',
    'kd = np.loadtxt("tables/rate.csv", delimiter=",")',
)
NUMBERS = "KP = np.array([0.004, 0.005, 0.006])\n", "kd = np.array([0.03, 0.04, 0.05])"


def written(folder, constant, line):
    folder.mkdir(parents=True, exist_ok=True)
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder / name)
    (folder / "tables").mkdir(exist_ok=True)
    np.savez(folder / "weights.npz", kp=np.array([0.004, 0.005, 0.006]))
    (folder / "tables" / "rate.csv").write_text("0.03,0.04,0.05\n")
    (folder / "mission.py").write_text(HEAD + constant + PD.format(read=line))
    (folder / "mission.toml").write_text(SCENARIO)
    return folder / "mission.toml"


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    """A campaign of a controller that reads two files, whose folder is removed afterwards."""
    folder = tmp_path_factory.mktemp("mission")
    path = written(folder / "source", *FILES)
    scenario = gs.read_scenario(path)
    gs.campaign(scenario, 2, folder / "runs", seed=1, engine="jax", worst=0)
    shutil.rmtree(folder / "source")
    return scenario, folder / "runs"


def table(folder):
    return (folder / "runs.parquet").read_bytes()


def test_the_files_are_in_the_scenario_by_their_content(mission):
    scenario, _ = mission
    assert [source.path for source in scenario.sources] == [
        *("mission.py", "tables/rate.csv", "weights.npz")
    ]
    assert scenario.sources[1] == Source("tables/rate.csv", "0.03,0.04,0.05\n")
    assert scenario.sources[2].content.startswith(b"PK")
    again = Scenario.from_text(scenario.text())
    assert again.sources == scenario.sources
    assert again.digest() == scenario.digest()


def test_runs_are_those_of_the_same_numbers_in_the_module(mission, tmp_path):
    gs.campaign(written(tmp_path, *NUMBERS).with_name("mission.toml"), 2, tmp_path / "runs", seed=1,
                engine="jax", worst=0)  # fmt: skip
    found, expected = gs.Store(mission[1]).read_table(), gs.Store(tmp_path / "runs").read_table()
    assert found.equals(expected)


def test_workers_give_the_same_table_without_the_folder(mission, tmp_path):
    gs.campaign(mission[0], 2, tmp_path / "runs", seed=1, engine="jax", worst=0, workers=2)
    assert table(tmp_path / "runs") == table(mission[1])


def test_a_fresh_process_replays_a_run_without_the_folder(mission, tmp_path):
    shutil.copytree(mission[1], tmp_path / "runs")
    code = "import sys, gyrostat as gs; gs.replay(sys.argv[1], 1)"
    subprocess.run([sys.executable, "-c", code, tmp_path / "runs"], check=True, cwd=tmp_path)
    assert (tmp_path / "runs" / "runs" / "run_000001.nc").exists()


def test_a_changed_file_is_another_campaign(mission, tmp_path):
    path = written(tmp_path / "source", *FILES)
    np.savez(tmp_path / "source" / "weights.npz", kp=np.array([0.004, 0.005, 0.007]))
    scenario = gs.read_scenario(path)
    assert scenario.digest() != mission[0].digest()
    with pytest.raises(InputError, match="found a campaign with another scenario"):
        gs.campaign(scenario, 2, mission[1], seed=1, engine="jax", worst=0)


def test_flight_code_contains_the_numbers(mission, tmp_path):
    gs.export(mission[0], tmp_path / "files", to="c", command="test")
    numbers = gs.read_scenario(written(tmp_path / "source", *NUMBERS))
    gs.export(numbers, tmp_path / "numbers", to="c", command="test")
    names = sorted(path.name for path in (tmp_path / "files").glob("*.[ch]"))
    assert names
    for name in names:
        assert (tmp_path / "files" / name).read_text() == (tmp_path / "numbers" / name).read_text()
