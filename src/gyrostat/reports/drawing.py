"""Style of figures, and figures as inline SVG."""

import io
import warnings
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

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
