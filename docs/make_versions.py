"""Documentation of several versions, side by side in one folder: python docs/make_versions.py.

    python docs/make_versions.py v0.1.0 HEAD --into docs/_build/versions

builds the documentation of each commit from a work tree of its own, by its own source, into
`0.1.0` and `development`: a tag names its folder, another commit is the development. It then
writes versions.js, which the pages read, and a list of the versions, index.html. Folders that are
there already stay, and are listed too. All of it works from files, without a server.
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from html import escape
from pathlib import Path

from version_switcher import FOLDER

ROOT = Path(__file__).parents[1]
DEVELOPMENT = "development"
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>gyrostat: documentation by version</title>
<style>
:root {{ color-scheme: light dark; }}
body {{ font: 1rem/1.5 sans-serif; margin: 2rem auto; max-width: 40rem; padding: 0 1rem; }}
</style>
</head><body><h1>Documentation of gyrostat</h1>
<ul>
{items}
</ul></body></html>
"""


def _git(*words, cwd):
    return subprocess.run(["git", *words], cwd=cwd, check=True, capture_output=True, text=True)


def folder_of(commit, repository):
    """Name of the folder of a commit: its version if it is a tag."""
    found = _git("tag", "--list", commit, cwd=repository).stdout.split()
    return commit.removeprefix("v") if commit in found else DEVELOPMENT


def build(commit, into, repository=ROOT, options=("-W", "--keep-going")):
    """Build the documentation of a commit; returns its folder.

    Args:
        commit: Tag or other commit.
        into: Folder of all versions.
        repository: Repository with the commit.
        options: Further options of Sphinx.
    """
    folder = into / folder_of(commit, repository)
    with tempfile.TemporaryDirectory() as scratch:
        tree = Path(scratch) / "tree"
        _git("worktree", "add", "--detach", str(tree), commit, cwd=repository)
        try:
            command = [sys.executable, "-m", "sphinx", *options, "-q", "-b", "html"]
            environment = {**os.environ, FOLDER: folder.name, "PYTHONPATH": str(tree / "src")}
            parts = [str(tree / "docs"), str(folder.resolve()), "-d", f"{scratch}/doctrees"]
            subprocess.run([*command, *parts], check=True, env=environment, cwd=tree)
        finally:
            _git("worktree", "remove", "--force", str(tree), cwd=repository)
    return folder


def _order(name):
    """The development first, then versions from the newest to the oldest."""
    numbers = tuple(map(int, re.findall(r"\d+", name)))
    return (name == DEVELOPMENT, numbers, name)


def list_versions(into):
    """Write versions.js and index.html for the versions in a folder; returns their names."""
    folders = [folder for folder in into.iterdir() if (folder / "index.html").is_file()]
    names = sorted((folder.name for folder in folders), key=_order, reverse=True)
    pages = {name: sorted(page.name for page in (into / name).glob("*.html")) for name in names}
    (into / "versions.js").write_text(f"window.gyrostatVersions = {json.dumps(pages)};\n")
    items = (f'<li><a href="{escape(name)}/index.html">{escape(name)}</a></li>' for name in names)
    (into / "index.html").write_text(PAGE.format(items="\n".join(items)), encoding="utf-8")
    return names


def main():
    """Build the named commits and list all versions."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("commits", nargs="*", help="tags or other commits; none: only the list")
    parser.add_argument("--into", type=Path, default=ROOT / "docs" / "_build" / "versions")
    arguments = parser.parse_args()
    places: dict[str, str] = {}
    for commit in arguments.commits:
        try:
            _git("rev-parse", "--verify", f"{commit}^{{commit}}", cwd=ROOT)
        except subprocess.CalledProcessError:
            parser.error(f"found {commit!r}, expected a tag or another commit of this repository")
        other = places.setdefault(folder_of(commit, ROOT), commit)
        if other != commit:
            parser.error(f"found {other} and {commit}, expected at most one commit without a tag")
    arguments.into.mkdir(parents=True, exist_ok=True)
    for folder, commit in places.items():
        shutil.rmtree(arguments.into / folder, ignore_errors=True)  # pages that are no more
        build(commit, arguments.into)
    names = list_versions(arguments.into)
    print(f"{', '.join(names)}: {arguments.into / 'index.html'}")


if __name__ == "__main__":
    main()
