"""Metrics of a user's Python file: columns of the table, or refused in one line."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.campaigns.engine import fly
from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SCENARIO = """
[run]
duration = "20 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
attitude_error = ["0.2 deg", 0.0, 0.0]
[controller]
kind = "three_axis"
[sensors]
attitude_sigma = "0.003 deg"
[reference]
kind = "sequence"
rate = "0.1 deg/s"
[[reference.mode]]
name = "first"
kind = "fixed"
target = [1.0, 0.0, 0.0, 0.0]
until_time = "5 s"
[[reference.mode]]
name = "second"
kind = "fixed"
target = [0.9999995, 0.0, 0.0, 0.001]
[[metrics.window]]
name = "late"
mode = "second"
from = "7 s"
[[metrics.window]]
name = "turning"
mode = "second"
until = "1 s"
boresight = [1.0, 0.0, 0.0]
exposure = "0.5 s"
[[metric]]
python = "mission.py:Blur"
weight = 3.0
[[metric]]
python = "mission.py:Count"
name = "samples"
[[dispersion]]
key = "metric.blur.weight"
distribution = "uniform"
low = 1.0
high = 5.0
"""
MISSION = """
import jax.numpy as jnp


class Blur:
    '''Weighted sum of the errors in the window.'''

    weight: float
    unit = "rad"

    def start(self):
        return jnp.zeros(()), jnp.zeros(3)

    def __call__(self, memory, sample):
        total, rate = memory
        total = total + jnp.where(sample.windows["late"], self.weight * sample.error, 0.0)
        return total, rate + sample.rate_error

    def result(self, memory):
        return memory[0]


class Count:
    def __call__(self, memory, sample):
        return memory + 1.0

    def result(self, memory):
        return jnp.where(memory > 0, memory, jnp.nan)
"""


@pytest.fixture
def mission(tmp_path):
    """Write the scenario with a change of its Python file, and read it."""

    def make(old="", new="", more="", first=""):
        for name in ("cubesat.toml", "cubesat_wheel.toml"):
            shutil.copy(EXAMPLES / name, tmp_path)
        assert old in MISSION
        text = first + (MISSION.replace(old, new, 1) if old else MISSION)
        (tmp_path / "mission.py").write_text(text)
        (tmp_path / "scenario.toml").write_text(SCENARIO + more)
        return read_scenario(tmp_path / "scenario.toml")

    return make


def test_an_own_metric_is_a_column_of_the_table(mission):
    scenario = mission()
    assert metrics_of(scenario)["blur"].unit == "rad"
    assert metrics_of(scenario)["blur"].meaning == "Weighted sum of the errors in the window."
    engine = "native" if compiler() else "jax"
    flown = fly(scenario, 3, [0, 1, 2], keep=[1], engine=engine)
    error = flown.histories.dataset().error.sel(run=1, time=slice(12.0, 20.0)).values
    weight = flown.columns["metric.blur.weight"]
    np.testing.assert_allclose(flown.columns["blur"][1], weight[1] * error.sum(), rtol=1e-12)
    np.testing.assert_array_equal(flown.columns["samples"], 81.0)
    # the second mode starts at 5 s and turns at 0.1 deg/s about z before 5.25 s
    turning = flown.histories.dataset().sel(run=1, time=slice(5.25, 6.0))
    body = Rotation.from_quat(np.roll(turning.attitude.values, -1, axis=1))
    reference = body.inv().apply(np.radians([0.0, 0.0, 0.1]))
    error = np.linalg.norm(turning.rate.values - reference, axis=1)
    np.testing.assert_allclose(flown.columns["turning.rate_error_max"][1], error.max(), rtol=1e-9)
    for name, values in fly(scenario, 3, [1], engine=engine).columns.items():
        np.testing.assert_array_equal(values, flown.columns[name][1:2], err_msg=name)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        (("def result(self, memory):\n        return memory[0]", ""), "found no method result"),
        (("return memory[0]", "return jnp.zeros(2)"), "found shape (2,) of result, expected sh"),
        (("return memory[0]", "return 'much'"), "found str as result, expected shape ()"),
        (("return total, rate +", "return rate +"), "found a memory an array of shape (3,)"),
        (("sample.rate_error", "sample.rate"), "line 17: found AttributeError"),
        (('windows["late"]', 'windows["noon"]'), "line 16: found KeyError"),
        (
            ("return jnp.zeros(()), jnp.zeros(3)", "return None"),
            "line 15: found TypeError",
        ),
    ],
)
def test_a_mistake_in_a_metric_gives_one_line(mission, change, found):
    with pytest.raises(InputError) as refused:
        mission(*change)
    message = str(refused.value)
    assert "mission.py:Blur" in message
    assert found in message
    assert "\n" not in message


@pytest.mark.parametrize("name", ["error_max", "run", "error_p95", "samples"])
def test_the_name_of_a_metric_is_no_other_column(mission, name):
    more = f'[[metric]]\npython = "mission.py:Count"\nname = "{name}"\n'
    with pytest.raises(InputError, match=f"name: found '{name}', expected"):
        mission(more=more)


def test_propellant_is_a_signal_of_the_loop(mission):
    more = '[[metrics.window]]\nname = "burn"\npropellant = "flow"\n'
    with pytest.raises(InputError, match=r"window\[burn\].propellant: found 'flow', expected a s"):
        mission(more=more)


def test_the_check_of_a_metric_is_called(mission):
    check = (
        "    def check(self):\n        raise gs.InputError('weight: found 3, expected less')\n\n"
    )
    with pytest.raises(InputError, match="weight: found 3, expected less"):
        mission(
            '    unit = "rad"\n\n    def start',
            f'    unit = "rad"\n\n{check}    def start',
            first="import gyrostat as gs\n",
        )
