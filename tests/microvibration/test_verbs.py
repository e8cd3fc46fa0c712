"""Verbs `waterfall` and `jitter` from the command line, and their files."""

import json
from pathlib import Path

import numpy as np
import pytest

from gyrostat.core.units import RPM
from gyrostat.microvibration import Harmonic, WheelDisturbance, simulated_waterfall
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
SIGHT = """disturbance = "W/disturbance.toml"
transfer = "modes.csv"
exposure = "20 ms"
limit = "0.01 arcsec"
speeds = ["300 rpm", "3000 rpm"]
detail = 1e5
[[wheel]]
axis = [1, 1, 1]
"""
MODES = """frequency_Hz,damping,Fx,Fy,Fz,Tx,Ty,Tz,los_x,los_y
38,0.005,0.5,0,0.02,0,0.3,0.1,0.04,0.01
"""


def csv_of(waterfall):
    lines = ["load,speed_rpm," + ",".join(f"{f:.9g}" for f in waterfall.frequency)]
    for load, values in waterfall.density.items():
        for speed, row in zip(waterfall.speed, values, strict=True):
            lines.append(f"{load},{speed / RPM:.9g}," + ",".join(f"{x:.9g}" for x in row))
    return "\n".join(lines)


def test_a_waterfall_becomes_bands_that_a_scenario_reads(tmp_path, run):
    wheel = WheelDisturbance("wheel", (Harmonic(1.0, {"axial": 1e-6}),))
    speeds = np.linspace(300.0, 3000.0, 12) * RPM
    data = simulated_waterfall(
        wheel, speeds, np.random.default_rng(0), floor={"axial": 1e-6}, highest=120.0
    )
    (tmp_path / "wheel.csv").write_text(csv_of(data))
    code, out, _ = run("waterfall", tmp_path / "wheel.csv", "--out", tmp_path / "W", "--json")
    assert code == 0
    (harmonic,) = json.loads(out)["harmonics"]
    assert harmonic["number"]["value"] == pytest.approx(1.0, abs=1e-3)
    assert harmonic["axial"]["total"]["value"] == pytest.approx(1e-6, rel=0.02)
    assert (tmp_path / "W" / "waterfall.html").read_text().count('<div class="charts') == 1
    (tmp_path / "modes.csv").write_text(MODES)
    (tmp_path / "sight.toml").write_text(SIGHT)
    code, _, err = run("jitter", tmp_path / "sight.toml", "--out", tmp_path / "J")
    assert code == 0
    assert "1 band to avoid" in err
    assert "MTF at 1e+05 cycles/rad" in err
    bands = (tmp_path / "J" / "bands.toml").read_text()
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        (tmp_path / name).write_text((EXAMPLES / name).read_text())
    text = (EXAMPLES / "stiff_wheel.toml").read_text()
    (tmp_path / "scenario.toml").write_text(text + "\n" + bands)
    values = read_scenario(tmp_path / "scenario.toml").values
    # resonance at 38 Hz with a harmonic of number 1
    low, high = (values[f"controller.band.jitter_1.{end}"] / RPM for end in ("above", "below"))
    assert low < 38.0 * 60.0 < high
    assert high - low < 450.0


def test_too_few_speeds_end_with_code_1_and_no_model(tmp_path, run):
    wheel = WheelDisturbance("wheel", (Harmonic(1.0, {"axial": 1e-6}),))
    speeds = np.linspace(300.0, 3000.0, 4) * RPM
    data = simulated_waterfall(
        wheel, speeds, np.random.default_rng(0), floor={"axial": 1e-6}, highest=120.0
    )
    (tmp_path / "wheel.csv").write_text(csv_of(data))
    code, _, err = run("waterfall", tmp_path / "wheel.csv", "--out", tmp_path / "W")
    assert code == 1
    assert "not valid: too few speeds: 4, at least 8 are needed" in err
    assert not (tmp_path / "W" / "disturbance.toml").exists()


def test_bad_input_is_one_line_and_code_2(tmp_path, run):
    code, _, err = run("waterfall", tmp_path / "none.csv", "--out", tmp_path / "W")
    assert code == 2
    assert len(err.strip().splitlines()) == 1
    code, _, err = run("jitter", tmp_path / "none.toml", "--out", tmp_path / "J")
    assert code == 2
    assert "found no such file" in err
