"""Metric `jitter`: against the motion computed in NumPy at the wheel speeds that were flown."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.jax64 import jax
from gyrostat.microvibration.disturbance_file import read_structure
from gyrostat.microvibration.sight import line_of_sight
from gyrostat.microvibration.sight_table import ERROR, sight_table
from gyrostat.microvibration.structure_text import structure_from, structure_text
from gyrostat.scenario.kinds.metric.jitter import JitterTable
from gyrostat.scenario_files import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
RPM = np.pi / 30.0
DISTURBANCE = """
[[harmonic]]
number = 1.0
forward = { force = 1e-6, torque = 3e-8 }
[[harmonic]]
number = 2.0
forward = { force = 4e-7 }
backward = { torque = 3e-8 }
[mode.torque]
frequency = "75 Hz"
damping = 0.015
inertia_ratio = 1.7
[noise.axial]
density = 1e-9
exponent = 2.0
reference = "3000 rpm"
"""
MODES = """frequency_Hz,damping,Fx,Fy,Fz,Tx,Ty,Tz,los_x,los_y
0,0.01,0.05,0,0,0,0,0,0.004,0
30,0.005,0.05,0,0.02,0,0.3,0.1,0.04,0.01
31,0.005,0,0.06,0.03,0.4,0,0.2,0.01,0.05
"""
SIGHT = """disturbance = "disturbance.toml"
transfer = "modes.csv"
exposure = "20 ms"
speeds = ["100 rpm", "3000 rpm"]
"""
AXES = ([1, 1, 1], [1, -1, -1], [-1, -1, 1], [1, -1, 1])  # that of wheel b is the opposite one
SENSES = np.array([1.0, -1.0, 1.0, 1.0])
SCENARIO = """
[run]
duration = "20 s"
control_period = "0.5 s"
[spacecraft]
file = "cubesat.toml"
[start]
wheel_speed = ["1932 rpm", "-1000 rpm", "905 rpm", "-930 rpm"]
[controller]
kind = "three_axis"
target = [0.9998, 0.02, 0.0, 0.0]
[[metrics.window]]
name = "early"
from = "2 s"
until = "5 s"
[[metrics.window]]
name = "late"
from = "9 s"
until = "15 s"
[[metric]]
kind = "jitter"
file = "sight.toml"
window = ["early", "late"]
[[metric]]
name = "whole"
kind = "jitter"
file = "sight.toml"
scale = 2.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("jitter")
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        shutil.copy(EXAMPLES / name, folder)
    wheels = "".join(f"[[wheel]]\naxis = {axis}\nposition = [0.1, 0, 0.05]\n" for axis in AXES)
    files = {"disturbance.toml": DISTURBANCE, "modes.csv": MODES, "sight.toml": SIGHT + wheels}
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def written(folder, changes=(), more=""):
    text = SCENARIO + more
    for was, now in dict(changes).items():
        assert was in text
        text = text.replace(was, now)
    path = folder / "scenario.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def flown(folder):
    return gs.simulate(written(folder), engine="native")


def squares(folder, speed):
    """Mean square of smear and jitter at wheel speeds, (samples,), without any table."""
    structure = read_structure(folder / "sight.toml")
    few = np.linspace(*structure.speeds, 40)  # between which noise is linear, as documented
    noisy, turned = line_of_sight(structure.wheels, structure.transfer, few, structure.exposure), []
    for k, each in enumerate((speed * SENSES).T):
        size = np.abs(each)
        motion = line_of_sight(
            structure.wheels, structure.transfer, np.append(size, 3000 * RPM), structure.exposure
        )
        tones = [
            0.5 * np.sum(w.amplitude**2 * _counted(w.frequency, 0.02), axis=(0, 1))[:-1]
            for w in (motion.wheels[k], motion.reverse[k])
        ]
        noise = [
            np.interp(size, few, np.sum(w.noise["smear"] + w.noise["jitter"], axis=0))
            for w in (noisy.wheels[k], noisy.reverse[k])
        ]
        turned.append(np.where(each < 0.0, tones[1] + noise[1], tones[0] + noise[0]))
    return np.sum(turned, axis=0)


def _counted(frequency, exposure):
    """Share of a sine's mean square about its mean over an exposure: 1 - sinc²."""
    return 1.0 - np.sinc(0.5 * frequency * exposure / np.pi)[:, None] ** 2


def test_the_metric_is_the_motion_at_the_speeds_that_were_flown(folder, flown):
    speed, time = np.asarray(flown["wheel_speed"]), 0.5 * np.arange(41)
    square = squares(folder, speed)
    inside = ((time >= 2.0) & (time <= 5.0)) | ((time >= 9.0) & (time <= 15.0))
    # wheel a passes 1800 rpm, where its first harmonic meets the mode at 30 Hz
    assert speed[:, 0].min() < 1800 * RPM < speed[:, 0].max()
    assert np.max(square) > 20.0 * np.min(square)
    # the engine evaluates the table as JAX does
    table = JitterTable(sight_table(read_structure(folder / "sight.toml")), SENSES)
    by_jax = np.asarray(jax.jit(jax.vmap(table))(speed))
    for tolerance, values in ((0.5 * ERROR, square), (1e-10, by_jax)):
        for name, wanted in (("jitter", values[inside]), ("whole", 4.0 * values)):
            expected = pytest.approx(np.sqrt(np.mean(wanted)), rel=tolerance)
            assert flown.attrs[name] == expected


def test_a_speed_that_dwells_at_a_resonance_is_as_exact(folder):
    """At and beside each resonance of the structure and of the rocking mode, in both senses."""
    structure = read_structure(folder / "sight.toml")
    table = JitterTable(sight_table(structure), SENSES)
    rocking = 4500 / np.sqrt([1.0 * 2.7, 2.0 * 0.3, 2.0 * 3.7])
    centres = np.array([900.0, 930.0, 1800.0, 1860.0, *rocking[rocking < 3000.0]])
    tried = (centres * (1.0 + np.array([0.0, 0.0017, -0.005, 0.013])[:, None])).ravel() * RPM
    speed = np.stack([tried, -tried, tried[::-1], np.full_like(tried, 60.0)], axis=1)
    speed = np.concatenate([speed, -speed])
    found = np.array([float(table(each)) for each in speed])
    np.testing.assert_allclose(found, squares(folder, speed), rtol=ERROR)


def test_speeds_beside_those_of_the_structure(folder):
    table = JitterTable(sight_table(read_structure(folder / "sight.toml")), SENSES)
    lowest, slow = (float(table(np.full(4, rpm * RPM))) for rpm in (100.0, 20.0))
    assert slow == lowest > 0.0
    assert np.isnan(float(table(np.array([10.0, 10.0, 3001 * RPM, 10.0]))))
    assert float(table(np.full(4, 3000 * RPM))) > lowest


def test_a_frequency_response_counts_inside_its_frequencies_only(folder):
    structure = read_structure(folder / "sight.toml")
    frequency = np.linspace(10.0, 60.0, 251)
    response = gs.microvibration.FrequencyResponse(
        frequency, structure.transfer.at(frequency, 0)[:, None]
    )
    wheels = structure.wheels
    limited = replace(structure, transfer=response)
    again = structure_from(structure_text(limited))
    for one, other in zip(sight_table(limited), sight_table(again), strict=True):
        np.testing.assert_array_equal(one, other)
    table = JitterTable(sight_table(again), SENSES)
    for rpm in (700.0, 901.0, 1795.0, 2950.0):
        exact = line_of_sight(wheels, response, np.array([rpm * RPM]), 0.02)
        part = exact.mean_squares()[0, :, 0].sum()
        assert float(table(rpm * RPM * SENSES)) == pytest.approx(part, rel=5e-3)
    # below 300 rpm both harmonics are below the lowest frequency
    quiet = [replace(w, disturbance=replace(w.disturbance, noise={})) for w in wheels]
    silent = JitterTable(sight_table(replace(again, wheels=quiet)), SENSES)
    assert float(silent(299.0 * RPM * SENSES)) == 0.0
    assert float(silent(305.0 * RPM * SENSES)) > 0.0


def test_dispersed_runs_have_the_metric_of_their_own_speeds(folder, tmp_path):
    more = '[[dispersion]]\nkey = "wheel.*.speed"\ndistribution = "normal"\nsigma = "40 rpm"\n'
    more += '[[dispersion]]\nkey = "metric.jitter.scale"\ndistribution = "uniform"\n'
    more += "low = 0.5\nhigh = 1.5\n"
    path = written(folder, more=more)
    out = tmp_path / "out"
    table = gs.campaign(path, runs=6, seed=3, out=out, keep=range(6))
    time = 0.5 * np.arange(41)
    inside = ((time >= 2.0) & (time <= 5.0)) | ((time >= 9.0) & (time <= 15.0))
    for k in range(6):
        speed = np.asarray(gs.replay(out, k)["wheel_speed"])
        square = squares(folder, speed)[inside]
        scale = float(table["metric.jitter.scale"][k])
        wanted = scale * np.sqrt(np.mean(square))
        assert float(table["jitter"][k]) == pytest.approx(wanted, rel=0.5 * ERROR)
    assert len(np.unique(np.round(np.asarray(table["jitter"]), 12))) == 6


def test_a_run_that_is_too_fast_has_no_value_and_says_so(folder):
    said = []
    path = written(folder, {'"1932 rpm"': '"3300 rpm"'})
    run = gs.simulate(path, engine="native", say=said.append)
    assert np.isnan(run.attrs["jitter"])
    assert any("metric.jitter: found no value: a wheel is faster than 3000 rpm" in x for x in said)
    (line,) = [x for x in gs.check(path).warnings if "metric.jitter" in x]
    assert "found `speeds` up to 3000 rpm, expected the" in line


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({'["early", "late"]': '"lat"'}, "found 'lat', expected one of early, late"),
        ({'file = "sight.toml"\nscale': "scale"}, "file"),
        ({'"sight.toml"\nscale': '"other.toml"\nscale'}, "other.toml"),
        ({'kind = "jitter"\nfile = "sight.toml"\nscale = 2.0\n': ""}, 'or kind = "jitter"'),
        ({"scale = 2.0": "scale = 0"}, "scale"),
        ({'kind = "jitter"\nfile': 'kind = "gitter"\nfile'}, "expected one of jitter"),
    ],
)
def test_a_metric_that_cannot_be_used_is_one_line(folder, run, changes, message):
    code, _, said = run("check", written(folder, changes))
    assert code == 2
    (line,) = said.splitlines()
    assert message in line


def test_other_wheels_and_windows_are_refused(folder):
    scenario = read_scenario(written(folder))
    with pytest.raises(gs.InputError, match=r"metric\.jitter\.window: found 'early'"):
        scenario.replace(windows={"other": {"from": 1.0}})
    text = (folder / "sight.toml").read_text()
    (folder / "three.toml").write_text(text.rpartition("[[wheel]]")[0])
    with pytest.raises(gs.InputError, match=r"whole\.file: key wheel: found 3 wheels"):
        read_scenario(written(folder, {'"sight.toml"\nscale': '"three.toml"\nscale'}))
