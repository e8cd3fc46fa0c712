"""The command line as its users meet it: results, exit codes, one clear line for bad input."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

# Results here are compared with those of a process of its own, digit by digit.
pytestmark = pytest.mark.optimised
EXAMPLE = Path(__file__).parents[1] / "examples" / "wheel_profile2.csv"
MODEL = """
[wheel]
inertia = 1.5e-3
motor_constant = 0.0228
[friction]
model = "stribeck"
viscous = 4.83e-6
coulomb = 0.8795e-3
static = 0.9055e-3
stribeck_speed = 0.418879
"""


@pytest.fixture
def refused(run, tmp_path):
    """Run `identify` on a record text that must be refused; the line that says why."""

    def call(text, *options, name="bad.csv"):
        record = tmp_path / name
        record.write_text(text)
        out = tmp_path / "out"
        code, stdout, stderr = run("identify", record, "--out", out, *options)
        assert code == 2
        assert stdout == ""
        assert not out.exists()
        lines = [line for line in stderr.splitlines() if line.startswith("error: ")]
        assert len(lines) == 1
        assert "Traceback" not in stderr
        return lines[0]

    return call


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """Results of the example record, made beside it by the installed command."""
    out = tmp_path_factory.mktemp("fit")
    record = shutil.copy(EXAMPLE, out)
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "from gyrostat.cli import main; main()",
            "identify",
            record,
            *("--inertia", "1.5e-3", "--speed-sigma", "5rpm", "--out", str(out), "--json"),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return out, done


def header_and_rows(count=40):
    time = np.arange(count) * 0.1
    current = np.where(time < 2.0, 0.1, -0.1)
    speed = np.cumsum(current)
    rows = [f"{t:.2f},{i:.3f},{w:.4f}" for t, i, w in zip(time, current, speed, strict=True)]
    return "time_s,current_A,speed_rpm", rows


def text_with(row=None, line=None, header=None):
    first, rows = header_and_rows()
    if row is not None:
        rows[row] = line
    return "\n".join([header or first, *rows]) + "\n"


def test_a_command_ends_without_a_last_scan_for_garbage():
    code = "import atexit, gc; atexit.register(lambda: print(gc.get_freeze_count() > 0)); "
    code += "from gyrostat.cli import main; main()"
    words = [sys.executable, "-c", code, "--help"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "True"


@pytest.mark.parametrize(("given", "found"), [({}, "1"), ({"OMP_NUM_THREADS": "2"}, "None")])
def test_linear_algebra_has_one_thread_unless_told_otherwise(tmp_path, given, found):
    code = "import os, sys; from gyrostat.cli import main; main(); "
    code += "print(os.environ.get('OPENBLAS_NUM_THREADS'), 'numpy' in sys.modules)"
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    own = {name: value for name, value in os.environ.items() if name not in names}
    done = subprocess.run(
        [sys.executable, "-c", code, "cache"],
        env={**own, **given, "GYROSTAT_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=True,
    )
    # it must be set before NumPy is loaded
    assert done.stdout.splitlines()[-1] == f"{found} False"


def test_help_names_every_verb(run):
    code, out, _ = run("--help")
    assert code == 0
    for verb in ("identify", "validate", "bench", "reproduce"):
        assert verb in out


def test_identify_writes_its_three_files_and_prints_only_json(fitted):
    out, done = fitted
    written = [".gyrostat.json", "fit.json", "model.toml", "report.html"]
    assert sorted(p.name for p in out.iterdir()) == [*written, EXAMPLE.name]
    printed = json.loads(done.stdout)
    assert printed == json.loads((out / "fit.json").read_text())
    assert "coulomb" in done.stderr


def test_fit_json_keeps_its_contract(fitted):
    fit = json.loads((fitted[0] / "fit.json").read_text())
    assert {
        *("model", "converged", "iterations", "samples", "crossings", "rms_speed"),
        *("parameters", "correlation", "held", "warnings"),
    } <= set(fit)
    assert fit["model"] == "stribeck"
    assert fit["converged"] is True
    assert fit["samples"] == 3001
    assert fit["crossings"] == 9
    for name in ("motor_constant", "viscous", "coulomb", "static"):
        assert {"value", "sigma", "unit", "observable"} <= set(fit["parameters"][name])
    assert fit["parameters"]["coulomb"]["unit"] == "N·m"
    assert fit["parameters"]["coulomb"]["value"] == pytest.approx(0.8795e-3, rel=0.02)
    assert fit["parameters"]["static"]["observable"] is False
    assert fit["held"]["stribeck_speed"] == pytest.approx(0.418879)
    assert fit["held"]["inertia"] == 1.5e-3
    count = len(fit["correlation"]["names"])
    assert np.shape(fit["correlation"]["matrix"]) == (count, count)


def test_model_file_holds_the_fit(fitted):
    out, _ = fitted
    fit = json.loads((out / "fit.json").read_text())
    model = tomllib.loads((out / "model.toml").read_text())
    assert model["friction"]["coulomb"] == fit["parameters"]["coulomb"]["value"]
    assert model["wheel"]["inertia"] == 1.5e-3
    assert model["sigma"]["coulomb"] == fit["parameters"]["coulomb"]["sigma"]


def test_report_is_self_contained(fitted):
    page = (fitted[0] / "report.html").read_text()
    assert page.count('role="img"') == 9
    assert "not observable" in page
    for outside in ('src="http', 'href="http', "@import", "<script src"):
        assert outside not in page.replace("http://www.w3.org", "")


def test_bench_identify_validate_is_a_closed_circle(run, tmp_path):
    model = tmp_path / "truth.toml"
    model.write_text(MODEL)
    for seed, profile in ((1, "steps"), (2, "sines")):
        record = tmp_path / f"{profile}.csv"
        options = ("--speed-sigma", "5rpm", "--seed", seed, "--out", record)
        assert run("bench", model, "--profile", profile, *options)[0] == 0
    out = tmp_path / "fit"
    steps = tmp_path / "steps.csv"
    steps.write_text("# serial: RW-07\n# operator: A. Meyer\n" + steps.read_text())
    options = ("--inertia", "1.5e-3", "--model", "auto", "--hold", "stribeck_speed=4rpm")
    assert run("identify", steps, *options, "--out", out)[0] == 0
    fit = json.loads((out / "fit.json").read_text())
    assert fit["choices"][0] == "friction model viscous-coulomb"
    assert fit["metadata"] == [{"serial": "RW-07", "operator": "A. Meyer"}]
    assert {score["name"] for score in fit["candidates"]} >= {"current_offset", "speed_lag"}
    model = tomllib.loads((out / "model.toml").read_text())
    assert model["origin"]["serial"] == "RW-07"
    assert model["correlation"]["names"] == ["motor_constant", "viscous", "coulomb"]
    check = tmp_path / "check"
    code, stdout, _ = run(
        "validate", out / "model.toml", tmp_path / "sines.csv", "--out", check, "--json"
    )
    assert code == 0
    assert json.loads(stdout) == json.loads((check / "validation.json").read_text())
    assert json.loads(stdout)["rms_speed"] == pytest.approx(0.5236, rel=0.08)
    assert json.loads(stdout)["inside"] == pytest.approx(0.95, abs=0.03)
    assert "<svg" in (check / "validation.html").read_text()


def test_bench_gives_the_same_record_for_the_same_seed(run, tmp_path):
    model = tmp_path / "truth.toml"
    model.write_text(MODEL)
    texts = []
    for name, seed in (("a.csv", 3), ("b.csv", 3), ("c.csv", 4)):
        options = ("--duration", "60", "--jitter", "0.1", "--dropouts", "0.05", "--seed", seed)
        assert run("bench", model, "--out", tmp_path / name, *options)[0] == 0
        texts.append((tmp_path / name).read_text())
    assert texts[0] == texts[1] != texts[2]


def test_comparison_ranks_models_and_does_not_change_the_answer(run, tmp_path):
    common = ("identify", EXAMPLE, "--inertia", "1.5e-3", "--speed-sigma", "5rpm", "--json")
    code, out, _ = run(*common, "--compare", "--held-out", EXAMPLE, "--out", tmp_path / "ranked")
    ranked = json.loads(out)
    assert code == 0
    models = [row["model"] for row in ranked["comparison"]]
    assert sorted(models) == ["directional", "stribeck", "viscous-coulomb"]
    # the record cannot show T_s - c, so the criterion must not pay for it
    assert models[0] == "viscous-coulomb"
    assert all(row["held_out_rms"] > 0.0 for row in ranked["comparison"])
    # in the same process, by the same compiled programs
    plain = json.loads(run(*common, "--out", tmp_path / "plain")[1])
    assert ranked["parameters"] == plain["parameters"]


@pytest.mark.parametrize(
    "options",
    [
        ("--start", "static=9e-4"),
        ("--free", "stribeck_speed"),
        ("--prior", "static=9e-4:1e-4"),
    ],
)
def test_comparison_leaves_out_what_a_model_does_not_have(run, tmp_path, options):
    record = tmp_path / "first.csv"  # two of its minutes are enough
    record.write_text("\n".join(EXAMPLE.read_text().splitlines()[:1201]) + "\n")
    words = ("identify", record, "--inertia", "1.5e-3", "--speed-sigma", "5rpm", "--compare")
    code, out, err = run(*words, *options, "--json", "--out", tmp_path)
    assert code == 0, err
    ranked = json.loads(out)["comparison"]
    assert {row["model"] for row in ranked} == {"directional", "stribeck", "viscous-coulomb"}
    assert ranked[0]["bic"] == 0.0
    page = (tmp_path / "report.html").read_text()
    for row in ranked:
        assert (row["bic"] is not None) or (row["failure"] and row["failure"] in page)


def warm(path, temperature):
    """The example record with a column of temperature."""
    first, *rows = EXAMPLE.read_text().splitlines()
    lines = [f"{first},temperature_degC", *(f"{row},{temperature}" for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_temperatures_do_not_spoil_a_fit_of_several_records(run, tmp_path):
    pair = (warm(tmp_path / "cold.csv", 10.0), warm(tmp_path / "warm.csv", 30.0))
    words = ("identify", *pair, "--inertia", "1.5e-3", "--hold", "initial_speed_1=0")
    code, out, err = run(*words, "--speed-sigma", "5rpm,5rpm", "--json", "--out", tmp_path / "fit")
    assert code == 0, err
    result = json.loads(out)
    assert {row["parameter"] for row in result["temperature"]} >= {"viscous", "coulomb"}
    assert result["speed_sigmas"] == pytest.approx([0.5236, 0.5236], rel=1e-3)


@pytest.mark.parametrize("method", ["steady", "torque-step", "coast"])
@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--loss", "huber"), "--loss"),
        (("--held-out", EXAMPLE), "--held-out"),
        (("--current-hold", "linear"), "--current-hold"),
        (("--free", "inertia"), "--free"),
        (("--speed-sigma", "5rpm,1rpm"), "more than one --speed-sigma"),
    ],
)
def test_options_without_effect_are_refused(run, tmp_path, method, options, named):
    words = (
        "identify",
        EXAMPLE,
        "--inertia",
        "1.5e-3",
        "--method",
        method,
        "--out",
        tmp_path / "o",
    )
    code, out, err = run(*words, *options)
    assert code == 2
    assert out == ""
    assert f"--method {method}: found {named}, expected these with --method batch only" in err


def test_the_offset_of_a_drive_is_told_to_the_validation(run, tmp_path):
    model = tmp_path / "m.toml"
    model.write_text(MODEL)
    record = tmp_path / "r.csv"
    assert run("bench", model, "--speed-sigma", "5rpm", "--out", record)[0] == 0
    first, *rows = record.read_text().splitlines()
    place = first.split(",").index("current_A")
    cells = [row.split(",") for row in rows]
    shifted = [[*c[:place], repr(float(c[place]) - 0.005), *c[place + 1 :]] for c in cells]
    record.write_text("\n".join([first, *map(",".join, shifted)]) + "\n")
    rms = []
    for hold in ((), ("--hold", "current_bias=5mA")):
        code, out, err = run("validate", model, record, *hold, "--json", "--out", tmp_path / "v")
        # without the offset the model fails on this record, and the exit code says so
        assert code == (0 if hold else 1), err
        assert ("FAILS" in err) is not bool(hold)
        rms.append(json.loads(out)["rms_speed"])
    assert rms[1] == pytest.approx(0.5236, rel=0.08)
    assert rms[0] > 1.5 * rms[1]
    for hold in ("coulomb=1e-3", "current_bias"):
        code, _, err = run("validate", model, record, "--hold", hold, "--out", tmp_path / "v")
        assert code == 2
        assert "--hold" in err


def test_units_on_the_command_line(run, tmp_path):
    words = ("identify", EXAMPLE, "--inertia", "15 kg·cm²", "--hold", "stribeck_speed=4rpm")
    code, out, _ = run(*words, "--speed-sigma", "5 rpm", "--json", "--out", tmp_path)
    held = json.loads(out)["held"]
    assert code == 0
    assert held["inertia"] == pytest.approx(1.5e-3)
    assert held["stribeck_speed"] == pytest.approx(0.418879, rel=1e-6)


def test_a_fit_that_does_not_converge_exits_1_and_leaves_no_model(run, tmp_path, monkeypatch):
    import gyrostat.identification.solve as solve

    monkeypatch.setattr(solve, "DEFAULT_ITERATIONS", 3)
    code, out, err = run(
        "identify", EXAMPLE, "--inertia", "1.5e-3", "--json", "--out", tmp_path / "fit"
    )
    assert code == 1
    assert json.loads(out)["converged"] is False
    assert "no valid result" in err
    assert not (tmp_path / "fit" / "model.toml").exists()


def test_a_wheel_that_cannot_exist_exits_1_and_is_refused_without_force(run, tmp_path):
    """A motor constant of the wrong sign: current and speed have opposite senses."""
    lines = EXAMPLE.read_text().splitlines()
    time, current, *_ = (name.split("_")[0] for name in lines[0].split(","))
    assert (time, current) == ("time", "current")
    opposed = [lines[0]]
    for line in lines[1:]:
        cells = line.split(",")
        opposed.append(",".join([cells[0], repr(-float(cells[1])), *cells[2:]]))
    record = tmp_path / "opposed.csv"
    record.write_text("\n".join(opposed) + "\n")
    code, out, err = run("identify", record, "--inertia", "1.5e-3", "--json", "--out", tmp_path)
    assert code == 1
    assert any("opposite senses" in reason for reason in json.loads(out)["impossible"])
    assert "no valid result" in err
    model = tmp_path / "model.toml"
    for words in (
        ("bench", model, "--duration", "5", "--out", tmp_path / "again.csv"),
        ("export", model, "--to", "json", "--out", tmp_path / "sheet"),
    ):
        code, _, err = run(*words)
        assert code == 2
        assert "--force" in err
    assert run(*words, "--force")[0] == 0
    code, _, err = run("bench", model, "--duration", "5", "--out", tmp_path / "b.csv", "--force")
    assert code == 2, "no wheel turns against its current"
    assert "motor constant" in err.replace("_", " ")


@pytest.mark.parametrize("verb", ["simulate", "campaign"])
def test_a_flight_with_a_wheel_marked_as_impossible_needs_force(run, tmp_path, verb):
    for name in ("zero_crossing_model.toml", "cubesat.toml", "cubesat_wheel.toml"):
        text = (EXAMPLE.parent / "scenarios" / name).read_text(encoding="utf-8")
        (tmp_path / name).write_text(text.replace("coulomb = 2.0e-05", "coulomb = -2.0e-05"))
    wheel = tmp_path / "cubesat_wheel.toml"
    wheel.write_text(wheel.read_text() + '\n[validity]\nimpossible = "coulomb is negative"\n')
    words = (verb, tmp_path / "zero_crossing_model.toml", "--out", tmp_path / "out.nc")
    words += ("--runs", "2", "--seed", "1") if verb == "campaign" else ()
    code, _, err = run(*words)
    assert code == 2
    assert "cubesat_wheel.toml: key validity.impossible" in err
    assert "coulomb is negative" in err
    assert "--force" in err
    code, _, err = run(*words, "--force")
    assert code == 2, "friction that drives the wheel cannot be simulated"
    assert "cubesat.toml: key wheel[" in err
    assert "coulomb: found -2e-05" in err
    assert not (tmp_path / "out.nc").exists()


def test_tolerances_on_the_command_line(run, fitted, tmp_path):
    """One per cent of inertia is one per cent of the Coulomb torque, and all of it is given."""
    words = ("identify", EXAMPLE, "--speed-sigma", "5rpm", "--json")
    tolerant = ("--inertia", "1.5e-3 +- 1 %", "--current-scale", "1.02 ± 0.5 %")
    code, out, err = run(*words, *tolerant, "--out", tmp_path)
    assert code == 0
    assert "share of variance" in err
    found = json.loads(out)["parameters"]
    shares = found["motor_constant"]["variance_shares"]
    assert shares["inertia"] / shares["current_scale"] == pytest.approx(4.0, rel=0.01)
    assert sum(shares.values()) == pytest.approx(1.0)
    assert found["inertia"] == {**found["inertia"], "given": True, "sigma": pytest.approx(1.5e-5)}
    motor = json.loads(fitted[1].stdout)["parameters"]["motor_constant"]["value"]
    assert found["motor_constant"]["value"] == pytest.approx(motor / 1.02, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (text_with(header="time_s,current_A,velo_rpm"), "speed"),
        (text_with(header="time_s,speed_rpm,speed_rpm"), "speed"),
        (text_with(header="time_s,current_A,speed_furlong"), "furlong"),
        (text_with(7, "0.70,abc,1.0"), "abc"),
        (text_with(7, "0.70,0.1,nan"), "row 9"),
        (text_with(7, "0.70,inf,1.0"), "row 9"),
        (text_with(7, "0.30,0.1,1.0"), "time"),
        (text_with(7, "0.60,0.1,1.0"), "time"),
        ("", "bad.csv"),
        ("time_s,current_A,speed_rpm\n", "bad.csv"),
    ],
)
def test_bad_records_are_refused_with_one_line(refused, text, expected):
    line = refused(text, "--inertia", "1.5e-3")
    assert "bad.csv" in line
    assert expected in line
    assert "expected" in line


def test_missing_zero_and_negative_inertia(refused):
    good = EXAMPLE.read_text()
    assert "inertia" in refused(good)
    for value in ("0", "-1.5e-3", "nan", "fast", "1.5e-3 A"):
        assert "inertia" in refused(good, f"--inertia={value}")


def test_wheel_that_never_moves_and_constant_current(refused):
    _, rows = header_and_rows(400)
    still = [f"{k * 0.1:.1f},{row.split(',')[1]},0" for k, row in enumerate(rows)]
    header = "time_s,current_A,speed_rpm"
    assert "never moves" in refused("\n".join([header, *still]), "--inertia", "1.5e-3")
    constant = [f"{k * 0.1:.1f},0.1,{k}" for k in range(400)]
    assert "constant" in refused("\n".join([header, *constant]), "--inertia", "1.5e-3")


def test_unwritable_output_folder(run, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    code, _, err = run("identify", EXAMPLE, "--inertia", "1.5e-3", "--out", blocked / "out")
    assert code == 2
    assert "expected a writable folder" in err


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_read_only_output_folder(run, tmp_path):
    tmp_path.chmod(0o500)
    code, _, err = run("identify", EXAMPLE, "--inertia", "1.5e-3", "--out", tmp_path)
    assert code == 2
    assert "Permission denied" in err


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("reproduce", "carrara"), "carrara-kuga"),
        (("bench", "MODEL", "--profile", "square"), "profile"),
        (("bench", "MODEL", "--rate", "-1"), "rate"),
        (("bench", "MODEL", "--low", "2", "--high", "1"), "current range"),
        (("bench", "MODEL", "--duration", "5 kg"), "--duration"),
        (
            (
                "bench",
                "absent.toml",
            ),
            "absent.toml",
        ),
        (("validate", "MODEL", "absent.csv"), "absent.csv"),
    ],
)
def test_wrong_usage_is_one_line_and_exit_2(run, tmp_path, words, expected):
    model = tmp_path / "m.toml"
    model.write_text(MODEL)
    code, out, err = run(*(model if w == "MODEL" else w for w in words), "--out", tmp_path / "o")
    assert code == 2
    assert out == ""
    assert expected in err
    assert len(err.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("inertia = 1.5e-3", "inertia = 0"), "wheel.inertia"),
        (("inertia = 1.5e-3", "intertia = 1.5e-3"), "did you mean wheel.inertia"),
        (("coulomb = 0.8795e-3", 'coulomb = "much"'), "friction.coulomb"),
        (("viscous = 4.83e-6\n", ""), "friction.viscous"),
        (('"stribeck"', '"dahl"'), "friction.model"),
        (("[wheel]", "[wheel"), "invalid TOML"),
        (("inertia = 1.5e-3\n", ""), "inertia"),
    ],
)
def test_bad_model_files_name_the_key(run, tmp_path, change, expected):
    model = tmp_path / "m.toml"
    model.write_text(MODEL.replace(*change))
    code, _, err = run("bench", model, "--out", tmp_path / "r.csv")
    assert code == 2
    assert expected in err
    assert not (tmp_path / "r.csv").exists()
