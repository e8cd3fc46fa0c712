"""`gyrostat recover` as an operator meets it."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

CRAFT = Path(__file__).parents[1] / "examples" / "three_wheels.toml"
NOW = ("--wheels", "180rpm,-210rpm,520rpm", "--attitude", "0.9239,0,0,0.3827")
WANTED = ("--target", "0.9239,0,0,0.3827")


def test_a_recovery_is_flown_and_written(run, tmp_path, monkeypatch):
    words = ("recover", CRAFT, "--failed", "x=rundown:60s", *NOW, *WANTED, "--json")
    with monkeypatch.context() as without:
        for slow in ("xarray", "pandas", "matplotlib"):
            without.setitem(sys.modules, slow, None)  # its import fails
        code, out, err = run(*words, "--out", tmp_path)
    assert code == 0
    told = json.loads(out)
    assert told == json.loads((tmp_path / "recover.json").read_text())
    assert told["settled"]
    assert told["failed"] == {"x": "rundown"}
    assert f"{told['settle']:g} s after the failure" in err
    page = (tmp_path / "report.html").read_text()
    assert page.count('role="img"') == 4
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as flight:
        momentum = flight.wheel_momentum.values
        largest = 1e6 * float(np.max(np.abs(flight.torque.values)))
        assert np.degrees(flight.error.values[-1]) < 0.05
    # one unit for each quantity, in rows and charts
    assert f"<td>largest wheel torque</td><td>{largest:.0f} µN·m</td>" in page
    assert "torque command (µN·m)" in page
    assert re.findall(r"\S+ [µm]?N·m(?!·s)\b", page.replace("µN·m", "")) == []
    assert "rad/s" not in page
    # the dead wheel runs down with its time constant, 0.015 kg·m² at 180 rpm
    wanted = 0.015 * 180.0 * 2.0 * np.pi / 60.0 * np.exp(-0.5 * np.arange(1201) / 60.0)
    np.testing.assert_allclose(momentum[:, 0], wanted, atol=5e-3)


def test_impossible_starts_and_periods_are_refused_before_the_flight(run, tmp_path):
    lost, out = ("--failed", "x=frozen"), ("--out", tmp_path / "out")
    fast = ("--wheels", "180rpm,-210rpm,9000rpm", "--attitude", "0.9239,0,0,0.3827")
    code, _, err = run("recover", CRAFT, *lost, *fast, *WANTED, *out)
    assert code == 2
    assert "speed of wheel 2: found 942.478 rad/s, 14.1372 N·m·s" in err
    for periods in (("--period", "1e-20"), ("--period", "1e-20", "--duration", "1e-20")):
        code, _, err = run("recover", CRAFT, *lost, *NOW, *WANTED, *out, *periods)
        assert code == 2
        assert "control period: found 1e-20 s, expected 1e-09 to 1e+09 s" in err


def test_what_does_not_settle_is_no_valid_result(run, tmp_path):
    words = ("--failed", "x=rundown:2000s", *NOW, *WANTED)
    code, out, err = run("recover", CRAFT, *words, "--json", "--out", tmp_path)
    assert code == 1
    told = json.loads(out)
    assert told["settle"] is None
    assert told["reason"].startswith("not settled at the end, 600 s")
    assert "NOT recovered" in err


def test_nothing_left_is_no_valid_result(run, tmp_path):
    words = ("--failed", "x=seized,y=seized,z=seized")
    code, out, _ = run("recover", CRAFT, *words, *NOW, *WANTED, "--json", "--out", tmp_path)
    assert code == 1
    assert json.loads(out)["reason"].startswith("no attitude is feasible")
    assert not (tmp_path / "run.nc").exists()


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (("--failed", "w=seized", *NOW, *WANTED), "--failed: found no wheel 'w'"),
        (("--failed", "x=broken", *NOW, *WANTED), "--failed x: found 'broken', expected seized"),
        (("--failed", "x=rundown:-1s", *NOW, *WANTED), "time constant of running down: found -1"),
        (("--failed", "x=rundown:3kg", *NOW, *WANTED), "--failed x '3kg': found unit"),
        (("--failed", "x=seized", "--failed", "x=frozen", *NOW, *WANTED), "found x twice"),
        (("--failed", "x=seized", *NOW), "recover: missing --target or --euler"),
        (("--failed", "x=seized", "--wheels", "1,2", *NOW[2:], *WANTED), "--wheels: found '1,2'"),
        (
            ("--failed", "x=seized", "--wheels", "1kg,2rpm,3rpm", *NOW[2:], *WANTED),
            "found unit 'kg'",
        ),
        (
            ("--failed", "x=seized", "--wheels", "180rpm,-210,0", *NOW[2:], *WANTED),
            "--wheels: found -210 without and others with a unit, expected a unit for all",
        ),
        (
            ("--failed", "x=seized", *NOW[:2], *WANTED),
            "recover: missing --attitude, --attitude-euler or --telemetry",
        ),
        (
            ("--failed", "x=seized", *NOW[:2], "--attitude", "0,0,0,0", *WANTED),
            "telemetry: attitude: found a quaternion of length 0",
        ),
        (("--failed", "x=seized", *NOW, "--target", "2,0,0,0"), "target: found a quaternion"),
        (("--failed", "x=seized", *NOW, *WANTED, "--duration", "0"), "duration: found 0 s"),
        (("--failed", "x=seized", *NOW, *WANTED, "--period", "0.7"), "duration: found 600 s"),
        (
            ("--failed", "x=seized", *NOW, *WANTED, "--duration", "20", "--period", "0.7"),
            "duration: found 20 s",
        ),
    ],
)
def test_bad_input_is_one_line(run, tmp_path, words, found):
    out = tmp_path / "out"
    code, stdout, stderr = run("recover", CRAFT, *words, "--out", out)
    assert code == 2
    assert stdout == ""
    lines = [line for line in stderr.splitlines() if line.startswith("error: ")]
    assert len(lines) == 1
    assert found in lines[0]
    assert not out.exists()


def test_the_drift_under_an_external_torque_is_said(run, tmp_path):
    torque = ("--external-torque", "10uN·m,5uN·m,0")
    code, _, err = run(
        *("recover", CRAFT, "--failed", "x=frozen", *NOW, *WANTED, *torque, "--out", tmp_path)
    )
    assert code == 0
    content = json.loads((tmp_path / "recover.json").read_text())
    drift = content["external_torque"]
    assert drift["torque"] == pytest.approx([1e-5, 5e-6, 0.0])
    assert drift["momentum"] == pytest.approx(np.hypot(1e-5, 5e-6) * 600.0)
    # x is the normal of the working wheels, so that 1e-5 N·m tilts the momentum across it
    y, z = content["holdable"]["momentum_in_body"][1:]
    assert drift["angle"] == pytest.approx(1e-5 * 600.0 / np.hypot(y, z), rel=0.05)
    shown = f"drifts by about {np.degrees(drift['angle']):.4g} deg until the end"
    assert shown in err
    assert shown in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize("torque", ["1e-5,0", "1e-5,0,a", "nan,0,0", "1 Nms,0,0"])
def test_an_external_torque_of_another_form_is_refused(run, tmp_path, torque):
    words = ("--failed", "x=frozen", *NOW, *WANTED, "--external-torque", torque)
    code, _, err = run("recover", CRAFT, *words, "--out", tmp_path / "out")
    assert code == 2
    assert "error: --external-torque" in err
    assert not (tmp_path / "out").exists()
