"""Common frame, style and thinning of the figures of all papers."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat.reports.drawing import STYLE

INK, GREY, GREEN = "#22262b", "#6b7077", "#4b8b3b"


@dataclass(frozen=True)
class Drawing:
    """A figure of a report.

    Attributes:
        title: Heading.
        figure: Figure.
        caption: Description of the content.
    """

    title: str
    figure: Figure
    caption: str


@contextmanager
def panels(rows: int = 1, columns: int = 1, *, height: float, **options: Any) -> Iterator[Any]:
    """Create a figure in the style of the reports, nine inches wide.

    Args:
        rows: Number of rows of panels.
        columns: Number of columns of panels.
        height: Height of the figure, inches.
        options: Further arguments of `matplotlib.figure.Figure.subplots`.

    Yields:
        The figure, and its axes as `subplots` returns them.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, height), layout="constrained")
        yield figure, figure.subplots(rows, columns, **options)


def label_edges(grid: np.ndarray, x: str, y: str | None = None) -> None:
    """Label the x axes of the last row and, if given, the y axes of the first column."""
    for axes in grid[-1]:
        axes.set_xlabel(x)
    for axes in grid[:, 0] if y is not None else ():
        axes.set_ylabel(y)
