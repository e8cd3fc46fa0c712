"""Documentation of several versions in folders side by side."""

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
CONF = f"""
import sys
sys.path.insert(0, {str(DOCS)!r})
sys.path.insert(0, "../src")
from small import __version__ as version
project, extensions, html_theme = "small", ["version_switcher"], "furo"
templates_path, html_static_path = [{str(DOCS / "_templates")!r}], [{str(DOCS / "_static")!r}]
"""


@pytest.fixture(scope="module")
def make_versions():
    sys.path.insert(0, str(DOCS))
    yield import_module("make_versions")
    sys.path.remove(str(DOCS))


@pytest.fixture(scope="module")
def built(make_versions, tmp_path_factory):
    """Folder with version 0.9 and the development, which has one page more."""
    for name in ("furo", "sphinx"):
        pytest.importorskip(name, reason=f"{name}, of the extra docs, is not installed")
    repository, into = tmp_path_factory.mktemp("small"), tmp_path_factory.mktemp("versions")

    def git(*words):
        names = ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"]
        command = ["git", *names, *words]
        subprocess.run(command, cwd=repository, check=True, capture_output=True)

    def commit(version, pages):
        (repository / "docs").mkdir(exist_ok=True)
        (repository / "src").mkdir(exist_ok=True)
        (repository / "docs" / "conf.py").write_text(CONF)
        (repository / "src" / "small.py").write_text(f'__version__ = "{version}"\n')
        for page in pages:
            (repository / "docs" / f"{page}.rst").write_text(f"{page}\n=====\n\n.. toctree::\n")
        git("add", ".")
        git("commit", "-m", version)

    git("init", "-q")
    commit("0.9", ["index", "first"])
    git("tag", "v0.9")
    commit("0.10", ["added"])
    for each in ("v0.9", "HEAD"):
        make_versions.build(each, into, repository, options=())
    assert not (repository / ".git" / "worktrees").exists()
    assert "small" not in sys.modules
    assert "DOCS_VERSION" not in os.environ
    assert make_versions.list_versions(into) == ["development", "0.9"]
    return into


def test_each_page_has_its_version(built):
    of_tag = (built / "0.9" / "first.html").read_text()
    of_head = (built / "development" / "first.html").read_text()
    assert "<p>Version 0.9</p>" in of_tag
    assert "<p>Version 0.10 and later changes, commit " in of_head
    assert '<a href="0.9/index.html">0.9</a>' in (built / "index.html").read_text()


def test_the_list_leads_to_the_same_page_or_to_the_first_one(built, browser):
    select = "document.querySelector('.versions select')"

    def choose(name):
        # later, so that the answer is not lost with the page
        change = f"{select}.value = '{name}', {select}.onchange()"
        browser.ask(f"setTimeout(() => ({change}), 50)")
        while browser._message().get("method") != "Page.loadEventFired":
            pass
        return browser.ask("location.pathname").removeprefix(str(built))

    browser.open((built / "0.9" / "first.html").as_uri())
    assert browser.ask(f"[...{select}.options].map(o => o.value)") == ["development", "0.9"]
    assert browser.ask(f"{select}.value") == "0.9"
    assert choose("development") == "/development/first.html"
    browser.open((built / "development" / "added.html").as_uri())
    assert choose("0.9") == "/0.9/index.html"


def test_versions_are_ordered_as_numbers(make_versions, tmp_path):
    for name in ("0.9.0", "0.10.0", "development", "notes"):
        (tmp_path / name).mkdir()
        if name != "notes":
            (tmp_path / name / "index.html").write_text("")
    assert make_versions.list_versions(tmp_path) == ["development", "0.10.0", "0.9.0"]
