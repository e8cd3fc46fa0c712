"""Charts as inline SVG that a script can zoom: curves, bands, histograms and point clouds.

The marks of a chart are in a nested SVG element with coordinates from 0 to 1000, whatever the
units, so that zooming is a change of its `viewBox`. Axes and labels are around it; `chart.js`
draws them again after a zoom. Colours are those of classes of the page, which differ between
light, dark and print. Without the script, a chart is complete.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.reports.axis import Axis, axis_of
from gyrostat.reports.thinned import thinned

WIDTH, HEIGHT = 440, 236
"""Size of a chart in its own units, which are pixels on a page of common width."""
LEFT, RIGHT, TOP, BOTTOM = 52, 10, 24, 38
THINNEST = 2.5
"""Smallest width of a bar of `Chart.stays`, in thousandths of the plot."""
COLOURS = 8
"""Number of classes of colours for curves."""


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
    """

    title: str
    x: Axis
    y: Axis
    attributes: dict[str, str] = field(default_factory=dict)
    height: int = HEIGHT
    rows: Sequence[str] = ()

    def __post_init__(self):
        self._marks: list[Markup] = []
        self._labels: list[Markup] = []

    def line(self, x: Vector, y: Vector, name: str, kind: str = "s0") -> None:
        """Draw a curve; NaN interrupts it."""
        path = _path(self.x.place(x), self.y.place(y))
        mark = '<path class="line {}" data-name="{}" d="{}"/>'
        self._marks.append(Markup(mark).format(kind, name, path))

    def band(self, x: Vector, low: Vector, high: Vector, kind: str) -> None:
        """Fill the area between two curves without NaN."""
        across = self.x.place(np.concatenate([x, x[::-1]]))
        path = _path(across, self.y.place(np.concatenate([high, low[::-1]])))
        self._marks.append(Markup('<path class="{}" d="{}Z"/>').format(kind, path))

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

    def spans(self, x: Vector, low: Vector, high: Vector, kind: str) -> None:
        """Draw vertical lines between two values, such as error bars."""
        places = (1000.0 - self.y.place(values) for values in (low, high))
        every = zip(self.x.place(x), *places, strict=True)
        path = "".join(f"M{at:.1f} {a:.1f}V{b:.1f}" for at, a, b in every)
        self._marks.append(Markup('<path class="span {}" d="{}"/>').format(kind, path))

    def points(self, x: Vector, y: Vector, kind: str = "") -> None:
        """Draw points, with a path of another class for selected ones."""
        places = zip(self.x.place(x), 1000.0 - self.y.place(y), strict=True)
        path = "".join(f"M{a:.0f} {b:.0f}h0" for a, b in places)
        mark = '<path class="points{}" d="{}"/><path class="points picked" d=""/>'
        self._marks.append(Markup(mark).format(kind and f" {kind}", path))

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
            *self._axes(),
            Markup("</g>"),
            Markup(
                '<svg class="plot" x="{}" y="{}" width="{}" height="{}" viewBox="0 0 1000 1000" '
                'preserveAspectRatio="none" data-x="{:.9g} {:.9g}" data-y="{:.9g} {:.9g}"{}>'
            ).format(
                *(LEFT, TOP, wide, high, self.x.low, self.x.high, self.y.low, self.y.high),
                Markup(' data-log=""' if self.y.is_log else "")
                + (Markup(' data-rows="{}"').format("|".join(self.rows)) if self.rows else ""),
            ),
            *self._marks,
            Markup("</svg>"),
            *self._labels,
            Markup('<text class="label" x="{}" y="{}">{}</text></svg>').format(
                LEFT + wide / 2, self.height - 5, self.x.label
            ),
        ]
        return Markup("").join(parts)

    def _axes(self) -> "Sequence[Markup]":
        """Grid, ticks and their numbers."""
        wide, high = WIDTH - LEFT - RIGHT, self.height - TOP - BOTTOM
        ticks = []
        for value in self.x.ticks():
            position = float(self.x.place(np.array([value]))[0])
            at = LEFT + wide * position / 1000.0
            grid = Markup('<path d="M{:.1f} {}V{}"/>').format(at, TOP, self.height - BOTTOM)
            text = Markup('<text class="x" x="{:.1f}" y="{}">{}</text>')
            ticks.append(grid + text.format(at, self.height - BOTTOM + 14, number(value)))
        for value in [] if self.rows else self.y.ticks(7 * self.height // HEIGHT):
            position = float(self.y.place(np.array([value]))[0])
            at = TOP + high * (1.0 - position / 1000.0)
            grid = Markup('<path d="M{} {:.1f}H{}"/>').format(LEFT, at, WIDTH - RIGHT)
            text = Markup('<text class="y" x="{}" y="{:.1f}">{}</text>')
            ticks.append(grid + text.format(LEFT - 5, at + 4, number(value)))
        return ticks


def number(value: float) -> str:
    """Number of a tick."""
    return f"{value:.6g}".replace("e-0", "e-").replace("e+0", "e").replace("-", "−")


def held(time: Vector, commands: Matrix) -> tuple[Vector, Matrix]:
    """Times and values of commands, (samples, curves), each of which is held until the next."""
    return np.repeat(time, 2)[1:], np.repeat(commands, 2, axis=0)[:-1]


def time_chart(
    time: Vector,
    values: Matrix,
    title: str,
    names: Sequence[str],
    most: int,
    *,
    is_log: bool = False,
) -> Chart:
    """Chart of some curves, (samples, curves), over time, s, with at most `most` points each."""
    x = Axis(float(time[0]), float(time[-1]), "time (s)")
    chart = Chart(title, x, axis_of(values.ravel(), "", is_log=is_log))
    for k, name in enumerate(names):
        chart.line(*thinned(time, values[:, k], most), name, f"s{k % COLOURS}")
    return chart


def _path(x: Vector, y: Vector) -> str:
    """Path through points; `y` points up."""
    parts, pen = [], "M"
    for a, b in zip(x.tolist(), (1000.0 - y).tolist(), strict=True):
        if math.isfinite(b):
            parts.append(f"{pen}{a:.1f} {min(max(b, -9e3), 9e3):.1f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(parts)
