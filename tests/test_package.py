"""What a user of the wheel or of the source distribution gets: names, versions, commands."""

import re
import tomllib
from pathlib import Path

import gyrostat
from gyrostat.core.extras import EXTRAS, missing

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_extras_are_those_of_the_package_metadata():
    for extra, packages in EXTRAS.items():
        assert list(packages) == PROJECT["optional-dependencies"][extra]


def test_missing_package_names_the_command_that_installs_it():
    assert str(missing("--posterior", "blackjax", "posterior")) == (
        "--posterior: found no blackjax, expected the packages of the extra posterior: "
        "pip install 'blackjax>=1.2'"
    )


def test_no_text_sends_a_user_to_the_package_index_for_gyrostat():
    """The name gyrostat is not registered there."""
    texts = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    for folder in ("src", "docs", "examples"):
        texts += [p for p in (ROOT / folder).rglob("*") if p.suffix in {".py", ".md", ".toml"}]
    command = re.compile(r"(pip3?|uv|pipx) +(add|install)[^\n]*\bgyrostat\b(?!-)|gyrostat\[")
    found = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in texts
        if "_build" not in path.parts
        for line in path.read_text(encoding="utf-8").splitlines()
        if command.search(line)
    ]
    assert found == []


def test_citation_and_changelog_have_the_version_of_the_package():
    assert f"\nversion: {gyrostat.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"\n## [{gyrostat.__version__}]" in (ROOT / "CHANGELOG.md").read_text()
    assert "version" in PROJECT["dynamic"]


def test_command_line_prints_the_version(run):
    assert run("--version") == (0, f"gyrostat {gyrostat.__version__}\n", "")
