"""`identify --method inverse` on the command line: files, messages, refused options."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gyrostat.wheel import read_model

BENCHMARK = Path(__file__).resolve().parents[2] / "benchmarks" / "drives.py"
LAW = '[loop]\nlaw = "position"\nkp = 560.0\nkd = 3.5\nsaturation = "10 A"\n'


@pytest.fixture(scope="module")
def servo(tmp_path_factory, module_at):
    """File of a servo axis, and its true parameters."""
    module = module_at(BENCHMARK)
    case = replace(module.CASES["cascade"], interval=2e-3, duration=20.0)
    record, true = module.simulate(case, 3)
    path = tmp_path_factory.mktemp("servo") / "servo.csv"
    angle = np.append(0.0, np.cumsum(record.speed[1:] * np.diff(record.time)))
    columns = np.column_stack([record.time, record.current, angle, record.reference])
    header = "time_s,current_A,angle_rad,reference_angle_rad"
    np.savetxt(path, columns, "%.17g", ",", header=header, comments="")
    return path, true


def words(servo, out, *further):
    motor = f"motor_constant={servo[1]['motor_constant']!r}"
    return ("identify", servo[0], "--method", "inverse", "--hold", motor, "--out", out, *further)


def test_files_of_a_drive(run, tmp_path, servo):
    path, true = servo
    law = tmp_path / "loop.toml"
    law.write_text(LAW)
    out = tmp_path / "fit"
    code, text, err = run(*words(servo, out, "--loop", law, "--held-out", path, "--json"))
    assert code == 0, err
    document = json.loads(text)
    methods = document["inverse"]["methods"]
    assert set(methods) == {"instruments", "least_squares", "output_error"}
    for name in ("inertia", "viscous", "coulomb"):
        row = document["parameters"][name]
        assert abs(row["value"] - true[name]) < 4.0 * row["sigma"]
        assert row["value"] == methods["instruments"]["values"][name]
    assert document["inverse"]["held_out"] == pytest.approx(document["inverse"]["torque_error"])
    model = read_model(out / "model.toml")
    assert model.values["inertia"] == pytest.approx(document["parameters"]["inertia"]["value"])
    assert "Estimators of the inverse dynamics" in (out / "report.html").read_text()
    assert "torque error on held-out servo.csv" in err
    assert "output error (DIDIM)" in err


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[columns]\n", "found no table [loop]"),
        ('[loop]\nlaw = "sliding"\n', "key loop.law: found 'sliding', expected one of"),
        ('[loop]\nlaw = "speed"\nkq = 1.0\n', "key loop.kq: found an unknown key"),
        ('[loop]\nlaw = "speed"\n', "loop: found no gain"),
        ('[loop]\nlaw = "speed"\nkp = "much"\n', "key loop.kp: found 'much'"),
        ('[loop]\nlaw = "speed"\nkp = 1.0\nsaturation = -1\n', "key loop.saturation: found -1"),
        ('[loop]\nlaw = "speed"\nkp = 1.0\n', "found no column setpoint, expected one"),
    ],
)
def test_control_laws_that_cannot_be_used(run, tmp_path, servo, text, expected):
    law = tmp_path / "loop.toml"
    law.write_text(text)
    out = tmp_path / "fit"
    code, shown, err = run(*words(servo, out, "--loop", law))
    assert (code, shown) == (2, "")
    assert expected in err
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--free", "inertia"), "--method inverse: found --free"),
        (("--loop", "open"), "--loop: found open with --method inverse"),
        (("--loop", "perhaps"), "--loop (or a .toml file): found 'perhaps'"),
        (("--current-scale", "+- 1 %", "--inertia", "95"), "found a tolerance with a held inertia"),
    ],
)
def test_options_that_contradict_the_method(run, tmp_path, servo, options, expected):
    out = tmp_path / "fit"
    code, shown, err = run(*words(servo, out, *options))
    assert (code, shown) == (2, "")
    assert expected in err


def test_scale_of_the_current_is_in_sigma(run, tmp_path, servo):
    sigmas = []
    for k, options in enumerate([(), ("--current-scale", "+- 10 %")]):
        out = tmp_path / str(k)
        assert run(*words(servo, out, *options, "--json"))[0] == 0
        document = json.loads((out / "fit.json").read_text())
        sigmas.append(document["parameters"]["inertia"]["sigma"])
    value = document["parameters"]["inertia"]["value"]
    assert sigmas[1] ** 2 == pytest.approx(sigmas[0] ** 2 + (0.1 * value) ** 2, rel=1e-9)


def test_laws_are_refused_with_other_methods(run, tmp_path, servo):
    law = tmp_path / "loop.toml"
    law.write_text(LAW)
    line = ("identify", servo[0], "--inertia", "95", "--loop", law, "--out", tmp_path / "fit")
    code, _, err = run(*line)
    assert code == 2
    assert "found a control law with --method batch, expected --method inverse" in err
