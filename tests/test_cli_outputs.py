"""Verbs and the files of others: refused in one line before work begins, replaced by --force."""

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
RECORD, MODEL = EXAMPLES / "wheel_profile2.csv", EXAMPLES / "truth.toml"
WHEELS = EXAMPLES / "three_wheels.toml"
ATTITUDE = ("--target", "1,0,0,0")
VERBS = {
    "identify": ("fit.json", "", (RECORD, "--inertia", "1.5e-3")),
    "validate": ("validation.html", "", (MODEL, RECORD)),
    "compare": ("comparison.json", "", (MODEL, MODEL)),
    "pool": ("pool.json", "", (MODEL, MODEL)),
    "lot": ("lot.json", "", (MODEL,)),
    "bench": ("r.csv", "r.csv", (MODEL, "--duration", "20")),
    "holdable": ("report.html", "", (WHEELS, "--momentum", "0,0,0", *ATTITUDE)),
    "recover": ("run.nc", "", (WHEELS, "--failed", "x=seized", "--wheels", "0,0,0", *ATTITUDE)),
    "simulate": ("r.html", "r.nc", (EXAMPLES / "scenarios" / "zero_crossing_model.toml",)),
    "export": ("wheel.json", "", (MODEL, "--to", "json")),
    "reproduce": ("claims.json", "", ("carrara-kuga", "--quick")),
}


@pytest.mark.parametrize("verb", VERBS)
def test_a_file_of_the_user_is_refused(run, tmp_path, verb):
    file, out, words = VERBS[verb]
    (tmp_path / file).write_text("mine")
    code, printed, said = run(verb, *words, "--out", tmp_path / out)
    assert (code, printed) == (2, "")
    line = said.splitlines()[-1]
    assert line.startswith(f"error: {tmp_path / file}: found a file that gyrostat {verb} did not")
    assert "--force" in line
    assert (tmp_path / file).read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == [file]


@pytest.mark.parametrize("verb", ["bench", "export"])
def test_the_same_command_replaces_its_own_files_alone(run, tmp_path, verb):
    file, out, words = VERBS[verb]
    command = (verb, *words, "--out", tmp_path / out)
    assert run(*command)[0] == 0
    content = (tmp_path / file).read_bytes()
    assert run(*command)[0] == 0
    (tmp_path / file).write_bytes(content + b"my own line\n")
    code, _, said = run(*command)
    assert code == 2
    assert f"was changed since gyrostat {verb} wrote it" in said
    assert run(*command, "--force")[0] == 0
    assert (tmp_path / file).read_bytes() == content


def test_flight_code_does_not_take_the_place_of_a_project(run, tmp_path):
    (tmp_path / "real").write_text("mine")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "README.md").symlink_to(tmp_path / "real")
    words = ("--to", "c", "--what", "wheel", "--period", "100ms", "--out", tmp_path / "out")
    code, _, said = run("export", MODEL, *words)
    assert code == 2
    assert "README.md: found a symbolic link" in said
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["README.md"]
    assert (tmp_path / "real").read_text() == "mine"
