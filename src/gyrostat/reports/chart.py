"""Charts as inline SVG that a script can zoom: curves, bands, histograms and point clouds.

The marks of a chart are in a nested SVG element with coordinates from 0 to 1000, whatever the
units, so that zooming is a change of its `viewBox`. Axes and labels are around it; `chart.js`
draws them again after a zoom. Colours are those of classes of the page, which differ between
light, dark and print. Without the script, a chart is complete.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import wraps
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.reports.axis import Axis
from gyrostat.reports.chart_frame import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, ticks
from gyrostat.reports.svg_path import path_of

THINNEST = 2.5
"""Smallest width of a bar of `Chart.stays`, in thousandths of the plot."""
COLOURS = 8
"""Number of classes of colours for curves."""


def _mark(add: Callable[..., None]) -> Callable[..., None]:
    """Method of a chart that adds a mark, and keeps its call for a figure for papers."""

    @wraps(add)
    def kept(chart: "Chart", *arguments: Any, **options: Any) -> None:
        chart.drawn.append((add.__name__, arguments, options))
        add(chart, *arguments, **options)

    return kept


@dataclass
class Chart:
    """A chart; the methods add marks, in the order of their calls.

    Attributes:
        title: What is shown, above the plot.
        x: Horizontal axis.
        y: Vertical axis.
        attributes: Further attributes of the SVG element, name -> value.
        height: Height in the units of `WIDTH`.
        rows: Names of the values 0, 1, ... of the vertical axis, which then has no ticks.
        columns: Names of the values 0, 1, ... of the horizontal axis, which are its ticks.
        drawn: Calls of the methods that add marks: name, arguments, options.
    """

    title: str
    x: Axis
    y: Axis
    attributes: dict[str, str] = field(default_factory=dict)
    height: int = HEIGHT
    rows: Sequence[str] = ()
    columns: Sequence[str] = ()
    drawn: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = field(
        default_factory=list, init=False
    )

    def __post_init__(self):
        self._marks: list[Markup] = []
        self._labels: list[Markup] = []

    @_mark
    def line(self, x: Vector, y: Vector, name: str, kind: str = "s0") -> None:
        """Draw a curve; NaN interrupts it."""
        path = path_of(self.x.place(x), self.y.place(y))
        mark = '<path class="line {}" data-name="{}" d="{}"/>'
        self._marks.append(Markup(mark).format(kind, name, path))

    @_mark
    def band(self, x: Vector, low: Vector, high: Vector, kind: str) -> None:
        """Fill the area between two curves without NaN."""
        across = self.x.place(np.concatenate([x, x[::-1]]))
        path = path_of(across, self.y.place(np.concatenate([high, low[::-1]])))
        self._marks.append(Markup('<path class="{}" d="{}Z"/>').format(kind, path))

    @_mark
    def area(self, x: Vector, y: Vector, kind: str) -> None:
        """Fill a polygon."""
        path = path_of(self.x.place(x), self.y.place(y))
        self._marks.append(Markup('<path class="{}" d="{}Z"/>').format(kind, path))

    @_mark
    def image(self, data: str, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Show an image, an address of the kind `data:`, between values of both axes."""
        left, right = self.x.place(np.array(x))
        high, low = 1000.0 - self.y.place(np.array(y))
        mark = '<image href="{}" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}" '
        mark += 'preserveAspectRatio="none"/>'
        self._marks.append(Markup(mark).format(data, left, low, right - left, high - low))

    @_mark
    def note(self, x: float, y: float, text: str, side: str = "left") -> None:
        """Write a text at a point, which is at its "left", "center" or "right"."""
        wide, high = WIDTH - LEFT - RIGHT, self.height - TOP - BOTTOM
        across, up = (float(a.place(np.array([v]))[0]) for a, v in ((self.x, x), (self.y, y)))
        place = LEFT + wide * across / 1000.0, TOP + high * (1.0 - up / 1000.0)
        anchor = {"center": "middle", "right": "end"}.get(side, "start")
        mark = '<text class="mark at" data-x="{:.9g}" data-y="{:.9g}" x="{:.1f}" y="{:.1f}"'
        mark += ' text-anchor="{}">{}</text>'
        self._labels.append(Markup(mark).format(x, y, *place, anchor, text))

    @_mark
    def dots(self, x: Vector, y: Vector, colours: Sequence[str]) -> None:
        """Draw points with a colour each."""
        places = zip(self.x.place(x), 1000.0 - self.y.place(y), colours, strict=True)
        mark = '<path class="ring" d="M{0:.0f} {1:.0f}h0"/><path class="dot" stroke="{2}" '
        mark += 'd="M{0:.0f} {1:.0f}h0"/>'
        self._marks += [Markup(mark).format(*place) for place in places]

    @_mark
    def bars(self, edges: Vector, counts: Vector) -> None:
        """Draw a histogram, with a path of another class for a selected part of it."""
        places = self.x.place(edges)
        heights = self.y.place(counts)
        path = "".join(
            f"M{a:.1f} 1000V{1000.0 - h:.1f}H{b:.1f}V1000Z"
            for a, b, h in zip(places, places[1:], heights, strict=False)
            if h > 0.0
        )
        mark = '<path class="bars" d="{}"/><path class="chosen" d=""/>'
        self._marks.append(Markup(mark).format(path))

    @_mark
    def spans(self, x: Vector, low: Vector, high: Vector, kind: str) -> None:
        """Draw vertical lines between two values, such as error bars."""
        places = (1000.0 - self.y.place(values) for values in (low, high))
        every = zip(self.x.place(x), *places, strict=True)
        path = "".join(f"M{at:.1f} {a:.1f}V{b:.1f}" for at, a, b in every)
        self._marks.append(Markup('<path class="span {}" d="{}"/>').format(kind, path))

    @_mark
    def points(self, x: Vector, y: Vector, kind: str = "") -> None:
        """Draw points, with a path of another class for selected ones."""
        places = zip(self.x.place(x), 1000.0 - self.y.place(y), strict=True)
        path = "".join(f"M{a:.0f} {b:.0f}h0" for a, b in places)
        mark = '<path class="points{}" d="{}"/><path class="points picked" d=""/>'
        self._marks.append(Markup(mark).format(kind and f" {kind}", path))

    @_mark
    def cells(self, x: Vector, y: Vector, chosen: NDArray[np.bool_], kind: str) -> None:
        """Fill chosen cells of a grid.

        Args:
            x: Limits of the columns, (N + 1,), increasing.
            y: Limits of the rows, (M + 1,), increasing.
            chosen: Whether a cell is filled, (M, N).
            kind: Class of the cells.
        """
        across, up = self.x.place(x), 1000.0 - self.y.place(y)
        path = ""
        for k, row in enumerate(chosen):
            edges = np.flatnonzero(np.diff(np.r_[False, row, False]))
            for first, last in zip(edges[::2], edges[1::2], strict=True):
                path += f"M{across[first]:.1f} {up[k]:.1f}V{up[k + 1]:.1f}H{across[last]:.1f}"
                path += f"V{up[k]:.1f}Z"
        if path:
            self._marks.append(Markup('<path class="cells {}" d="{}"/>').format(kind, path))

    @_mark
    def stays(self, begins: Vector, ends: Vector, value: float, text: str, kind: str) -> None:
        """Draw bars from begins to ends at a value of the vertical axis, with a text above.

        Args:
            begins: Begin of each bar, (bars,).
            ends: End of each, (bars,).
            value: Value of the vertical axis.
            text: Text.
            kind: Class of the bars.
        """
        at = 1000.0 - float(self.y.place(np.array([value]))[0])
        places = zip(self.x.place(begins), self.x.place(ends), strict=True)
        path = "".join(f"M{a:.1f} {at:.1f}H{max(b, a + THINNEST):.1f}" for a, b in places)
        mark = '<path class="stay {}" d="{}"><title>{}</title></path>'
        self._marks.append(Markup(mark).format(kind, path, text))
        high = self.height - TOP - BOTTOM
        self._labels.append(
            Markup('<text class="mark" data-y="{:.9g}" x="{}" y="{:.1f}">{}</text>').format(
                value + (self.y.high - self.y.low) * 3.0 / high,
                *(LEFT + 3, TOP + high * at / 1000.0 - 6.0, text),
            )
        )

    @_mark
    def level(self, value: float, name: str, kind: str, *, across: bool = True) -> None:
        """Draw a line at a value of the vertical axis (`across`) or of the horizontal one.

        A value beyond the axis is named at the edge of the plot.

        Args:
            value: Value.
            name: Label; none if empty.
            kind: Class of the line: "required", "percentile" or "event".
            across: Whether the line is horizontal.
        """
        axis = self.y if across else self.x
        position = float(axis.place(np.array([value]))[0])
        is_inside = 0.0 <= position <= 1000.0
        if is_inside:
            at = 1000.0 - position if across else position
            path = f"M0 {at:.1f}H1000" if across else f"M{at:.1f} 0V1000"
            mark = '<path class="{}" d="{}"><title>{}</title></path>'
            self._marks.append(Markup(mark).format(kind, path, name))
        elif name:
            arrow = ("↑" if across else "→") if position > 1000.0 else ("↓" if across else "←")
            name = f"{arrow} {name}"
        if name:
            self._label(value, position, name, kind, across=across, is_inside=is_inside)

    def _label(
        self, value: float, position: float, name: str, kind: str, *, across: bool, is_inside: bool
    ) -> None:
        wide, high = WIDTH - LEFT - RIGHT, self.height - TOP - BOTTOM
        share = min(max(position / 1000.0, 0.0), 1.0)
        above = sum("data-" not in label for label in self._labels)
        if across and is_inside:
            x, y = WIDTH - RIGHT - 3.0, TOP + high * (1.0 - share) + (-3.0 if share < 0.9 else 13.0)
        elif across:
            # beside the title, where no line is; further ones below
            x, y = WIDTH - RIGHT - 3.0, 14.0 if above == 0 else TOP - 1.0 + 12.0 * above
        else:
            x, y = LEFT + wide * share, TOP + 11.0 + 12.0 * len(self._labels)
        end = across or share > 0.6
        x += 0.0 if across else (-3.0 if end else 3.0)
        where = Markup(' data-{}="{}"').format("y" if across else "x", f"{value:.9g}")
        self._labels.append(
            Markup('<text class="mark {}"{} x="{}" y="{}"{}>{}</text>').format(
                kind,
                where if is_inside else Markup(),
                f"{x:.1f}",
                f"{y:.1f}",
                Markup(' text-anchor="end"' if end else ""),
                name,
            )
        )

    def __html__(self) -> Markup:
        """The chart as a template of a page shows it."""
        return self.svg()

    def svg(self) -> Markup:
        """The chart as an SVG element."""
        wide, high = WIDTH - LEFT - RIGHT, self.height - TOP - BOTTOM
        parts = [
            Markup('<svg class="chart" viewBox="0 0 {} {}" role="img" aria-label="{}"{}>').format(
                WIDTH,
                self.height,
                f"{self.title} over {self.x.label}",
                Markup("").join(
                    Markup(' data-{}="{}"').format(*pair) for pair in self.attributes.items()
                ),
            ),
            Markup('<text class="title" x="{}" y="14">{}</text>').format(LEFT - 44, self.title),
            Markup('<g class="axes">'),
            *ticks(self.x, self.y, self.height, self.rows, self.columns),
            Markup("</g>"),
            Markup(
                '<svg class="plot" x="{}" y="{}" width="{}" height="{}" viewBox="0 0 1000 1000" '
                'preserveAspectRatio="none" data-x="{:.9g} {:.9g}" data-y="{:.9g} {:.9g}"{}>'
            ).format(
                *(LEFT, TOP, wide, high, self.x.low, self.x.high, self.y.low, self.y.high),
                Markup("").join(
                    Markup(' data-{}="{}"').format(name, text)
                    for name, text in self._scales().items()
                    if text is not None
                ),
            ),
            *self._marks,
            Markup("</svg>"),
            *self._labels,
            Markup('<text class="label" x="{}" y="{}">{}</text></svg>').format(
                LEFT + wide / 2, self.height - 5, self.x.label
            ),
        ]
        return Markup("").join(parts)

    def _scales(self) -> dict[str, str | None]:
        """What the script needs to know of axes that are not linear."""
        return {
            "log": "" if self.y.is_log else None,
            "logx": "" if self.x.is_log else None,
            "linear": f"{self.y.linear:.9g}" if self.y.linear else None,
            "rows": "|".join(self.rows) or None,
            "columns": "|".join(self.columns) or None,
            "since": self.x.since or None,
        }
