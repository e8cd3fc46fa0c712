"""A plugin of pytest: a small campaign with everything in it, flown once by one worker."""

import contextlib
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
SCENARIO = """
name = "small"
[run]
duration = "30 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[start]
attitude_error = ["0.2 deg", 0.0, "-0.1 deg"]
wheel_speed = ["30 rpm", "-200 rpm", "200 rpm", "-30 rpm"]
[imbalance]
static_imbalance = "0.5 g·mm"
dynamic_imbalance = ["1 g·mm²", "2 g·mm²", 1e-9, 1e-9]
position = [[0.05, 0.05, 0.05], [-0.05, 0.05, 0.05], [-0.05, -0.05, 0.05], [0.05, -0.05, 0.05]]
[driver]
time_constant = "40 ms"
current_limit = ["10 mA", "150 mA", "150 mA", "150 mA"]
current_quantum = "0.1 mA"
[controller]
kind = "three_axis"
turn_gain = 0.4
[compensator]
kind = "friction_model"
[sensors]
attitude_sigma = "0.003 deg"
rate_sigma = "0.002 deg/s"
wheel_sigma = "2 µN·m·s"
[environment]
external_torque = ["1 µN·m", 0.0, 0.0]
[[event]]
name = "turn"
kind = "slew"
time = "18 s"
target = [1.0, 0.0, 0.0, 0.002]
[[event]]
name = "loss"
kind = "torque_lost"
wheel = "c"
time = "8 s"
detected_after = "1 s"
[[event]]
name = "worn"
kind = "friction_step"
wheel = "b"
time = "12.1 s"
factor = 3.0
coulomb = "50 µN·m"
[metrics]
after = "2 s"
boresight = [1.0, 0.0, 0.0]
crossing_window = "3 s"
[[dispersion]]
key = "wheel.*.coulomb"
distribution = "log_normal"
sigma = "30 %"
[[dispersion]]
key = "environment.external_torque.x"
distribution = "log_normal"
sigma = 4.0                # so wide that one in a hundred spins up beyond all bounds
[[dispersion]]
key = "event.loss.time"
distribution = "uniform"
low = "6 s"
high = "10 s"
[[dispersion]]
key = "wheel.a.speed"
distribution = "normal"
sigma = "20 rpm"
[[dispersion]]
key = "wheel.*.static_imbalance"
distribution = "log_normal"
sigma = 0.5
[[dispersion]]
key = "wheel.b.motor_constant"
distribution = "normal"
sigma = "2 %"
[[dispersion]]
key = "event.worn.coulomb"
distribution = "uniform"
low = "-20 %"
high = "20 %"
[[dispersion]]
key = "wheel.b.position.z"
distribution = "normal"
sigma = 0.01
[[metrics.window]]
name = "imaging"
event = "worn"
from = "1 s"
until = "6.9 s"
exposure = "1.5 s"
jitter_above = "0.1 Hz"
dwell_below = "20 rpm"
boresight = [0.0, 1.0, 0.0]
[[metrics.window]]
name = "turning"
event = "turn"
[[requirement]]
index = "APE"
level = 0.9
value = "0.2 deg"
[[requirement]]
index = "RPE"
interpretation = "temporal"
level = 0.9
value = "0.1 deg"
window = "1 s"
axis = "y"
during = ["imaging", "turning"]
[[requirement]]
index = "PDE"
interpretation = "temporal"
share = 0.5
level = 0.5
value = "0.01 arcsec"
window = "1 s"
stability = "2 s"
axis = "about"
[[requirement]]
name = "between"
index = "PRE"
interpretation = "ensemble"
level = 0.997
value = "45 deg"
window = "1 s"
axis = "full"
during = ["imaging", "turning"]
[[requirement]]
index = "AKE"
interpretation = "ensemble"
level = 0.5
value = "0.02 deg"
axis = "full"
[[dispersion]]
key = "window.imaging.from"
distribution = "uniform"
low = "0 s"
high = "2 s"
"""
SHORT = """
[run]
duration = "5 s"
control_period = "0.25 s"
[spacecraft]
file = "cubesat.toml"
[controller]
"""
RUNS, SEED = 100, 16
UNOPTIMISED = """
from gyrostat.core.jax64 import jax
jax.config.update("jax_disable_most_optimizations", True)
"""


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """The small scenario and what it names: scenario.toml, cubesat.toml, cubesat_wheel.toml."""
    made = tmp_path_factory.mktemp("scenario")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        (made / name).write_text((EXAMPLES / name).read_text())
    (made / "scenario.toml").write_text(SCENARIO)
    return made


@pytest.fixture(scope="session")
def short(folder):
    """Writes own.toml, a scenario of 20 samples, with these lines of its controller."""

    def written(controller='python = "own.py:P"', more=""):
        (folder / "own.toml").write_text(f"{SHORT}{controller}\n{more}")
        return folder / "own.toml"

    return written


@pytest.fixture(scope="session")
def scenario(folder):
    """The small scenario."""
    from gyrostat.scenario_files.scenario_file import read_scenario

    return read_scenario(folder / "scenario.toml")


@pytest.fixture(scope="session")
def small(scenario, folder, tmp_path_factory):
    """Its campaign, flown; the worker that has the compiled program; how to fly more with it."""
    from gyrostat.campaigns import Campaign, Job, Store, run_campaign
    from gyrostat.campaigns.jobs import work
    from gyrostat.codegen.simd import compiler
    from gyrostat.runs.fingerprint import FLAGS, engine_record

    out = tmp_path_factory.mktemp("campaign")
    own = "native" if compiler() else "jax"

    def campaign(engine):
        record = engine_record("cpu", FLAGS["cpu"], engine)
        return Campaign(scenario.text(), scenario.digest(), SEED, RUNS, 64, record)

    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool,
        pytest.MonkeyPatch.context() as patch,
    ):
        # with the flags of the tests XLA compiles in half the time
        patch.setitem(FLAGS, "cpu", os.environ["XLA_FLAGS"])

        def fly(*runs, keep=(), engine=own):
            runs = None if runs == (None,) else runs
            if engine != own:  # so few runs take less time than the optimisation of their program
                pool.submit(exec, UNOPTIMISED).result()
            return pool.submit(work, Job(campaign(engine), runs, keep, -1)).result()

        def opener():
            return contextlib.nullcontext(pool)

        run_campaign(scenario, out, runs=RUNS, seed=SEED, opener=opener, keep=[5], worst=1)
        yield SimpleNamespace(
            out=out,
            store=Store(out),
            campaign=campaign(own),
            fly=fly,
            pool=pool,
            opener=opener,
            runs=RUNS,
            seed=SEED,
            engine=own,
        )


@pytest.fixture
def fake_flights(monkeypatch):
    """Flights of a search that cost nothing, and the number of flights of each call.

    One in ten thousand has an error above 1 rad, by the speed of wheel a and the noise in equal
    parts.
    """
    import numpy as np
    from scipy.special import ndtri

    from gyrostat.campaigns import engine
    from gyrostat.campaigns.flown import Flown
    from gyrostat.core.threefry import threefry
    from gyrostat.scenario.metrics.results import metrics_of
    from gyrostat.search import execute

    def fake(scenario, runs, values, keys, *, keep=()):
        place = scenario.dispersed.index("wheel.a.speed")
        speed = (values[:, place] - scenario.values["wheel.a.speed"]) / (20.0 * np.pi / 30.0)
        bits = threefry(keys, np.arange(keys.shape[1])) >> np.uint64(11)
        noise = np.sum(ndtri(bits * 2.0**-53 + 2.0**-54), axis=1) / np.sqrt(keys.shape[1])
        columns = {"run": np.asarray(runs), **dict(zip(scenario.dispersed, values.T, strict=True))}
        columns |= {"status": np.zeros(len(values), np.int8), "ended": np.full(len(values), 30.0)}
        columns |= {name: np.zeros(len(values)) for name in metrics_of(scenario)}
        error = (speed + noise) / np.sqrt(2.0) + 1.0 - ndtri(1.0 - 1e-4)
        return Flown(columns | {"error_max": error, "settling": noise}, None)

    calls = []

    def counted(*given, **options):
        calls.append(len(given[1]))
        return fake(*given, **options)

    monkeypatch.setattr(engine, "fly_given", counted)
    monkeypatch.setattr(execute, "prepare", lambda *given, **options: None)
    return SimpleNamespace(calls=calls, fly=fake)
