"""`feasible` and `recover` in the hour after a failure: telemetry in, the next command out."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
import typer.main
from scipy.spatial.transform import Rotation

import gyrostat as gs
from gyrostat.cli import app
from gyrostat.core.units import RPM

CRAFT = Path(__file__).parents[1] / "examples" / "three_wheels.toml"
ATTITUDE, RATE, SPEED = "0.9239,0,0,0.3827", "1e-3,-2e-3,5e-4", "180rpm,-210rpm,520rpm"
STATE = ("--attitude", ATTITUDE, "--rate", RATE, "--wheels", SPEED)
FILE = """
attitude = [0.9239, 0, 0, 0.3827]
rate = ["1 mrad/s", -2e-3, "0.5 mrad/s"]
wheel_speed = {z = "520 rpm", x = "180 rpm", y = "-210 rpm"}
"""


def numbers(text):
    return np.array([float(part) for part in text.split(",")])


def momentum():
    """Total momentum by hand: a cube of 12 kg·m² whose rotors have 0.015 kg·m² about x, y, z."""
    attitude = Rotation.from_quat(numbers(ATTITUDE), scalar_first=True)
    speed = np.array([180.0, -210.0, 520.0]) * 2.0 * np.pi / 60.0
    return attitude.apply((12.0 + 0.015) * numbers(RATE) + 0.015 * speed)


@pytest.fixture
def feasible(run, tmp_path):
    """Answer of `gyrostat feasible`, and what it says."""
    folders = iter(range(100))

    def call(*words):
        out = tmp_path / f"out{next(folders)}"
        code, printed, said = run("feasible", CRAFT, *words, "--json", "--out", out)
        assert code == 0, said
        answer = json.loads(printed)
        assert answer == json.loads((out / "holdable.json").read_text())
        return answer, said, (out / "report.html").read_text()

    return call


def test_telemetry_and_the_momentum_computed_by_hand_give_the_same_answer(feasible, tmp_path):
    path = tmp_path / "telemetry.toml"
    path.write_text(FILE)
    given = ",".join(f"{value:.17g}" for value in momentum())
    words = ("--failed", "x=rundown", "--target", ATTITUDE)
    expected, *_ = feasible("--momentum", given, *words)
    for state in (STATE, ("--telemetry", path)):
        answer, *_ = feasible(*state, *words)
        np.testing.assert_allclose(answer["momentum"], momentum(), rtol=1e-13)
        for name in ("angle", "attitude", "momentum_in_body", "unload"):
            np.testing.assert_allclose(answer[name], expected[name], rtol=1e-9, atol=1e-12)
        assert answer["inputs"]["wheel_speed"]["y"] == pytest.approx(-210.0 * RPM)


def test_a_frozen_wheel_keeps_the_momentum_of_its_rotor(feasible):
    target = ("--target", ATTITUDE)
    answer, *_ = feasible(*STATE, "--failed", "x=frozen", *target)
    assert answer["failed"]["x"] == pytest.approx(0.015 * (180.0 * RPM + 1e-3), rel=1e-12)
    same, *_ = feasible(*STATE, "--failed", "x=180rpm", *target)
    assert same["failed"] == answer["failed"]
    other, said, _ = feasible(*STATE, "--failed", "x=300rpm", *target)
    assert other["failed"]["x"] == pytest.approx(0.015 * 300.0 * RPM)
    assert "wheel x: 0.4712 N·m·s after the failure, but 0.2828 N·m·s in the telemetry" in said
    assert "--failed x=frozen" in other["next"][0]["command"]


@pytest.mark.parametrize("form", ["x", "x=seized", "x=rundown", "x=rundown:60s"])
def test_both_verbs_take_the_same_failures(feasible, form):
    answer, *_ = feasible(*STATE, "--failed", form, "--target", ATTITUDE)
    assert answer["failed"] == {"x": 0.0}
    assert f"--failed {form} " in answer["next"][0]["command"]


def test_both_verbs_explain_failures_alike():
    verbs = typer.main.get_command(app).commands
    texts = [
        next(option.help for option in verbs[verb].params if option.name == "failed")
        for verb in ("feasible", "recover")
    ]
    assert texts[0] == texts[1]


def test_a_recovery_starts_where_the_telemetry_is(run, tmp_path):
    words = ("--failed", "x=700rpm", *STATE, "--target", ATTITUDE, "--out", tmp_path / "out")
    code, _, err = run("recover", CRAFT, *words)
    assert code == 2
    assert "--failed x: found 1.09956 N·m·s, expected 0.282758 N·m·s as in the telemetry" in err


def test_a_target_is_told_in_words_and_a_half_turn_is_questioned(feasible):
    answer, said, page = feasible(*STATE, "--failed", "x", "--target", "0,0,0,1")
    for text in (said, page, answer["inputs"]["target"]["text"]):
        assert "turned by 180 deg about z; 3-1-3 angles 180, 0, 0 deg" in text
    assert answer["inputs"]["target"]["euler"] == pytest.approx([np.pi, 0.0, 0.0])
    (warning,) = answer["inputs"]["warnings"]
    assert "add --scalar-last" in warning
    assert warning in said
    assert warning[1:] in page
    plain, said, _ = feasible(*STATE, "--failed", "x", "--target", ATTITUDE)
    assert plain["inputs"]["warnings"] == []
    assert "warning" not in said


def test_scalar_last_quaternions_give_the_same_answer(feasible, tmp_path):
    words = ("--failed", "x", "--rate", RATE, "--wheels", SPEED)
    expected, *_ = feasible(*words, "--attitude", ATTITUDE, "--target", "1,0,0,0")
    last = ("--scalar-last", "--target", "0,0,0,1")
    answer, said, _ = feasible(*words, "--attitude", "0,0,0.3827,0.9239", *last)
    assert answer["attitude"] == expected["attitude"]
    assert "not turned" in said
    assert "--scalar-last" in answer["next"][0]["command"]
    path = tmp_path / "state.toml"
    for text, order in (("scalar_last = true", ()), ("", ("--scalar-last",))):
        path.write_text(f"attitude = [0, 0, 0.3827, 0.9239]\n{text}\n")
        target = last if order else ("--target", "1,0,0,0")
        answer, *_ = feasible(*words, "--telemetry", path, *target)
        assert answer["attitude"] == expected["attitude"]
    path.write_text("attitude = [0.9239, 0, 0, 0.3827]\nscalar_last = false\n")
    answer, *_ = feasible(*words, "--telemetry", path, *last)
    assert answer["attitude"] == expected["attitude"]


@pytest.mark.parametrize(
    "wanted",
    [
        ("--target", ATTITUDE),
        ("--euler", "180deg,-10deg,0"),
        ("--boresight", "x", "--towards", "-1,0.3,0.1"),
        ("--target", "0,0,1,0", "--scalar-last"),
    ],
)
def test_unloading_the_momentum_that_is_named_makes_the_target_feasible(run, feasible, wanted):
    state = ("--attitude-euler", "45deg,0,0", *STATE[2:])
    answer, said, page = feasible(*state, "--failed", "x=frozen", *wanted)
    size = float(np.linalg.norm(answer["unload"]))
    assert f"momentum to unload to hold the target: {size:.4g} N·m·s" in said
    assert "time to unload it" in page
    step = answer["next"][-1]
    assert step["why"] == "verify the target with that momentum unloaded"
    words = shlex.split(step["command"])
    assert words[0] == "gyrostat"
    code, printed, _ = run(*words[1:], "--json")
    assert (code, json.loads(printed)["holdable"]) == (0, True)


def test_the_times_of_unloading_are_momentum_over_torque(feasible):
    """0.177 N·m·s: 177 s by 1000 µN·m; 0.177 / 30e-6 s, 98.5 min, by 1 A·m² in 30 µT."""
    words = ("--momentum", "0.46,-0.04,0.82", "--failed", "x=180rpm", "--target", "1,0,0,0")
    answer, said, _ = feasible(*words)
    np.testing.assert_allclose(answer["unload"], [0.46 - 0.015 * 180.0 * RPM, 0.0, 0.0], atol=1e-12)
    assert "177 s with a thruster torque of 1000 µN·m; at least 98.5 min with torque rods" in said
    assert answer["next"][0]["command"] == ""
    assert "give attitude, rate and wheel speeds" in said


def test_the_next_command_simulates_the_recovery(run, tmp_path):
    wanted = ("--failed", "x=rundown:60s", *STATE, "--target", ATTITUDE)
    code, printed, _ = run("feasible", CRAFT, *wanted, "--json", "--out", tmp_path)
    feasible = json.loads(printed)
    words = shlex.split(feasible["next"][0]["command"])
    code, printed, said = run(*words[1:], "--json")
    recovery = json.loads(printed)
    assert (code, recovery["settled"]) == (0, True)
    assert recovery["holdable"]["angle"] == pytest.approx(feasible["angle"], rel=1e-9)
    assert recovery["inputs"]["target"] == feasible["inputs"]["target"]
    assert "next: command this attitude instead of the target: turned by" in said
    assert (tmp_path / "recover" / "run.nc").exists()


def test_a_recovery_that_is_too_short_names_the_longer_one(run, tmp_path):
    brake = ("--brake", "x=40s")
    words = ("--failed", "x=rundown:60s", *brake, *STATE, "--target", ATTITUDE, "--duration", "20")
    code, printed, said = run("recover", CRAFT, *words, "--json", "--out", tmp_path)
    assert code == 1
    step = json.loads(printed)["next"][0]
    assert step["why"] == "simulate longer"
    assert step["command"] in said
    assert " --brake x=40s " in step["command"]
    code, printed, _ = run(*shlex.split(step["command"])[1:], "--json")
    assert (code, json.loads(printed)["settled"]) == (0, True)


def test_large_angles_without_a_unit_are_questioned(feasible, tmp_path):
    words = ("--failed", "x", "--rate", RATE, "--wheels", SPEED)
    path = tmp_path / "angles.toml"
    path.write_text("attitude_euler = [90, 0, 0]")
    answer, said, _ = feasible(*words, "--telemetry", path, "--euler", "0,45,0")
    assert "angles.toml: key attitude_euler: 90 is read in rad" in said
    assert "--euler: 45 is read in rad; for degrees write '45 deg'" in said
    path.write_text('attitude_euler = ["90 deg", 0, 0]')
    answer, *_ = feasible(*words, "--telemetry", path, "--euler", "0,45deg,0")
    assert answer["inputs"]["warnings"] == []


@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        (FILE, ("--rate", RATE), "--rate: found it beside --telemetry"),
        (FILE, ("--momentum", "0,0,1"), "--momentum: found it beside telemetry"),
        ("rate = [0, 0, 0]", (), "missing key attitude or attitude_euler, or --attitude"),
        ("speed = 3", (), "key speed: found an unknown key"),
        (FILE + "wheel_momentum = [0, 0, 0]", (), "found the keys wheel_speed and wheel_momentum"),
        (FILE.replace("x =", "w ="), (), "found no wheel 'w'"),
        (FILE.replace('x = "180 rpm", ', ""), (), "missing wheel_speed.x"),
        (FILE.replace("180 rpm", "180 N"), (), "key wheel_speed[x] '180 N': found unit 'N'"),
        (FILE.replace("[0.9239,", "[1,"), (), "attitude: found a quaternion of length 1.07"),
        (FILE.replace("0.3827]", '"0.3827"]'), (), "key attitude[3]: found '0.3827'"),
        (FILE + "scalar_last = 1", (), "key scalar_last: found 1, expected true, false"),
        (FILE.replace("520 rpm", "9000 rpm"), (), "speed of wheel 2: found 942.478 rad/s"),
    ],
)
def test_bad_telemetry_is_one_line(run, tmp_path, text, words, message):
    path = tmp_path / "telemetry.toml"
    path.write_text(text)
    given = ("--telemetry", path, *words, "--failed", "x", "--target", ATTITUDE)
    code, out, err = run("feasible", CRAFT, *given, "--out", tmp_path / "out")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert message in err
    assert not (tmp_path / "out").exists()


def test_where_nothing_is_feasible_the_stopped_wheel_is_the_next_question(run, feasible):
    answer, said, _ = feasible(*STATE, "--failed", "x=700rpm", "--target", ATTITUDE)
    assert "NO attitude is feasible" in said
    step = answer["next"][0]
    assert step["why"] == "the answer if the failed wheels stop (brake, friction)"
    code, printed, _ = run(*shlex.split(step["command"])[1:], "--json")
    assert (code, json.loads(printed)["failed"]) == (0, {"x": 0.0})
    assert json.loads(printed)["reason"] is None


def test_a_frozen_wheel_needs_its_momentum(run, tmp_path):
    words = ("--momentum", "0,0,1", "--failed", "x=frozen", "--target", ATTITUDE)
    code, _, err = run("feasible", CRAFT, *words, "--out", tmp_path)
    assert code == 2
    assert "--failed x: found frozen without the wheel speeds, expected telemetry" in err


def test_python_takes_telemetry_too():
    speed = np.array([180.0, -210.0, 520.0]) * RPM
    words = {"failed": {"x": "frozen"}, "target": numbers(ATTITUDE)}
    state = {"attitude": numbers(ATTITUDE), "rate": numbers(RATE), "wheels": 0.015 * speed}
    answer = gs.feasible(CRAFT, **words, **state)
    other = gs.feasible(CRAFT, momentum(), target=words["target"], failed={"x": 0.015 * 18.8505559})
    assert answer.angle == pytest.approx(other.angle, rel=1e-6)
    assert answer.wheel_momentum[0] == pytest.approx(0.015 * (180.0 * RPM + 1e-3), rel=1e-12)
