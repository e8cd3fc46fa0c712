"""JAX of a version from which no C can be generated: one line, and JAX where that is possible."""

import tomllib
from pathlib import Path

import pytest

import gyrostat as gs
from gyrostat.codegen.jax_versions import LOWEST, NEWEST, UnsupportedVersionError, require_supported
from gyrostat.core.jax64 import jax

ROOT = Path(__file__).parents[2]
SCENARIO = ROOT / "examples" / "scenarios" / "zero_crossing_model.toml"
FOUND = "JAX: found version 0.99.1, expected 0.10 to 0.12 to generate C"


@pytest.fixture
def unknown(monkeypatch):
    monkeypatch.setattr(jax, "__version__", "0.99.1")


@pytest.mark.parametrize("version", ["0.9.2", "0.13.0", "1.10.0", "unknown"])
def test_versions_outside_the_range_are_refused(monkeypatch, version):
    monkeypatch.setattr(jax, "__version__", version)
    with pytest.raises(UnsupportedVersionError, match=f"found version {version}, expected"):
        require_supported()


@pytest.mark.parametrize(
    "version", ["0.10.0", "0.10.2", "0.11.1", "0.12.0.1", "0.12.3.dev20261101"]
)
def test_versions_within_the_range_are_accepted(monkeypatch, version):
    monkeypatch.setattr(jax, "__version__", version)
    require_supported()


def test_range_is_that_of_the_package_metadata():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    bounds = f"jax>={LOWEST[0]}.{LOWEST[1]},<{NEWEST[0]}.{NEWEST[1] + 1}"
    assert bounds in project["dependencies"]


@pytest.mark.parametrize(
    "words",
    [
        ("simulate", SCENARIO, "--engine", "native", "--out", "run.nc"),
        ("campaign", SCENARIO, "--engine", "native", "--runs", 64, "--out", "out"),
        ("campaign", SCENARIO, "--rare", "error_max > 1 deg", "--runs", 20000, "--out", "out"),
        ("campaign", SCENARIO, "--worst-case", "error_max", "--runs", 20000, "--out", "out"),
        (
            *("tune", SCENARIO, "--free", "controller.rate_gain", "--minimise", "error_p95"),
            *("--runs", 50000, "--out", "out"),
        ),
        ("export", SCENARIO, "--to", "c", "--out", "out"),
    ],
    ids=["simulate", "campaign", "rare", "worst case", "tune", "export"],
)
def test_verbs_that_need_c_end_with_one_line(run, unknown, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    code, out, error = run(*words)
    assert code == 2
    assert out == ""
    refusals = [line for line in error.splitlines() if line.startswith("error: ")]
    assert len(refusals) == 1
    assert FOUND in refusals[0]
    assert "Traceback" not in error
    assert not (tmp_path / "run.nc").exists()


def test_auto_uses_jax_with_one_line(run, unknown, short, tmp_path):
    code, _, error = run("simulate", short('kind = "three_axis"'), "--out", tmp_path / "run.nc")
    assert code == 0
    lines = [line for line in error.splitlines() if FOUND in line]
    assert len(lines) == 1
    assert lines[0].endswith("using the engine JAX, which is some 30 times slower")


def test_python_says_it_on_stderr(unknown, short, capsys):
    gs.simulate(short('kind = "three_axis"'))
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith(FOUND)
