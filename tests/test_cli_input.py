"""Hostile input to the command line: every command ends in one clear line, and in time."""

import os
import signal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from markupsafe import escape

from gyrostat.core.errors import LONGEST, InputError, one_line
from gyrostat.core.toml_file import read_toml, refuse_unknown

SOAK = Path(__file__).parents[1] / "benchmarks" / "soak_input.py"
CASES = 150
QUICK = ("bench", "export", "replay", "report", "reproduce")


@pytest.fixture(scope="module")
def soak(module_at):
    return module_at(SOAK)


@pytest.fixture
def place(soak, tmp_path, monkeypatch):
    """A folder with the files that commands name, where they run."""
    (tmp_path / "place").mkdir()
    soak.place_files(tmp_path / "place", {})
    monkeypatch.chdir(tmp_path / "place")
    return tmp_path / "place"


@pytest.fixture
def in_time():
    """An alarm in place of a hang."""

    def late(number, frame):
        raise TimeoutError("no answer in time")

    before = signal.signal(signal.SIGALRM, late)
    yield signal.alarm
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def test_commands_with_hostile_words_and_files(soak, run, tmp_path, monkeypatch, in_time):
    seen = set()
    for number, verb, words, texts in soak.cases("suite", QUICK):
        if number == CASES:
            break
        place = tmp_path / str(number)
        place.mkdir()
        soak.place_files(place, texts)
        monkeypatch.chdir(place)
        in_time(300)
        code, out, err = run(verb, *words)
        assert not soak.faults(words, code, out, err, place), (verb, words, err[-2000:])
        seen.add((verb, code))
    assert {("bench", 0), ("bench", 2), ("export", 2)} <= seen


IDENTIFY = ("identify", "record.csv", "--inertia", "1.5e-3", "--out", "out")
BENCH = ("bench", "model.toml", "--out", "out/r.csv")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((*IDENTIFY, "--ripple", "4"), "--ripple: found 4, expected 0 to 1"),
        ((*IDENTIFY, "--hold", "coulomb=-1"), "held coulomb: found -1, expected 0 N·m or more"),
        ((*IDENTIFY, "--start", "static=-1e-3"), "start of static: found -0.001, expected 0"),
        ((*IDENTIFY, "--prior", "viscous=-1:1"), "a-priori mean of viscous: found -1, expected 0"),
        ((*IDENTIFY, "--hold", "motor_constant=0"), "held motor_constant: found 0, expected more"),
        (
            (*IDENTIFY, "--prior", "coulomb=1e-3:1e-320"),
            "--prior coulomb: found '1e-320', expected",
        ),
        ((*IDENTIFY, "--speed-sigma", "1e-300"), "--speed-sigma: found '1e-300', expected"),
        ((*BENCH, "--duration", "1e12"), "1e+13 samples, expected at most 2000000 (0.14 GB"),
        ((*BENCH, "--period", "1e-9"), "period: found 1e-09 s, expected at least one sample"),
        ((*BENCH, "--seed", str(2**63)), f"seed: found {2**63}, expected 0 to {2**63 - 1}"),
        ((*BENCH, "--seed", "-1"), "seed: found -1, expected 0 to"),
        (("bench", "/dev/zero", "--out", "out/r.csv"), "/dev/zero: found a pipe or device, expec"),
        (("bench", "PIPE", "--out", "out/r.csv"), "PIPE: found a pipe or device, expected a model"),
        (("bench", "FOLDER", "--out", "out/r.csv"), "FOLDER: found a folder, expected a model"),
        (("bench", "HUGE", "--out", "out/r.csv"), "HUGE: found more than 1e+07 bytes, expected"),
        (("validate", "model.toml", "/dev/zero.csv", "--out", "o"), "/dev/zero.csv: found no read"),
        (("bench", "model.toml", "--out", "o/" + "x" * 5000 + "/r.csv"), "File name too long"),
        (("bench", "model.toml"), "bench: missing --out (see gyrostat bench --help)"),
        ((*BENCH, "--rate", "much"), "Invalid value for '--rate'"),
        ((*BENCH, "--no-such-option"), "No such option: --no-such-option"),
        (("no-such-verb",), "No such command 'no-such-verb'"),
    ],
)
def test_one_line_says_what_is_wrong(run, place, in_time, words, expected):
    in_time(300)
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert expected in err
    assert err.splitlines()[-1].startswith("error: ")
    assert err.count("error: ") == 1
    assert not [path for path in (place / "out").rglob("*") if path.is_file()]


@pytest.mark.parametrize("seed", [2**63, -1])
def test_seeds_of_scenarios_are_checked(run, place, seed):
    code, _, err = run("simulate", "scenario.toml", "--out", "r.nc", "--seed", seed)
    assert (code, err.count("error: ")) == (2, 1)
    code, _, err = run("campaign", "scenario.toml", "--runs", 2, "--out", "o", "--seed", seed)
    assert (code, err.count("error: ")) == (2, 1)


def test_a_message_is_one_line_of_less_than_a_kilobyte(run, place):
    (place / "model.toml").write_text('"' + "é\\n" * 50_000 + '" = 1\n')
    code, _, err = run(*BENCH)
    assert code == 2
    assert len(err.encode()) < 1000
    assert err.count("\n") == 1
    assert err.rstrip().endswith("validity, origin")  # what is expected stays
    for text in ("a\nb\x1b[31m\u2028", "\ud800" * 2000, "𝄞" * 2000):
        assert one_line(text).isprintable()
        assert len(one_line(text).encode(errors="backslashreplace")) <= LONGEST
    assert one_line("short: found 1 N·m") == "short: found 1 N·m"
    assert str(InputError("a\nb")) == "a\\nb"


def test_help_keeps_its_brackets(run):
    code, out, _ = run("campaign", "--help")
    assert code == 0
    assert "scenario.toml with [[dispersion]]" in out


@pytest.mark.parametrize("name", ["$\\frac$", "$x$", "a$b", "_hidden", "{x}_^", "☃"])
def test_a_wheel_may_have_any_name_in_a_figure(name):
    from gyrostat.reports.recovery import recovery_charts
    from gyrostat.reports.run_charts import run_charts

    time = np.linspace(0.0, 1.0, 5)
    history = xr.Dataset(
        {
            "error": ("time", time),
            "rate": (("time", "axis"), np.ones((5, 3))),
            **{
                key: (("time", "wheel"), np.ones((5, 1)))
                for key in ("wheel_speed", "wheel_momentum", "torque")
            },
        },
        coords={"time": time},
    )
    event = SimpleNamespace(name=name)
    values = {f"event.{name}.time": 0.5}
    scenario = SimpleNamespace(
        wheels=(name,), events=(event,), values=values, requirements=(), parts=()
    )
    charts = [chart.svg() for chart in run_charts(scenario, {}, history)]
    assert f'data-name="{escape(name)}"' in charts[2]
    assert f">{escape(name)}</text>" in charts[0]
    charts = [chart.svg() for chart in recovery_charts(history, (name,), None)]
    assert all(f'data-name="{escape(name)}"' in chart for chart in charts[2:])


def test_a_file_of_devices_is_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="pipe: found a pipe or device, expected a model file"):
        read_toml(tmp_path / "pipe", "a model file")


@pytest.mark.parametrize(
    ("verb", "file", "kind"),
    [
        ("check", "cube.toml", "a spacecraft file"),
        ("check", "cube_wheel.toml", "a model of a wheel"),
    ],
)
def test_another_kind_of_file_is_named(run, verb, file, kind):
    given = Path(__file__).parents[1] / "examples" / "scenarios" / file
    code, _, err = run(verb, str(given))
    assert code == 2
    assert f"found an unknown key; this is {kind}, expected" in err


def test_a_section_too_many_does_not_make_a_file_another_one():
    with pytest.raises(InputError, match="key body: found an unknown key, expected run, start"):
        refuse_unknown(Path("a.toml"), "", ("run", "body"), ("run", "start"))
