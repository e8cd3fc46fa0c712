"""Version of the documentation on each page, and a list of the versions in the folders beside it.

`docs/make_versions.py` builds such folders and names the one that it builds in `DOCS_VERSION`.
"""

import os
import subprocess
from pathlib import Path

FOLDER = "DOCS_VERSION"
"""Environment variable with the name of the folder that is built; absent for a build of its own."""
SIDEBARS = (
    *("brand", "versions", "search", "scroll-start", "navigation", "scroll-end"),
    "variant-selector",
)


def described(version, folder):
    """Version of the package, with the commit if this is not the one that the version tags."""
    shown = []
    for options in (("--exact-match", "--tags"), ("--always", "--dirty=, changed", "--exclude=*")):
        command = ["git", "describe", *options]
        result = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        shown.append(result.stdout.strip() if result.returncode == 0 else "")
    tag, commit = shown
    is_released = tag.removeprefix("v") == version or not commit
    return version if is_released else f"{version} and later changes, commit {commit}"


def _configure(app, config):
    config.html_sidebars = {"**": [f"sidebar/{name}.html" for name in SIDEBARS]}
    app.docs_version = described(config.version, Path(app.srcdir))


def _page(app, page, template, context, doctree):
    folder = os.environ.get(FOLDER)
    context["docs_version"] = app.docs_version
    context["versions_folder"] = folder
    context["versions_script"] = context["pathto"]("../versions.js", 1) if folder else None


def setup(app):
    """Add the version to the sidebar."""
    app.connect("config-inited", _configure)
    app.connect("html-page-context", _page)
    return {"parallel_read_safe": True}
