"""One error names every option that is missing, and the help to read."""

from pathlib import Path

import pytest
import typer.main

from gyrostat.cli import app
from gyrostat.verbs.part_kinds import PARTS

VERBS = typer.main.get_command(app).commands
EXAMPLES = Path(__file__).parents[1] / "examples"
MODEL = "no_such_model.toml"


@pytest.mark.parametrize("verb", sorted(VERBS))
def test_every_required_option_is_named_at_once(run, verb):
    required = [option for option in VERBS[verb].params if option.required]
    if not required:
        return
    code, out, err = run(verb)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith(f"error: {verb}: missing ")
    assert err.rstrip().endswith(f"(see gyrostat {verb} --help)")
    for option in required:
        is_option = option.param_type_name == "option"
        name = max(option.opts, key=len) if is_option else option.name.upper()
        assert f"{name};" in err or f"{name} (see" in err


@pytest.mark.parametrize("part", PARTS)
def test_an_export_names_all_options_of_a_part_at_once(run, part):
    code, _, err = run("export", MODEL, "--what", part)
    assert code == 2
    for option in ("--out", "--to", "--period", *PARTS[part].needs):
        assert option in err


def test_an_export_without_a_part_names_the_options_of_each_part(run):
    _, _, err = run("export", MODEL, "--to", "c")
    for words in ("--out", "--what", "--period", "estimator: --speed-sigma, --scale-drift"):
        assert words in err


def test_the_export_of_a_scenario_or_a_data_sheet_needs_no_part(run):
    scenario = EXAMPLES / "scenarios" / "zero_crossing_model.toml"
    for words, last in (((scenario, "--to", "c"), "--out"), ((MODEL, "--to", "json"), "--out")):
        _, _, err = run("export", *words)
        assert err == f"error: export: missing {last} (see gyrostat export --help)\n"


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("identify", "--no-such"), "(see gyrostat identify --help)"),
        (("bench", "m.toml", "--out", "r.csv", "--rate", "much"), "(see gyrostat bench --help)"),
        (("no-such-verb",), "(see gyrostat --help)"),
    ],
)
def test_the_hint_names_the_verb(run, words, hint):
    code, _, err = run(*words)
    assert code == 2
    assert err.rstrip().endswith(hint)
