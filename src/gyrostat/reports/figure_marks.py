"""Marks of a panel of Matplotlib as marks of a chart of a page."""

import io
import re
from base64 import b64encode
from itertools import chain
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PathCollection, PolyCollection, QuadMesh
from matplotlib.colors import to_hex
from matplotlib.container import ErrorbarContainer
from matplotlib.image import AxesImage, imsave
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle, StepPatch
from matplotlib.text import Annotation
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.reports.axis import Axis
from gyrostat.reports.chart import COLOURS, Chart
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.thinned import thinned

MOST_POINTS = 1200
"""Largest number of points of a curve."""
MOST_SAMPLES = 4000
"""Largest number of points of a cloud."""
MOST_CELLS = 1000
"""Largest number of cells of an image along an axis."""
LARGE, THICK = 3.5, 2.0
"""Least diameter of a large point and width of a thick bar, points."""
DIM = 0.5
"""Opacity below which an area is of the lighter class."""
KINDS = {MODEL: "s0", MARK: "alert", MEASURED: "grey", "#6b7077": "grey", "#444a52": "ink"}
KINDS |= {BAND: "band", "#22262b": "ink", "#000000": "ink", "#ffffff": "paper"}
"""Class of a colour of the figures; other ones have those of further curves, in their order."""
_LEVELS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def plain_text(label: str) -> str:
    """Label of Matplotlib as plain text."""
    if "$" in label:
        label = re.sub(r"_\{?(\d+)\}?", lambda found: found[1].translate(_LEVELS), label)
    return re.sub(r"(?<!\\)\$", "", label).replace(r"\$", "$").replace("\n", " ").strip()


class Marks:
    """Draws the marks of panels into charts, with one class for each colour of a figure."""

    def __init__(self) -> None:
        """Begin a figure."""
        self._further: dict[str, str] = {}

    def kind(self, colour: Any) -> str:
        """Class of a colour."""
        name = to_hex(colour)
        if name in KINDS:
            return KINDS[name]
        further = f"s{1 + len(self._further) % (COLOURS - 1)}"
        return self._further.setdefault(name, further)

    def line_kind(self, line: Line2D) -> str:
        """Class of a curve: its colour and its strokes."""
        style = line.get_linestyle()
        strokes = {"--": " dashed", "-.": " dashed", ":": " dotted"}.get(str(style), "")
        return self.kind(line.get_color()) + strokes

    def key_of(self, handle: Artist) -> tuple[str, str]:
        """Class and path of the symbol of a legend."""
        if isinstance(handle, Line2D):
            if _is_none(handle.get_linestyle()):
                return f"points {self.kind(handle.get_color())}", "M10 4h0"
            return f"line {self.line_kind(handle)}", "M0 4H20"
        if isinstance(handle, Patch):
            return _area_kind(handle.get_facecolor()), "M0 0H20V8H0Z"
        colours = getattr(handle, "get_color", lambda: [MODEL])()
        return f"line {self.kind(colours[0])}", "M0 4H20"

    def draw(self, axes: Axes, chart: Chart, shift: float) -> None:
        """Draw the marks of a panel.

        Args:
            axes: Panel.
            chart: Chart of the same ranges.
            shift: What is subtracted from horizontal values.
        """
        caps = set(
            chain.from_iterable(
                bars.lines[1] for bars in axes.containers if isinstance(bars, ErrorbarContainer)
            )
        )
        artists = [*axes.images, *axes.collections, *axes.patches, *axes.lines]
        for artist in sorted(artists, key=Artist.get_zorder):
            if artist.get_visible() and artist not in caps:
                self._mark(artist, axes, chart, shift)
        for text in axes.texts:
            x, y = getattr(text, "xy", text.get_position())
            # a place in the frame is one of the values there
            place = text.get_transform()
            if not isinstance(text, Annotation) and place != axes.transData:
                x, y = axes.transData.inverted().transform(place.transform((x, y)))
            words = plain_text(text.get_text())
            chart.note(float(x) - shift, float(y), words, str(text.get_horizontalalignment()))

    def _mark(self, artist: Artist, axes: Axes, chart: Chart, shift: float) -> None:
        if isinstance(artist, Line2D):
            self._line(artist, axes, chart, shift)
        elif isinstance(artist, Patch):
            _patch(artist, axes, chart, shift)
        elif isinstance(artist, PolyCollection):
            for path in artist.get_paths():
                x, y = np.asarray(path.vertices).T
                chart.area(x - shift, y, _area_kind(artist.get_facecolor()[0]))
        elif isinstance(artist, LineCollection):
            ends = np.array([segment for segment in artist.get_segments() if len(segment) == 2])
            if len(ends):
                kind = self.kind(artist.get_color()[0])
                kind += " thick" if np.max(artist.get_linewidth()) >= THICK else ""
                chart.spans(ends[:, 0, 0] - shift, *np.sort(ends[:, :, 1], axis=1).T, kind)
        elif isinstance(artist, PathCollection):
            x, y = np.asarray(artist.get_offsets()).T
            colours = np.broadcast_to(artist.get_facecolor(), (len(x), 4))
            chart.dots(x - shift, y, [to_hex(colour) for colour in colours])
        elif isinstance(artist, QuadMesh):
            edges = np.asarray(artist.get_coordinates())
            values = np.asarray(artist.get_array()).reshape(np.subtract(edges.shape[:2], 1))
            x, y = edges[0, :, 0], edges[:, 0, 1]
            # an image has cells of one size: rows and columns are repeated by their widths
            colours = artist.to_rgba(values)[_even(chart.y, y)[::-1]][:, _even(chart.x, x)]
            _image(chart, colours, x[[0, -1]], y[[0, -1]])
        elif isinstance(artist, AxesImage):
            left, right, low, high = artist.get_extent()
            rows = artist.to_rgba(np.asarray(artist.get_array()))
            rows = rows[::-1] if artist.origin == "lower" else rows
            _image(chart, rows, np.array([left, right]), np.array([low, high]))

    def _line(self, line: Line2D, axes: Axes, chart: Chart, shift: float) -> None:
        x, y = (np.asarray(v, dtype=float) for v in (line.get_xdata(False), line.get_ydata(False)))
        kind = self.line_kind(line)
        if line.get_transform() == axes.get_yaxis_transform(which="grid"):
            chart.level(float(y[0]), "", kind)
        elif line.get_transform() == axes.get_xaxis_transform(which="grid"):
            chart.level(float(x[0]) - shift, "", kind, across=False)
        elif len(x):
            x, label = x - shift, str(line.get_label())
            if not _is_none(line.get_marker()):
                pick = slice(None, None, max(1, len(x) // MOST_SAMPLES))
                fine = np.isfinite(y[pick])
                # the marker "." has half of its nominal size
                size = line.get_markersize() * (0.5 if line.get_marker() == "." else 1.0)
                kind_of_points = self.kind(line.get_color()) + (" large" if size >= LARGE else "")
                chart.points(x[pick][fine], y[pick][fine], kind_of_points)
                if _is_none(line.get_markerfacecolor()):
                    chart.points(x[pick][fine], y[pick][fine], "hole")
            if not _is_none(line.get_linestyle()):
                if line.get_drawstyle() == "steps-post":
                    x, y = np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
                if len(x) > MOST_POINTS and np.all(np.diff(x) >= 0.0):
                    x, y = thinned(x, y, MOST_POINTS)
                chart.line(x, y, "" if label.startswith("_") else plain_text(label), kind)


def _is_none(style: object) -> bool:
    """Whether a marker or a style of a line is that of none."""
    return str(style) in ("None", "none", "", " ")


def _area_kind(colour: Any) -> str:
    """Class of an area."""
    name, opacity = to_hex(colour), colour[3] if len(colour) > 3 else 1.0
    if name == BAND:
        return "wide" if opacity < DIM else "narrow"
    return "bars" if name == MODEL else "pale"


def _patch(patch: Patch, axes: Axes, chart: Chart, shift: float) -> None:
    """Fill bars of a histogram, and the span of an axis."""
    kind = _area_kind(patch.get_facecolor())
    if isinstance(patch, StepPatch):
        values, edges, base = patch.get_data()
        x = np.repeat(edges, 2) - shift
        y = np.concatenate([[base], np.repeat(values, 2), [base]])
        chart.area(x, np.asarray(y, dtype=float), kind)
    elif isinstance(patch, Rectangle):
        (left, low), wide, high = patch.get_xy(), patch.get_width(), patch.get_height()
        ends, heights = (left - shift, left + wide - shift), (low, low + high)
        data = patch.get_data_transform()
        if data == axes.get_yaxis_transform(which="grid"):
            ends = (chart.x.low, chart.x.high)
        elif data == axes.get_xaxis_transform(which="grid"):
            heights = (chart.y.low, chart.y.high)
        chart.area(np.array(ends)[[0, 0, 1, 1]], np.array(heights)[[0, 1, 1, 0]], kind)


def _even(axis: Axis, edges: Vector) -> NDArray[np.intp]:
    """Index of the cell at each of evenly spaced places, from increasing edges of cells."""
    places = axis.place(edges)
    widths = np.diff(places)
    if np.ptp(widths) < 1e-6 * np.max(widths):
        return np.arange(len(widths))
    count = min(MOST_CELLS, int(np.ceil(np.sum(widths) / np.min(widths))))
    middles = places[0] + np.sum(widths) * (np.arange(count) + 0.5) / count
    return np.minimum(np.searchsorted(places, middles, side="right") - 1, len(widths) - 1)


def _image(chart: Chart, rows: Any, x: Vector, y: Vector) -> None:
    """Show the colours of cells, (rows, columns, 4), the highest row first."""
    buffer = io.BytesIO()
    imsave(buffer, np.asarray(rows), format="png")
    data = f"data:image/png;base64,{b64encode(buffer.getvalue()).decode()}"
    chart.image(data, (float(x[0]), float(x[1])), (float(y[0]), float(y[1])))
