"""Figures of all papers: their frame in a report, further colours, labels of a grid."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

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


def label_edges(grid: np.ndarray, x: str, y: str | None = None) -> None:
    """Label the x axes of the last row and, if given, the y axes of the first column."""
    for axes in grid[-1]:
        axes.set_xlabel(x)
    for axes in grid[:, 0] if y is not None else ():
        axes.set_ylabel(y)
