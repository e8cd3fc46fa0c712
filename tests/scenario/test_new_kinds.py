"""A new kind of a section is one class in one file of its folder: nothing else is edited.

Each kind here is also written as a part of a user, in the same scenario: both doors lead to the
same run.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

IMPORTS = """
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple
import jax.numpy as jnp
import equinox as eqx
from gyrostat.core.arrays import Scalar
from gyrostat.core.rotations import product
from gyrostat.scenario.component import GYRO, Kind, part_named
from gyrostat.scenario.controller_kind import IGNORED, ControllerKind
from gyrostat.scenario.reference_kind import ProfileKind
from gyrostat.scenario.schema import Key, positive
"""
PARTS = """
class Command(NamedTuple):
    torque: Any
    puff: Any

class Damping(eqx.Module):
    spacecraft: Any
    gain: Any
    reference: Any = None
    def start(self, period):
        return jnp.zeros(())
    def __call__(self, memory, measurement):
        axes = jnp.asarray(self.spacecraft.wheels.axes)
        rate = measurement.rate - self.reference(0.25 * memory).rate
        torque = axes.T @ (self.gain * rate)
        return memory + 1.0, Command(torque, 1e-3 * measurement.thermometer)

class Thermometer(eqx.Module):
    slope: Any
    unit = "K"
    def start(self, state, period):
        return 290.0 + jnp.zeros(())
    def __call__(self, memory, state, key):
        return memory + self.slope, memory

class Puff(eqx.Module):
    arm: Any
    longest_step = 0.05
    def start(self):
        return jnp.zeros(())
    def advanced(self, state, value, elapsed):
        return value + (state - value) * jnp.exp(-2.0 * elapsed)
    def __call__(self, state, value, attitude, time):
        return jnp.stack([self.arm * 1e-6 * state, 0.0 * value, 0.0 * value])

class Leak(eqx.Module):
    size: Any
    def __call__(self, spacecraft, attitude, time):
        return self.size * jnp.stack([jnp.cos(0.1 * time), 0.0, 1.0])

class Turning(eqx.Module):
    rate: Any
    def __call__(self, time):
        half = 0.5 * self.rate * time
        zero = 0.0 * half
        return jnp.stack([jnp.cos(half), zero, zero, jnp.sin(half)])

class Slower(eqx.Module):
    controller: Any
    spacecraft: Any
    factor: Any
    def start(self, period):
        return self.controller.start(period)
    def __call__(self, memory, measurement):
        memory, command = self.controller(memory, measurement)
        return memory, command._replace(torque=self.factor * command.torque)
"""
KINDS = {
    "controller": '''
@dataclass(frozen=True, eq=False)
class DampingKind(ControllerKind):
    """Damping of the rate."""
    name = "damping"
    losses = IGNORED
    needs = frozenset({part_named("sensor", "thermometer"), GYRO})
    gain: Annotated[Scalar, positive("1", 0.02, "Gain.")]
    @classmethod
    def plan(cls, case):
        return case.spacecraft
    def controller(self, design, beginning):
        return Damping(design, self.gain)
''',
    "sensor": '''
@dataclass(frozen=True, eq=False)
class ThermometerKind(Kind):
    """Temperature."""
    name = "thermometer"
    unit = "K"
    slope: Annotated[Scalar, Key("1", 0.25, "Change per sample.")]
    def make(self, context):
        return Thermometer(self.slope)
''',
    "actuator": '''
@dataclass(frozen=True, eq=False)
class PuffKind(Kind):
    """Puff of gas through a valve with a lag."""
    name = "puff"
    arm: Annotated[Scalar, positive("length", 0.5, "Arm.")]
    def make(self, context):
        return Puff(self.arm)
''',
    "environment_torque": '''
@dataclass(frozen=True, eq=False)
class LeakKind(Kind):
    """Leak of gas."""
    name = "leak"
    size: Annotated[Scalar, positive("torque", 1e-5, "Size.")]
    def make(self, context):
        return Leak(self.size)
''',
    "reference": '''
@dataclass(frozen=True, eq=False)
class TurningKind(ProfileKind):
    """Turning about z."""
    name = "turning"
    rate: Annotated[Scalar, positive("speed", 0.01, "Rate.")]
    def profile(self, planned, place):
        return Turning(self.rate)
''',
    "compensator": '''
@dataclass(frozen=True, eq=False)
class SlowerKind(Kind):
    """A part of the torque."""
    name = "slower"
    factor: Annotated[Scalar, positive("1", 0.5, "Factor.", most=1.0)]
    def make(self, context):
        return Slower(context.controller, context.spacecraft, self.factor)
''',
}
SCENARIO = """
name = "new kinds"
[run]
duration = "5 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
rate = [0.01, 0.0, -0.01]
wheel_speed = ["300 rpm", "-200 rpm", "200 rpm", "-300 rpm"]
[controller]
{controller}
gain = 0.02
[compensator]
{compensator}
factor = 0.5
[[sensor]]
{sensor}
slope = 0.25
[[actuator]]
{actuator}
arm = 0.5
[environment]
torque = [{{ {environment_torque}, size = 1e-5 }}]
[reference]
{reference}
rate = 0.01
"""
OWN = {
    "controller": "Damping",
    "compensator": "Slower",
    "sensor": 'Thermometer"\nname = "thermometer',
    "actuator": 'Puff"\nname = "puff',
    "environment_torque": 'Leak", name = "leak',
    "reference": "Turning",
}
SIGNALS = ("attitude", "wheel_speed", "actuator_puff")
SCRIPT = """
import importlib, json, sys
import numpy as np
for section in {sections!r}:
    folder = importlib.import_module(f"gyrostat.scenario.kinds.{{section}}")
    folder.__path__.append(f"{root}/{{section}}")
from gyrostat.core.errors import InputError
import gyrostat as gs
found = {{}}
for name in ("kinds", "own"):
    run = gs.simulate(gs.read_scenario(f"{root}/{{name}}.toml"))
    found[name] = {{key: np.asarray(run[key]).tolist() for key in {signals!r}}}
from gyrostat.scenario.kinds.registry import KINDS, PARTS
found["named"] = [*KINDS["controller"], *PARTS["reference.mode"]]
try:
    gs.read_scenario(f"{root}/lacking.toml")
except InputError as error:
    found["error"] = str(error)
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def found(folder, tmp_path_factory):
    """What a new process finds whose folders of kinds have one file more."""
    root = tmp_path_factory.mktemp("kinds")
    for name in folder.iterdir():
        if name.suffix == ".toml":
            (root / name.name).write_text(name.read_text())
    for section, text in KINDS.items():
        (root / section).mkdir()
        (root / section / "new.py").write_text(f'"""New kind."""\n{IMPORTS}{PARTS}{text}')
    (root / "mine.py").write_text(f"{IMPORTS}{_with_fields(PARTS)}")
    named = ("damping", "slower", "thermometer", "puff", "leak", "turning")
    names = dict(zip(OWN, named, strict=True))
    shipped = {section: f'kind = "{name}"' for section, name in names.items()}
    own = {section: f'python = "mine.py:{name}"' for section, name in OWN.items()}
    (root / "kinds.toml").write_text(SCENARIO.format(**shipped))
    (root / "own.toml").write_text(SCENARIO.format(**own))
    lacking = SCENARIO.format(**shipped).replace("slope = 0.25", 'name = "other"')
    (root / "lacking.toml").write_text(lacking)
    script = SCRIPT.format(sections=[*KINDS], root=root, signals=SIGNALS)
    path = os.pathsep.join(
        filter(None, [str(Path(__file__).parents[2] / "src"), os.environ.get("PYTHONPATH")])
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def _with_fields(parts):
    """Parts whose numbers are keys."""
    for name in ("gain", "slope", "arm", "size", "rate", "factor"):
        parts = parts.replace(f"    {name}: Any\n", f"    {name}: float\n")
    return parts


def test_a_new_kind_flies_as_the_same_part_of_a_user(found):
    for name in SIGNALS:
        assert found["kinds"][name] == found["own"][name]
    assert max(found["own"]["actuator_puff"]) > 0.2


def test_a_new_reference_is_a_mode_too(found):
    assert {"damping", "turning"} <= {*found["named"]}


def test_a_new_kind_names_what_it_needs(found):
    assert found["error"].endswith(
        "key controller: found damping without thermometer, expected a [[sensor]] named thermometer"
    )
