"""Files of figures for papers: vector graphics with text as text, 7 inches wide."""

import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from gyrostat.core.outputs import new_files
from gyrostat.reports.drawing import STYLE

WIDE = 7.0
"""Width of a figure, inches: that of a page with two columns."""
RESOLUTION = 300
"""Resolution of PNG files and of dense clouds of points, dots per inch."""
PRINTED: dict[Any, Any] = {**STYLE, "pdf.fonttype": 42, "svg.fonttype": "none"}
"""Style of the reports, with fonts that programs for drawing can edit."""


def figure_files(kind: str, figures: Mapping[str, Figure]) -> dict[str, bytes]:
    """Name and content of the file of each figure.

    Args:
        kind: "pdf", "svg" or "png".
        figures: Name without suffix -> figure.
    """
    return {f"{name}.{kind}": _content(figure, kind) for name, figure in figures.items()}


def write_figures(
    figures: Mapping[str, Figure],
    out: Path,
    kind: str,
    *,
    by: str,
    say: Callable[[str], None],
    force: bool,
) -> None:
    """Write the file of each figure.

    Args:
        figures: Name without suffix -> figure.
        out: Folder.
        kind: "pdf", "svg" or "png".
        by: Verb that writes them, see `gyrostat.core.outputs`.
        say: Called with the line that names the files.
        force: Whether to replace files that the verb did not write.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    files = figure_files(kind, figures)
    with new_files(out, by=by, force=force) as folder:
        for name, content in files.items():
            (folder / name).write_bytes(content)
    say(f"written: {', '.join(str(out / name) for name in files)}")


def _content(figure: Figure, kind: str) -> bytes:
    buffer = io.BytesIO()
    wide, high = figure.get_size_inches()
    # no date: equal results are equal files
    about = {"pdf": {"CreationDate": None}, "svg": {"Date": None}, "png": {"Software": None}}
    with mpl.rc_context(PRINTED):
        figure.set_size_inches(WIDE, high * max(WIDE / wide, 0.85))
        figure.savefig(buffer, format=kind, dpi=RESOLUTION, metadata=about[kind])
        figure.set_size_inches(wide, high)
    return buffer.getvalue()
