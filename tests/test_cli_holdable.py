"""`gyrostat holdable` as an operator meets it."""

import json
from pathlib import Path

import numpy as np
import pytest

from gyrostat.core import rotations

CRAFT = Path(__file__).parents[1] / "examples" / "three_wheels.toml"
MOMENTUM = ("--momentum", "0.59,0.05,0.81")


def test_a_target_that_cannot_be_held(run, tmp_path):
    words = ("--failed", "x=200rpm", "--target", "1,0,0,0", "--tolerance", "0.05deg")
    code, out, err = run("holdable", CRAFT, *MOMENTUM, *words, "--json", "--out", tmp_path)
    assert code == 0
    told = json.loads(out)
    assert told == json.loads((tmp_path / "holdable.json").read_text())
    frozen = 0.015 * 200.0 * 2.0 * np.pi / 60.0
    assert told["failed"] == {"x": pytest.approx(frozen)}
    assert told["holdable"] is False
    radius = np.linalg.norm([0.59, 0.05, 0.81])
    expected = np.arccos(frozen / radius) - np.arccos(0.59 / radius)
    assert told["angle"] == pytest.approx(expected, abs=1e-9)
    assert told["at_target"]["rate"] == pytest.approx((0.59 - frozen) / 12.0)
    assert told["dwell"] == pytest.approx(np.radians(0.1) / told["at_target"]["rate"], rel=0.01)
    assert [m["boresight"] for m in told["sky"]] == np.eye(3).tolist()
    assert told["wheel_momentum"]["x"] == told["failed"]["x"]
    in_body = rotations.to_body(np.array(told["attitude"]), np.array([0.59, 0.05, 0.81]))
    np.testing.assert_allclose(in_body, list(told["wheel_momentum"].values()), atol=1e-12)
    page = (tmp_path / "report.html").read_text()
    assert page.count("<svg") == 3
    assert "is NOT feasible: the nearest feasible attitude is 17.77 deg away" in page
    assert "is NOT feasible" in err
    for outside in ('src="http', 'href="http', "@import", "<script src"):
        assert outside not in page


def test_a_boresight_and_its_map(run, tmp_path):
    words = ("--failed", "x=0.3 N·m·s", "--boresight", "z", "--towards", "1,0.3,0.1")
    code, out, _ = run("holdable", CRAFT, *MOMENTUM, *words, "--json", "--out", tmp_path)
    told = json.loads(out)
    assert (code, told["holdable"], told["angle"]) == (0, True, 0.0)
    assert told["target"] is None
    pointed = rotations.to_inertial(np.array(told["attitude"]), np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(pointed, np.array([1.0, 0.3, 0.1]) / np.sqrt(1.1), atol=1e-12)
    (sky,) = told["sky"]
    circle = np.arccos(0.3 / np.linalg.norm([0.59, 0.05, 0.81]))
    assert sky["fraction"] == pytest.approx(np.sin(circle))


def test_nothing_can_be_held_is_an_answer(run, tmp_path):
    words = ("--failed", "x=2", "--failed", "y=seized", "--euler", "0,90deg,0")
    code, out, err = run("holdable", CRAFT, *MOMENTUM, *words, "--json", "--out", tmp_path)
    told = json.loads(out)
    assert code == 0
    assert told["reason"].startswith("the wheels hold at least 2 N·m·s")
    assert (told["angle"], told["attitude"], told["wheel_momentum"]) == (None, None, None)
    assert told["for_ever"]["rate"] > 0.0
    assert "NO attitude is feasible" in err
    np.testing.assert_allclose(told["target"], [np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0], atol=1e-15)


def test_the_angles_are_those_of_the_package(run, tmp_path):
    words = ("--euler", "0.3,0.7,-1.1", "--boresight", "-z")
    _, out, _ = run("holdable", CRAFT, *MOMENTUM, *words, "--json", "--out", tmp_path)
    expected = rotations.from_euler(rotations.EulerAngles(0.3, 0.7, -1.1))
    told = json.loads(out)
    assert abs(np.dot(told["target"], expected)) == pytest.approx(1.0, abs=1e-12)
    assert [m["boresight"] for m in told["sky"]] == [[-0.0, -0.0, -1.0]]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--target", "1,0,0"), "--target: found '1,0,0', expected 4 values"),
        (("--target", "1,0,0,up"), "--target: found '1,0,0,up', expected 4 numbers"),
        (("--target", "1,1,0,0"), "target: found a quaternion of length 1.41421"),
        ((), "feasible: missing --target, --euler or --boresight with --towards"),
        (("--target", "1,0,0,0", "--euler", "0,0,0"), "found --target and --euler"),
        (("--towards", "1,0,0"), "--towards: found no --boresight"),
        (("--boresight", "0,0,0", "--towards", "x"), "--boresight: found zero"),
        (("--boresight", "q", "--towards", "x"), "--boresight: found 'q', expected 3 values"),
        (("--boresight", "z", "--towards", "x", "--tolerance", "1deg"), "tolerance: found one for"),
        (("--target", "1,0,0,0", "--tolerance", "1rpm"), "--tolerance"),
        (("--target", "1,0,0,0", "--failed", "w"), "--failed: found no wheel 'w', expected one of"),
        (("--target", "1,0,0,0", "--failed", "x=stuck"), "--failed x: found 'stuck'"),
        (("--target", "1,0,0,0", "--failed", "x,x"), "--failed: found x twice"),
        (("--target", "1,0,0,0", "--momentum", "1,2"), "--momentum: found '1,2'"),
        (("--target", "1,0,0,0", "--momentum", "1,2,3 Nm"), "expected a unit of momentum"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_2(run, tmp_path, words, expected):
    out_folder = tmp_path / "out"
    code, out, err = run("holdable", CRAFT, *MOMENTUM, *words, "--out", out_folder)
    assert code == 2
    assert out == ""
    assert expected in err
    assert len(err.strip().splitlines()) == 1
    assert not out_folder.exists()


def test_a_bad_file_is_named(run, tmp_path):
    craft = tmp_path / "craft.toml"
    craft.write_text(CRAFT.read_text().replace("momentum_limit", "momentum_limits", 1))
    code, _, err = run(
        "holdable", craft, *MOMENTUM, "--target", "1,0,0,0", "--out", tmp_path / "out"
    )
    assert code == 2
    assert f"error: {craft}: key wheel[x].momentum_limits: found an unknown key" in err
