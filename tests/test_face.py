"""The public names of the package, and the command line held against them."""

import inspect
import pickle
import re
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

import gyrostat as gs
from gyrostat.cli import app
from gyrostat.core.argument_names import naming_arguments

ROOT = Path(__file__).parents[1]
MOST_NAMES = 57
ALIASES = {"holdable": "feasible"}
"""Old name of a verb -> its name."""
NOT_OPTIONS = {"say", "command", "on_progress", "changes"}
"""Arguments of a verb that a command line has no use for."""

VERBS = typer.main.get_command(app).commands


def test_the_root_has_few_names_and_each_can_be_imported():
    assert len(set(gs.__all__) - {"__version__"}) <= MOST_NAMES
    assert len(set(gs.__all__)) == len(gs.__all__)
    assert set(gs.__all__) <= set(dir(gs))
    for name in gs.__all__:
        assert getattr(gs, name) is not None
    with pytest.raises(AttributeError, match="no_such_name"):
        gs.no_such_name  # noqa: B018


def test_the_stub_re_exports_each_name_for_type_checkers():
    """Only `import a as a` makes a name of a stub public."""
    stub = (ROOT / "src" / "gyrostat" / "__init__.pyi").read_text(encoding="utf-8")
    lines = [line for line in stub.splitlines() if "import" in line and line[0] != '"']
    assert [m for m in lines if not re.fullmatch(r"from [\w.]+ import (\w+) as \1", m)] == []
    assert len(lines) == len(gs.__all__) - 1


def test_every_name_is_documented():
    page = (ROOT / "docs" / "api" / "index.md").read_text(encoding="utf-8")
    section = page.partition("## gyrostat\n")[2].partition("\n## ")[0]
    summary = section.partition(".. autosummary::")[2]
    named = {*re.findall(r"`gs\.(\w+)[` ]", section), *re.findall(r"^   (\w+)$", summary, re.M)}
    assert named == set(gs.__all__) - {"__version__"}


@pytest.mark.parametrize(
    "code", ["import gyrostat", "import gyrostat as gs; gs.identify, gs.campaign, gs.export"]
)
def test_neither_the_package_nor_its_verbs_load_what_they_do_not_yet_need(code):
    code += "\nimport sys; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"numpy", "jax", "equinox", "scipy", "matplotlib", "pyarrow", "xarray", "typer"}
    assert set(done.stdout.split()) & heavy == set()


def name_of(option):
    return max(option.opts, key=len).lstrip("-").replace("-", "_")


def plain(default):
    """A default as it is compared: numbers as numbers, whether text or not; nothing as None."""
    if isinstance(default, str):
        try:
            default = tuple(float(part) for part in default.split(","))
        except ValueError:
            return default or None
    if isinstance(default, int | float):
        default = (float(default),)
    return default if default and any(default) else None


@pytest.mark.parametrize("verb", sorted(VERBS))
def test_a_verb_of_the_command_line_is_a_function_with_the_same_options(verb):
    arguments = inspect.signature(getattr(gs, ALIASES.get(verb, verb).replace("-", "_"))).parameters
    own = {name.rstrip("_"): a.default for name, a in arguments.items() if name not in NOT_OPTIONS}
    options = {name_of(option): option for option in VERBS[verb].params}
    options.pop("json", None)  # the result says it
    assert set(options) == set(own)
    for name, option in options.items():
        needed = own[name] is inspect.Parameter.empty
        assert needed == option.required or name == "out"
        if not needed and not option.required:
            assert plain(option.default) == plain(own[name]), name


def test_the_old_name_of_a_verb_says_so():
    for old, new in ALIASES.items():
        assert f"`{new}`" in VERBS[old].help


def test_messages_name_the_arguments_of_python_and_the_options_of_a_command(tmp_path, run):
    model = tmp_path / "model.toml"
    with pytest.raises(gs.InputError, match=r"^on_bad: found 'jump', expected one of hold, zero$"):
        gs.export(model, out=tmp_path / "out", to="c", on_bad="jump")
    with pytest.raises(gs.InputError, match=r"^what: found 'nothing', expected one of"):
        gs.export(model, out=tmp_path / "out", to="c", what="nothing")
    code, _, err = run("export", model, "--to", "c", "--what", "nothing", "--out", tmp_path)
    assert code == 2
    assert err.startswith("error: --what: found 'nothing', expected one of")


def test_other_dashes_of_a_message_stay():
    def verb(*, keep=None, range_=None):
        raise gs.InputError("--keep: found 2; --range a; --other-option; a--b; --")

    with pytest.raises(gs.InputError, match=r"^keep: found 2; range_ a; --other-option; a--b; --$"):
        naming_arguments(verb)()


def test_a_verb_can_be_passed_to_another_process():
    assert pickle.loads(pickle.dumps(gs.campaign)) is gs.campaign
