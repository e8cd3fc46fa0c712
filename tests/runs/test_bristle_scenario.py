"""Scenarios of a cubesat whose wheels have bristles: read, dispersed, built and traced."""

import numpy as np
import pytest

from gyrostat.campaigns.draws import draw
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.build import build
from gyrostat.runs.designs import plan
from gyrostat.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.simulation import control_loop
from gyrostat.wheel.friction import LuGre

LUGRE = """
stiffness = 2e-3          # N·m/rad
damping = 1.2e-4          # N·m·s/rad
"""
SCENARIO = """
[run]
duration = "8 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
wheel_speed = ["1 rpm", "-200 rpm", "200 rpm", "-4 rpm"]
[controller]
kind = "three_axis"
[environment]
external_torque = ["5 µN·m", 0.0, 0.0]
[[event]]
name = "worn"
kind = "friction_step"
wheel = "b"
time = "3 s"
coulomb = "50 µN·m"
static = "60 µN·m"
stiffness = "4 mN·m/rad"
[[dispersion]]
key = "wheel.*.stiffness"
distribution = "log_normal"
sigma = 0.3
[[dispersion]]
key = "wheel.*.coulomb"
distribution = "log_normal"
sigma = "10 %"
[metrics]
after = "1 s"
"""


@pytest.fixture
def lugre(folder, tmp_path):
    """Folder with the cubesat, whose wheels have bristles, and a scenario."""
    wheel = (folder / "cubesat_wheel.toml").read_text()
    (tmp_path / "cubesat_wheel.toml").write_text(wheel.replace('"stribeck"', '"lugre"') + LUGRE)
    (tmp_path / "cubesat.toml").write_text((folder / "cubesat.toml").read_text())
    (tmp_path / "scenario.toml").write_text(SCENARIO)
    return tmp_path


def test_a_scenario_with_bristles(lugre):
    """Its plant, the dispersed values of a run, and one control period as it is traced."""
    scenario = read_scenario(lugre / "scenario.toml")
    assert Scenario.from_text(scenario.text()).digest() == scenario.digest()
    keys = [key for dispersion in scenario.dispersions for key in dispersion.keys]
    drawn, _ = draw(scenario, 1, [3])
    values = {**scenario.values, **dict(zip(keys, drawn[0], strict=True))}
    assert values["wheel.b.stiffness"] != scenario.values["wheel.b.stiffness"] == 2e-3
    plans = plan(scenario)
    setup = build(structure_of(scenario), values, plans)
    friction, steps = setup.plant.spacecraft.wheels.friction, setup.plant.friction_steps
    assert isinstance(friction, LuGre)
    own = [values[f"wheel.{w}.stiffness"] for w in scenario.wheels]
    np.testing.assert_array_equal(friction.stiffness, own)
    np.testing.assert_array_equal(steps.friction.stiffness, [own[0], 4e-3, *own[2:]])
    assert float(steps.friction.curve.coulomb[1]) == pytest.approx(50e-6, rel=1e-12)
    # a wheel of b's speed slips backwards
    bent = -values["wheel.b.coulomb"] / own[1]
    assert setup.start.deflection[1] == pytest.approx(bent, rel=1e-9)

    def period(numbers, key):
        setup = build(structure_of(scenario), dict(zip(values, numbers, strict=True)), plans)
        parts = setup.plant, setup.controller, setup.sensor, setup.start, key
        loop = control_loop(*parts, values["run.control_period"])
        return loop.tick(loop.begin(), jnp.array(0))[1].state

    state = jax.eval_shape(period, jnp.zeros(len(values)), jax.random.key(0))
    assert state.deflection.shape == (4,)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"4 mN·m/rad"', "0.0", "stiffness: found 0"),
        ("wheel.*.stiffness", "wheel.*.softness", "wheel.*.stiffness"),
    ],
)
def test_bristles_that_are_none_are_refused(lugre, old, new, message):
    path = lugre / "scenario.toml"
    path.write_text(SCENARIO.replace(old, new))
    with pytest.raises(InputError, match=message):
        read_scenario(path)
