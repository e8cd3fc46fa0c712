"""Own torques, sensors, actuators and events in a campaign, and every mistake in one line."""

import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import equinox as eqx
import numpy as np
import pytest

from gyrostat.campaigns import Store, run_campaign
from gyrostat.campaigns import replay as fly_again
from gyrostat.campaigns.cluster import cluster
from gyrostat.campaigns.engine import fly
from gyrostat.campaigns.executors import threads
from gyrostat.campaigns.jobs import work_here
from gyrostat.codegen.simd import compiler
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
FIELD = """import jax.numpy as jnp

from gyrostat.core.rotations import to_body


def magnetic(attitude):
    return to_body(attitude, jnp.array([2e-5, 0.0, 1e-5]))
"""
PYTHON = '''"""Parts of a mission."""

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp

from gyrostat.core.arrays import Vector3
from gyrostat.core.rotations import conjugate, product, to_body
from world.field import magnetic


class Turning(eqx.Module):
    rate: float = 2e-3

    def __call__(self, time):
        half = 0.5 * self.rate * time
        return jnp.stack([jnp.cos(half), 0.0 * half, 0.0 * half, jnp.sin(half)])


class Wobble(eqx.Module):
    weight: float = 1.0
    unit = "rad/s"

    def start(self):
        return jnp.zeros(2)

    def __call__(self, memory, sample):
        rate = jnp.linalg.norm(sample.rate_error)
        return memory + jnp.stack([self.weight * rate, 1.0])

    def result(self, memory):
        return memory[0] / memory[1]


class Command(NamedTuple):
    torque: Any
    rods: Any


class Pointer(eqx.Module):
    spacecraft: Any
    reference: Any
    kp: float = 0.02
    kd: float = 0.2

    def start(self, period):
        return jnp.zeros(3)

    def __call__(self, memory, measurement):
        target = self.reference(measurement.time)
        turn = product(conjugate(target.attitude), measurement.attitude)
        error = 2.0 * turn[1:] * jnp.sign(turn[0])
        torque = -self.kp * error - self.kd * (measurement.rate - target.rate)
        rods = -0.1 * measurement.field * jnp.cos(0.1 * measurement.time)
        return memory, Command(-0.75 * self.spacecraft.wheels.axes.T @ torque, rods)


class Drag(eqx.Module):
    area: float
    arm: Vector3 = (0.0, 0.1, 0.0)

    def __call__(self, spacecraft, attitude, time):
        flow = jnp.stack([jnp.cos(0.1 * time), jnp.sin(0.1 * time), 0.0 * time])
        return jnp.cross(self.arm, -1e-5 * self.area * to_body(attitude, flow))


def push(spacecraft, attitude, time):
    return jnp.array([1e-7, 0.0, 0.0])


class Magnetometer(eqx.Module):
    plant: Any
    sigma: float = 1e-7
    unit = "T"

    def start(self, state, period):
        return jax.random.PRNGKey(4)

    def __call__(self, memory, state, key):
        memory, drift = jax.random.split(memory)
        own = 1e-8 * jax.random.normal(drift, (3,))
        noise = own + self.sigma * jax.random.normal(key, (3,))
        return memory, magnetic(state.attitude) + noise


class Rods(eqx.Module):
    gain: float = 1.0
    longest_step = 0.02

    def start(self):
        return jnp.zeros(3)

    def advanced(self, state, value, elapsed):
        return value + (state - value) * jnp.exp(-elapsed / 0.1)

    def __call__(self, state, value, attitude, time):
        return jnp.cross(self.gain * state, magnetic(attitude))


class Boom(eqx.Module):
    factor: float = 1.2

    def __call__(self, plant):
        inertia = self.factor * plant.spacecraft.inertia
        return eqx.tree_at(lambda p: p.spacecraft.inertia, plant, inertia)
'''
SCENARIO = """
name = "own world"
[run]
duration = "12 s"
control_period = "0.25 s"
command_delay = 1
[spacecraft]
file = "cubesat.toml"
[start]
attitude_error = ["0.2 deg", 0.0, "-0.1 deg"]
wheel_speed = ["30 rpm", "-200 rpm", "200 rpm", "-30 rpm"]
[controller]
python = "mission.py:Pointer"
[sensors]
attitude_sigma = "0.003 deg"
[environment]
external_torque = [1e-7, 0.0, 0.0]
[[environment.torque]]
python = "mission.py:Drag"
area = 0.6
[[environment.torque]]
python = "mission.py:push"
[[environment.torque]]
kind = "harmonic"
rate = "0.2 rad/s"
sine = ["1 µN·m", 0.0, 0.0]
[reference]
python = "mission.py:Turning"
rate = "0.1 deg/s"
[[metric]]
python = "mission.py:Wobble"
[[sensor]]
python = "mission.py:Magnetometer"
name = "field"
[[actuator]]
python = "mission.py:Rods"
[[event]]
name = "boom"
python = "mission.py:Boom"
time = "7.13 s"
[[event]]
name = "blind"
kind = "sensor_spike"
sensor = "field"
time = "4 s"
until = "5 s"
magnitude = 1e-3
[guard]
field_upper = 5e-4
[[dispersion]]
key = "environment.torque.drag.area"
distribution = "uniform"
low = "-20 %"
high = "20 %"
[[dispersion]]
key = "environment.torque.drag.arm.y"
distribution = "normal"
sigma = "10 %"
[[dispersion]]
key = "event.boom.time"
distribution = "uniform"
low = "6 s"
high = "9 s"
[[dispersion]]
key = "sensor.field.sigma"
distribution = "log_normal"
sigma = 0.3
[[dispersion]]
key = "reference.rate"
distribution = "normal"
sigma = "10 %"
[[dispersion]]
key = "actuator.rods.gain"
distribution = "normal"
sigma = "5 %"
"""
RUNS, SEED, BLOCK = 24, 5, 8
KILLED = """
import os, sys
from pathlib import Path
from gyrostat.campaigns import run_campaign
from gyrostat.scenario_files.scenario_file import read_scenario
if __name__ == "__main__":
    folder, out, runs, seed, block = sys.argv[1:]
    run_campaign(
        read_scenario(folder + "/mission.toml"), Path(out), runs=int(runs), seed=int(seed),
        engine="native", block=int(block), worst=0,
        on_progress=lambda done, total: os.kill(os.getpid(), 9) if done else None,
    )
"""
# With a command delay, every trial traces the motion of the plant three times as often.
PROMPT = SCENARIO.replace("command_delay = 1\n", "")
native = pytest.mark.skipif(compiler() is None, reason="needs a C compiler")


def written(folder, scenario=SCENARIO, python=PYTHON):
    """Folder with a scenario and what it names."""
    (folder / "world").mkdir(exist_ok=True)
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder / name)
    (folder / "mission.toml").write_text(scenario)
    (folder / "mission.py").write_text(python)
    (folder / "world" / "field.py").write_text(FIELD)
    return folder


@pytest.fixture(scope="module")
def mission(tmp_path_factory):
    """The scenario, after its files were deleted; and the folder of a campaign killed before."""
    folder, out = (tmp_path_factory.mktemp(name) for name in ("mission", "killed"))
    written(folder)
    found = read_scenario(folder / "mission.toml")
    if compiler() is not None:
        script = folder / "killed.py"
        script.write_text(KILLED)
        words = [sys.executable, script, folder, out, RUNS, SEED, BLOCK]
        done = subprocess.run(list(map(str, words)), capture_output=True, text=True, timeout=300)
        assert done.returncode == -signal.SIGKILL, done.stderr
    shutil.rmtree(folder)
    return found, out


@pytest.fixture(scope="module")
def flown(mission, tmp_path_factory):
    """Store of the campaign, undisturbed."""
    out = tmp_path_factory.mktemp("flown")
    options = {"engine": "native", "block": BLOCK, "worst": 0, "keep": [5]}
    run_campaign(mission[0], out, runs=RUNS, seed=SEED, **options)
    return Store(out)


def columns(store):
    """Columns of the table of runs."""
    table = store.read_table()
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


@native
def test_killed_and_resumed_without_the_files_it_gives_the_same_bytes(mission, flown):
    scenario, out = mission
    assert 1 <= len(list(out.glob("blocks/0*.parquet"))) < RUNS // BLOCK
    run_campaign(scenario, out, runs=RUNS, seed=SEED, engine="native", block=BLOCK, worst=0)
    assert (out / "runs.parquet").read_bytes() == flown.table.read_bytes()


@native
def test_a_run_is_replayed_bit_for_bit_from_the_content_of_the_campaign(flown):
    # replay refuses results that differ in the last bit
    fly_again(flown, flown.known(), [3, 5], lambda: threads(1)(), work_here)


@native
def test_both_engines_agree(mission, flown):
    table = columns(flown)
    found = fly(mission[0], SEED, np.arange(RUNS), engine="jax").columns
    found = {name: own for name, own in found.items() if own.ndim == 1}
    assert set(found) == set(table)
    for name, own in found.items():
        np.testing.assert_allclose(own, table[name], rtol=1e-10, atol=1e-12, err_msg=name)
    assert np.all(found["status"] == 0)
    assert np.unique(found["environment.torque.drag.area"]).size == RUNS
    assert np.unique(found["error_end"]).size == RUNS
    assert np.unique(found["wobble"]).size == RUNS


@native
def test_dask_gives_the_same_bytes(mission, flown, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    ) as workers:
        opener = cluster(workers.scheduler_address)
        options = {"engine": "native", "block": BLOCK, "worst": 0, "opener": opener}
        run_campaign(mission[0], tmp_path, runs=RUNS, seed=SEED, **options)
    assert (tmp_path / "runs.parquet").read_bytes() == flown.table.read_bytes()


@native
def test_histories_show_what_the_parts_do(mission, flown):
    import xarray as xr

    with xr.open_dataset(flown.history(5), engine="h5netcdf") as found:
        history = found.load()
    assert history.field.attrs["units"] == "T"
    rate = columns(flown)["reference.rate"][5]
    time, sample = history.time.values, history.sample_status.values
    rejected = (time >= 4.0) & (time < 5.0)
    np.testing.assert_array_equal(sample == 3, rejected)
    turned = np.where(rejected, time[np.argmax(rejected) - 1], time)
    np.testing.assert_allclose(history.target.values[:, 3], np.sin(0.5 * rate * turned))
    # the boom slows the body down at its time, and leaves the momentum alone
    boom = columns(flown)["event.boom.time"][5]
    late = np.argmax(time > boom)
    jump = np.linalg.norm(np.diff(history.rate.values, axis=0), axis=1)
    assert jump[late - 1] > 3.0 * np.median(jump[late + 1 :])
    # commands to an own actuator are delayed as those to the wheels
    np.testing.assert_array_equal(history.rods.values[0], 0.0)
    expected = -0.1 * history.field.values[:10] * np.cos(0.1 * time[:10, None])
    np.testing.assert_allclose(history.rods.values[1:11], expected, rtol=1e-12)
    # the event divides a control period, and the lag goes on
    value, state = history.rods.values[:-1], history.actuator_rods.values
    np.testing.assert_allclose(state[1:], value + (state[:-1] - value) * np.exp(-2.5), rtol=1e-12)


def test_the_text_of_a_scenario_restores_its_parts(mission):
    scenario = mission[0]
    copy = Scenario.from_text(scenario.text())
    assert copy == scenario
    assert [part.name for part in copy.parts] == [
        "drag",
        "push",
        "harmonic",
        "field",
        "rods",
        "wobble",
    ]
    assert [source.path for source in copy.sources] == ["mission.py", "world/field.py"]


class Breeze(eqx.Module):
    """A torque of a user, as an object."""

    size: float = 1e-6

    def __call__(self, spacecraft, attitude, time):
        return self.size * jnp.array([1.0, 0.0, 0.0])


class Heavier(eqx.Module):
    """An event of a user, as an object."""

    def __call__(self, plant):
        return eqx.tree_at(lambda p: p.spacecraft.inertia, plant, 2.0 * plant.spacecraft.inertia)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A scenario with parts of this package only."""
    folder = tmp_path_factory.mktemp("plain")
    text = PROMPT[: PROMPT.index("[[environment.torque]]")]
    text = text.replace('python = "mission.py:Pointer"', 'kind = "three_axis"')
    return read_scenario(written(folder, text) / "mission.toml")


def test_objects_replace_the_lists(plain):
    wind = {"breeze": Breeze(), "gust": Breeze(3e-6)}
    found = plain.replace(environment=wind, event={"boom": (3.3, Heavier())})
    assert [part.name for part in found.parts] == ["breeze", "gust"]
    assert found.values["environment.torque.gust.size"] == 3e-6
    assert found.values["event.boom.time"] == 3.3
    assert found.values["environment.external_torque.x"] == 1e-7
    assert found.replace(environment=(), event={}) == plain
    again = found.replace(**{"environment.torque.gust.size": "2 µN·m"})
    assert again.values["environment.torque.gust.size"] == pytest.approx(2e-6)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"environment": Breeze()},
            r"environment: found Breeze, expected a tuple, \(Breeze\(...\)",
        ),
        ({"environment": (Breeze(), Breeze())}, r"name: found 'breeze', expected another name"),
        ({"environment": {"a.b": Breeze()}}, r"found 'a.b', expected letters, digits"),
        ({"event": {"boom": Heavier()}}, r"expected \(time, object\)"),
        ({"event": (Heavier(),)}, r'event: found tuple, expected {"name": \(time, object\)}'),
        ({"event": {"boom": (99.0, Heavier())}}, r"key event.boom.time: found 99"),
    ],
)
def test_objects_that_are_no_lists_are_refused(plain, changes, message):
    with pytest.raises(InputError, match=message):
        plain.replace(**changes)


HEAD = PROMPT[: PROMPT.index("[controller]")]


@pytest.mark.parametrize("actuator", ["Rods", "LaggingRods"])
def test_the_examples_of_the_page_fly_together(tmp_path, actuator):
    page = (Path(__file__).parents[2] / "docs" / "your_own_plant_parts.md").read_text(
        encoding="utf-8"
    )
    page = page[page.index("## Environment torques") :]

    def code(language):
        return "\n".join(re.findall(rf"```{language}\n(.*?)```", page, flags=re.DOTALL))

    scenario = HEAD + code("toml").replace("py:Rods", f'py:{actuator}"\nname = "rods')
    path = written(tmp_path, scenario, code("python")) / "mission.toml"
    found = read_scenario(path)  # calls every part
    names = [part.name for part in found.parts]
    assert names == ["drag", "gravity_gradient", "field", "rods", "sun_in_baffle"]
    assert found.dispersed == ("environment.torque.drag.area",)


def line(text):
    """Number of a line of the mission."""
    return PYTHON[: PYTHON.index(text)].count("\n") + 1


CROSS = "return jnp.cross(self.arm, -1e-5 * self.area * to_body(attitude, flow))"
CHANGED = "return eqx.tree_at(lambda p: p.spacecraft.inertia, plant, inertia)"
SEEN = "return memory, magnetic(state.attitude) + noise"
ADVANCED = "return value + (state - value) * jnp.exp(-elapsed / 0.1)"
DRAG, RODS = r"environment.torque.drag mission.py:Drag", "actuator.rods mission.py:Rods"
BOOM, MAGNETOMETER = r"event.boom mission.py:Boom", r"sensor.field mission.py:Magnetometer"


# Without what no mistake in Python is about: each part is traced several times for each mistake.
BOOM_TABLE = PROMPT[PROMPT.index("[[event]]") : PROMPT.index('[[event]]\nname = "blind"')]
LEAN = PROMPT[: PROMPT.index("[[event]]")].replace('[[metric]]\npython = "mission.py:Wobble"\n', "")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            CROSS,
            "return flow[:2]",
            rf"{DRAG}: found shape \(2,\) of torque.* expected shape \(3,\)",
        ),
        (CROSS, "pass", rf"{DRAG}: found NoneType as torque"),
        (CROSS, "return jnp.nan * flow", rf"{DRAG}: found the torque \[nan nan nan\] at the first"),
        (
            CROSS,
            "return flow if time > 3.0 else -flow",
            rf"{DRAG}, line {line(CROSS)}: found if.*jnp.where",
        ),
        (CROSS, "return 1 / 0", rf"{DRAG}, line {line(CROSS)}: found ZeroDivisionError"),
        ("    longest_step = 0.02\n", "", f"{RODS}: found no longest_step, expected it: the long"),
        (
            "longest_step = 0.02",
            "longest_step = 0.0",
            f"{RODS}: longest_step: found 0, expected a finite",
        ),
        ("advanced(", "after(", r"py:Rods: found no method advanced, expected advanced\(state, v"),
        (
            ADVANCED,
            "return state[:2]",
            rf"{RODS}: found memory of shape \(2,\)",
        ),
        (ADVANCED, "return state + value", rf"{RODS}: found the state .* after two times in turn"),
        (ADVANCED, "return value", rf"{RODS}: found the state .* after no time or after"),
        ("area: float", "area: str = 'big'", r"Drag: found area = 'big', expected a number"),
        (CHANGED, "return None", r"event boom: found a result of type NoneType, expected the Gyro"),
        (CHANGED, "return plant.x", rf"{BOOM}, line {line(CHANGED)}: found AttributeError"),
        (
            CHANGED,
            "import dataclasses; return dataclasses.replace(plant, environment=())",
            "event boom: found a plant of another structure",
        ),
        (
            "self.factor * plant.spacecraft.inertia",
            "-plant.spacecraft.inertia",
            "event boom: body inertia: found the principal inertia",
        ),
        (SEEN, "return 1.0", rf"{MAGNETOMETER}: found float as result, expected \(memory, value\)"),
        (SEEN, "return memory, 'warm'", rf"{MAGNETOMETER}: found str as value, expected numbers"),
        (
            SEEN,
            "return jnp.zeros(3), 1.0",
            rf"{MAGNETOMETER}: found memory of shape \(3,\) and type float64, expected \(2,\)",
        ),
        ("def start(self, state", "def begin(self, state", "found no method start, expected start"),
        (
            "return jnp.cross(self.gain * state, magnetic(attitude))",
            "return value[0]",
            r"actuator.rods mission.py:Rods: found shape \(\) of torque",
        ),
        ("rods: Any", "coils: Any", "actuator rods: found a command.*expected the field rods"),
    ],
)
def test_mistakes_in_python_are_one_line(tmp_path, old, new, message):
    assert old in PYTHON
    is_event = "event" in message or message.startswith(BOOM)
    scenario = LEAN + BOOM_TABLE if is_event else LEAN
    path = written(tmp_path, scenario, PYTHON.replace(old, new)) / "mission.toml"
    with pytest.raises(InputError, match=message) as caught:
        read_scenario(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_mistake_in_a_scenario_with_a_command_delay_is_one_line(tmp_path):
    """The plant is traced first where the delay line is made."""
    path = written(tmp_path, python=PYTHON.replace(CROSS, "return flow[:2]")) / "mission.toml"
    with pytest.raises(InputError, match=rf"{DRAG}: found shape \(2,\) of torque") as caught:
        read_scenario(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'name = "field"',
            'name = "rate"',
            r"sensor\[0\].name: found 'rate', expected none of att",
        ),
        (
            'name = "field"',
            'name = "time"',
            r"sensor\[0\].name: found 'time', expected none of att",
        ),
        (
            'name = "field"',
            'name = "wheel_x"',
            r"'wheel_x', expected a name that does not begin with wheel_",
        ),
        (
            '"mission.py:Rods"',
            '"mission.py:Rods"\nname = "torque"',
            "found 'torque', expected none",
        ),
        (
            '"mission.py:push"',
            '"mission.py:push"\nname = "drag"',
            r"torque\[1\].name: found 'drag'",
        ),
        ('"mission.py:push"', '"mission.py:push"\nname = "a.b"', "found 'a.b', expected letters"),
        ('"mission.py:push"', '"mission.py:push"\nname = "if"', "found 'if', expected letters"),
        (
            'kind = "harmonic"',
            'kind = "storm"',
            "found 'storm', expected one of aerodynamic, constant, gravity",
        ),
        ("area = 0.6", "aera = 0.6", r"torque\[drag\].aera.*did you mean.*area"),
        ('python = "mission.py:Rods"', 'kind = "rods"', "expected one of thrusters, torque_rods"),
        ("[[sensor]]", "[sensor]", r"found a table \[sensor\], expected \[sensors\], or tables"),
        ('time = "7.13 s"\n', "", r"key event\[boom\].time: found none"),
        ('time = "7.13 s"\n', 'time = "70 s"\n', r"key event.boom.time: found 70"),
        ('sensor = "field"', 'sensor = "filed"', "found 'filed', expected one of attitude.*field"),
        ("drag.area", "drag.aria", "did you mean environment.torque.drag.area"),
        ("field_upper = 5e-4", "filed_upper = 5e-4", "did you mean guard.field_upper"),
        ("mission.py:Magnetometer", "mission.py:magnetic", "found a function, expected a class"),
    ],
)
def test_mistakes_in_the_file_are_one_line(tmp_path, old, new, message):
    assert old in SCENARIO
    with pytest.raises(InputError, match=message) as caught:
        read_scenario(written(tmp_path, SCENARIO.replace(old, new)) / "mission.toml")
    assert "\n" not in str(caught.value)
