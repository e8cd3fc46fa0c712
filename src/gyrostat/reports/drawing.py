"""Style of figures, and figures as inline SVG."""

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.figure import Figure

WIDTH = 9.0
"""Usual width of a figure, inches."""
STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.grid": True,
    "grid.color": "#e3e5e8",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#6b7077",
    "legend.frameon": False,
    "svg.hashsalt": "gyrostat",
}


def png(figure: Figure) -> bytes:
    """PNG file of a figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100)
    return buffer.getvalue()


class Picture(Figure):
    """Figure that a notebook shows, although pyplot does not know it."""

    def _repr_png_(self) -> bytes:
        return png(self)


@contextmanager
def panels(
    rows: int = 1,
    columns: int = 1,
    *,
    height: float,
    width: float = WIDTH,
    layout: Literal["constrained"] | None = "constrained",
    **options: Any,
) -> Iterator[Any]:
    """Create a figure in the style of the reports.

    Args:
        rows: Number of rows of panels.
        columns: Number of columns of panels.
        height: Height of the figure, inches.
        width: Width of the figure, inches.
        layout: Layout engine of the figure; None for a layout that the caller adjusts.
        options: Further arguments of `matplotlib.figure.Figure.subplots`.

    Yields:
        The figure, and its axes as `subplots` returns them.
    """
    with mpl.rc_context(STYLE):
        figure = Picture(figsize=(width, height), layout=layout)
        yield figure, figure.subplots(rows, columns, **options)


def literal(name: str) -> str:
    """Escape a name for use as a label: no `$` formula, no hidden label by a leading underscore."""
    return (" " if name.startswith("_") else "") + name.replace("$", r"\$")


def svg(figure: Figure) -> str:
    """Inline SVG element of a figure; dense point clouds in it are rasterised."""
    buffer = io.BytesIO()
    with mpl.rc_context(STYLE), warnings.catch_warnings():
        # names may contain characters that the font lacks
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font", UserWarning)
        figure.savefig(buffer, format="svg", dpi=150, metadata={"Date": None})
    text = buffer.getvalue().decode()
    return text[text.index("<svg") :]
