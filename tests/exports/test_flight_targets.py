"""`gyrostat export`: folders that compile, repeat Python's run and say what they take."""

import json
import re
import subprocess

import pytest

from gyrostat.codegen.flight.measure import measure
from gyrostat.codegen.simd import compiler
from gyrostat.core.units import SI_UNIT
from gyrostat.exports import files
from gyrostat.exports.sheet import sheet
from gyrostat.wheel import WheelModel
from gyrostat.wheel.friction import ViscousCoulomb

MODEL = """
[wheel]
inertia = 0.0015
motor_constant = 0.0228

[friction]
model = "stribeck"
viscous = 4.83e-06
coulomb = 0.8795e-3
static = 0.9055e-3
stribeck_speed = 0.418879

[sigma]
coulomb = 2e-06
"""
GAINS = ("--gains", "0.0571,0.00234,0.3126")
TABLE = ("--table-inertia", "0.495", "--speed-sigma", "5rpm", "--delay", 1)
DRIFT = ("--speed-sigma", "0.5", "--scale-drift", "1e-3")
OPTIONS = {
    "compensated-wheel": (*GAINS, *TABLE),
    "compensator": (*GAINS, *TABLE),
    "controller": GAINS,
    "estimator": DRIFT,
    "wheel": (),
}


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(MODEL, encoding="utf-8")
    return path


@pytest.fixture
def exported(run, model, tmp_path):
    """Run the verb; the folder, and what it printed."""

    def call(what, *options, to="c"):
        out = tmp_path / what
        words = ("--what", what, "--period", "100ms") if to == "c" else ()
        code, printed, said = run("export", model, "--to", to, *words, "--out", out, *options)
        assert code == 0, said
        return out, printed

    return call


@pytest.mark.parametrize("what", OPTIONS)
def test_the_folder_compiles_and_its_test_passes(what, exported, tools):
    out, printed = exported(what, *OPTIONS[what], "--json")
    what = what.replace("-", "_")
    names = [f"{what}.h", f"{what}.c", "vectors.csv", f"{what}_vectors.h", f"{what}_test.c"]
    names += ["expected.txt", "Makefile", "README.md", "evidence.html"]
    files = json.loads(printed)["files"]
    assert [name for name in files if not name.startswith("evidence/")] == names
    folder = [path.name for path in out.iterdir()]
    assert sorted(folder) == sorted([".gyrostat.json", "evidence", *names])
    strict = [f"{what}.c", f"{what}_test.c", "-lm", "-o", "program"]
    tools.build(out, *strict)
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert done.stdout == (out / "expected.txt").read_text(encoding="utf-8")
    assert "as in Python" in done.stdout
    readme = (out / "README.md").read_text(encoding="utf-8")
    assert re.search(rf"\| `{what}_\w+` \| \d+", readme)
    assert re.search(r"\d+ bytes of code", readme)


def test_a_test_program_sees_a_wrong_number(exported, tools):
    out, _ = exported("controller", *GAINS)
    source = out / "controller.c"
    text = source.read_text(encoding="utf-8")
    broken = text.replace("->derivative = 0.3126;", "->derivative = 0.3126000001;")
    broken = broken.replace(".derivative = 0.3126;", ".derivative = 0.3126000001;")
    assert broken != text
    source.write_text(broken, encoding="utf-8")
    tools.build(out, "controller.c", "controller_test.c", "-lm", "-o", "program")
    done = subprocess.run([out / "program"], capture_output=True, text=True)
    assert done.returncode == 1
    assert "command.current: not as in Python" in done.stdout


def test_the_compensator_is_as_small_as_it_should_be(g2, tools):
    """Under 3 kB of code with its Kalman filter, 1.3 kB of validation, and 512 B of stack."""
    from gyrostat.control import EstimatingCompensator
    from gyrostat.exports import targets

    if compiler() is None:
        pytest.skip("found no C compiler")
    tuned = EstimatingCompensator.tune(g2.law, g2.wheel, 0.495, 0.5, 0.1, delay=1)
    texts = files(targets.compensator(tuned, 0.1), "double", "")
    found = measure(texts, "compensator")
    assert found is not None
    if found.code is None or not found.stack:
        pytest.skip(f"{found.compiler} tells no size")
    assert found.code < 4300
    assert sum(found.stack.values()) < 512
    assert max(found.errors.values()) < 1e-12


def test_ranges_and_the_safe_command_reach_the_code(exported):
    limits = ("--range", "rate=-2deg/s:2deg/s", "--rate-limit", "attitude=0.5")
    out, _ = exported("controller", *GAINS, *limits, "--on-bad", "zero")
    header = (out / "controller.h").read_text(encoding="utf-8")
    assert "SAMPLE_STATUS_OUT_OF_RANGE = 3," in header
    assert "on_bad =" in header
    source = (out / "controller.c").read_text(encoding="utf-8")
    assert "guard->limits.rate.upper = 0.0349" in source
    assert "guard->limits.attitude.rate = 0.5;" in source
    assert "guard->limits.rate.rate" not in source
    assert "the output is zero" in (out / "README.md").read_text(encoding="utf-8")


def test_single_precision_says_what_it_loses(exported):
    out, _ = exported("controller", *GAINS, "--precision", "float")
    readme = (out / "README.md").read_text(encoding="utf-8")
    assert "double" not in (out / "controller.c").read_text(encoding="utf-8")
    if compiler() is None:
        assert "Not measured" in readme
        pytest.skip("found no C compiler")
    losses = dict(re.findall(r"- `([\w.]+)`: (\S+)", readme.partition("## Errors of single")[2]))
    assert 0.0 < float(losses["command.current"]) < 1e-5


def test_without_a_compiler_the_code_comes_and_the_folder_says_so(exported, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    out, _ = exported("controller", *GAINS)
    readme = (out / "README.md").read_text(encoding="utf-8")
    assert "not measured, because there was no C compiler" in readme


def test_a_data_sheet_has_every_number_with_its_unit(exported):
    out, _ = exported("sheet", to="json")
    content = json.loads((out / "wheel.json").read_text(encoding="utf-8"))
    assert content["friction"]["model"] == "stribeck"
    parameters = content["parameters"]
    assert parameters["coulomb"] == {"value": 0.8795e-3, "sigma": 2e-06, "unit": SI_UNIT["torque"]}
    assert parameters["inertia"] == {"value": 0.0015, "sigma": None, "unit": "kg·m²"}
    assert len(parameters) == 6
    assert "impossible" not in content
    marked = WheelModel(ViscousCoulomb, {"viscous": -1e-6, "coulomb": 1e-3}, impossible="b < 0")
    assert json.loads(sheet(marked))["impossible"] == "b < 0"


def test_a_module_for_basilisk_is_written(exported):
    out, _ = exported("sheet", to="basilisk")
    assert "def add_wheel" in (out / "wheel_basilisk.py").read_text(encoding="utf-8")


WHAT = ("--to", "c", "--period", "0.1", "--what")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--to", "c"), "--what"),
        (("--to", "c", "--what", "wheel"), "--period"),
        ((*WHAT, "compensator", *GAINS), "--table-inertia"),
        ((*WHAT, "controller"), "--gains"),
        ((*WHAT, "controller", "--gains", "1,2"), "3 values"),
        ((*WHAT, "controller", "--gains", "1,2,nan"), "finite"),
        ((*WHAT, "controller", *GAINS, "--current-limit", "-1A"), "--current-limit"),
        ((*WHAT, "controller", *GAINS, *TABLE), "--table-inertia"),
        ((*WHAT, "compensator", *GAINS, *TABLE[:3], "0", "--delay", 1), "speed sigma"),
        ((*WHAT, "compensator", *GAINS, *TABLE[:4], "--delay", "-2"), "--delay"),
        ((*WHAT, "estimator", "--speed-sigma", "0.5", "--scale-drift", "x"), "--scale-drift"),
        ((*WHAT, "wheel", *GAINS), "--gains"),
        (("--to", "c", "--what", "wheel", "--period", "0"), "--period"),
        (("--to", "json", "--what", "wheel"), "--what"),
        (("--to", "json", "--on-bad", "zero"), "--on-bad"),
        ((*WHAT, "wheel", "--range", "speed=0:1"), "--range"),
        ((*WHAT, "wheel", "--on-bad", "zero"), "--on-bad"),
        ((*WHAT, "controller", *GAINS, "--range", "speed=0:1"), "attitude, rate"),
        ((*WHAT, "controller", *GAINS, "--range", "rate=1:0"), "lower value first"),
        ((*WHAT, "controller", *GAINS, "--range", "rate=1"), "LOWER:UPPER"),
        ((*WHAT, "controller", *GAINS, "--rate-limit", "rate=x"), "a number"),
        ((*WHAT, "controller", *GAINS, "--rate-limit", "rate=0"), "above 0"),
        ((*WHAT, "controller", *GAINS, *["--rate-limit", "rate=1"] * 2), "twice"),
        (("--to", "basilisk", "--precision", "float"), "--precision"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(words, told, run, model, tmp_path):
    out = tmp_path / "out"
    code, printed, said = run("export", model, *words, "--out", out)
    assert code == 2
    assert printed == ""
    assert said.count("\n") == 1
    assert told in said
    assert not out.exists()


def test_a_model_that_cannot_be_read_is_bad_input(run, tmp_path):
    words = ("--to", "json", "--out", tmp_path / "out")
    code, _, said = run("export", tmp_path / "none.toml", *words)
    assert code == 2
    assert "none.toml" in said
