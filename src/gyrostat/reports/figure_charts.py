"""Charts of a page from a figure of Matplotlib: the same marks, with cursor, zoom and dark mode.

A picture that is drawn once, for `plot()` and for papers, is so shown in a page like all charts.
"""

import re
from datetime import UTC
from itertools import chain

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.dates import ConciseDateFormatter, num2date
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from gyrostat.reports.axis import Axis
from gyrostat.reports.chart import Chart
from gyrostat.reports.chart_frame import HEIGHT
from gyrostat.reports.figure_marks import Marks, plain_text

LOW = 150
"""Height of a chart in a row of its own whose panel is flat."""
FLAT = 0.36
"""Ratio of height to width below which a panel is flat."""


def figure_charts(figure: Figure, group: str = "figure") -> Markup:
    """Charts of a page from a figure.

    Args:
        figure: Figure with panels in a grid; a bar of colours becomes a line of the key.
        group: Prefix of the names of the groups of charts that are zoomed together.
    """
    every = [axes for axes in figure.axes if axes.get_visible() and axes.axison]
    bars = [axes for axes in every if axes.get_label() == "<colorbar>"]
    panels = [axes for axes in every if axes not in bars]
    marks = Marks()
    charts = [_chart(figure, axes, panels, group, marks) for axes in panels]
    columns = max((_columns(axes) for axes in panels), default=1)
    names = [_key_entry(*entry) for entry in _entries(figure, panels, marks)]
    names += [_colour_bar(axes, panels) for axes in bars]
    return Markup('<div class="charts{}">{}</div>{}').format(
        " wide" if columns == 1 else "",
        Markup("").join(Markup("<div>{}</div>").format(chart.svg()) for chart in charts),
        Markup('<div class="key">{}</div>').format(Markup(" ").join(names)) if names else "",
    )


def _row(axes: Axes) -> int:
    place = axes.get_subplotspec()
    return 0 if place is None else place.rowspan.start


def _columns(axes: Axes) -> int:
    place = axes.get_subplotspec()
    return 1 if place is None else place.get_gridspec().ncols


def _chart(figure: Figure, axes: Axes, panels: list[Axes], group: str, marks: Marks) -> Chart:
    """Chart of one panel."""
    siblings = [each for each in panels if axes.get_shared_x_axes().joined(axes, each)]
    labels = [each.get_xlabel() for each in (axes, *reversed(siblings))]
    label = plain_text(next((text for text in labels if text), ""))
    beside = [each for each in panels if _row(each) == _row(axes)]
    upright = [each.get_ylabel() for each in (axes, *beside) if each.get_ylabel()]
    titles = [axes.get_title("left") or axes.get_title(), *upright[:1]]
    title = ": ".join(plain_text(text) for text in titles if text)
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    shift, since, names = 0.0, "", []
    formatter = axes.xaxis.get_major_formatter()
    if isinstance(formatter, ConciseDateFormatter):
        shift = float(np.floor(left))
        label, since = "date", f"{num2date(shift, tz=UTC):%Y-%m-%d}"
    elif isinstance(axes.xaxis.get_major_locator(), FixedLocator):
        places = axes.get_xticks()
        if np.array_equal(places, np.arange(len(places))):
            names = [plain_text(name) for name in formatter.format_ticks(places.tolist())]
    symlog = axes.yaxis.get_transform() if axes.get_yscale() == "symlog" else None
    box = axes.get_position()
    width, height = figure.get_size_inches() * (box.width, box.height)
    is_flat = _columns(axes) == 1 and len(panels) > 2 and height < FLAT * width
    chart = Chart(
        title,
        Axis(left - shift, right - shift, label, axes.get_xscale() == "log", since=since),
        Axis(low, high, "", axes.get_yscale() == "log", getattr(symlog, "linthresh", 0.0)),
        {"group": f"{group}{panels.index(siblings[0] if siblings else axes)}"},
        columns=names,
        rows=() if len(axes.get_yticks()) else (" ",),
        height=LOW if is_flat else HEIGHT,
    )
    unit = re.search(r"\(([^()]*)\)$|, (\S+)$", label)
    chart.attributes["unit"] = (unit[1] or unit[2]) if unit else ""
    marks.draw(axes, chart, shift)
    return chart


def _entries(figure: Figure, panels: list[Axes], marks: Marks) -> list[tuple[str, str, str]]:
    """Entries of the legends: class, path and name, each once."""
    legends = [axes.get_legend() for axes in panels] + [*figure.legends]
    entries = {}
    for legend in filter(None, legends):
        for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=False):
            if handle is None:
                continue
            kind, path = marks.key_of(handle)
            entries[kind, plain_text(text.get_text())] = path
    return [(kind, path, name) for (kind, name), path in entries.items()]


def _key_entry(kind: str, path: str, name: str) -> Markup:
    return Markup(
        '<span><svg class="chart" viewBox="0 0 20 8" aria-hidden="true">'
        '<path class="{}" d="{}"/></svg> {}</span>'
    ).format(kind, path, name)


def _colour_bar(axes: Axes, panels: list[Axes]) -> Markup:
    """Entry of the key: quantity and range of the colours."""
    low, high = axes.get_ylim()
    shown = chain.from_iterable((*panel.collections, *panel.images) for panel in panels)
    mappable = next(each for each in shown if each.colorbar and each.colorbar.ax is axes)
    stops = Markup("").join(
        Markup('<rect x="{}" width="9" height="8" fill="{}"/>').format(8 * k, to_hex(colour))
        for k, colour in enumerate(mappable.cmap(np.linspace(0.0, 1.0, 12)))
    )
    return Markup(
        '<span><svg class="colours" viewBox="0 0 96 8" aria-hidden="true">{}</svg> {}</span>'
    ).format(stops, f"{plain_text(axes.get_ylabel())}: {low:.3g} to {high:.3g}")
