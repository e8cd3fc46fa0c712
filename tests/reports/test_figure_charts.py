"""Pictures of Matplotlib as charts of a page: every mark is where its numbers are."""

import io
import json
import re
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter
from matplotlib.image import imread

import gyrostat.reports.chart
from gyrostat.reports.axis import Axis
from gyrostat.reports.chart_frame import LETTER, ticks
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.figure_marks import plain_text

X = np.linspace(1.0, 9.0, 17)
SCRIPT = Path(gyrostat.reports.chart.__file__).with_name("templates") / "chart.js"


def axes_of(chart):
    """Both axes of a chart."""
    spans = [map(float, re.search(rf'data-{n}="(\S+) (\S+)"', chart).groups()) for n in "xy"]
    return [
        Axis(*span, "", is_log)
        for span, is_log in zip(spans, (False, "data-log=" in chart), strict=True)
    ]


def values(path, axis, sense):
    """Values of places of a path."""
    places = np.array(path, dtype=float)
    places = places if sense > 0 else 1000.0 - places
    low, high = np.log10([axis.low, axis.high]) if axis.is_log else (axis.low, axis.high)
    scaled = low + places / 1000.0 * (high - low)
    return 10.0**scaled if axis.is_log else scaled


def curve(chart, pattern):
    """Horizontal and vertical values of a path."""
    x, y = axes_of(chart)
    points = re.findall(r"[ML]([-\d.]+) ([-\d.]+)", re.search(pattern, chart)[1])
    across, up = zip(*points, strict=True)
    return values(across, x, 1), values(up, y, -1)


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_curves_points_bands_and_levels_are_at_their_values(scale):
    with panels(height=3.0) as (figure, axes):
        axes.fill_between(X, 0.5 * X, 2.0 * X, color=BAND, alpha=0.4, lw=0)
        axes.plot(X, X, color=MODEL, label="model")
        axes.plot(X, 1.5 * X, ".", color=MEASURED, label="measured")
        axes.axhline(3.0, color=MARK, ls="--")
        axes.axvline(4.0, color=MARK)
        axes.set(xlabel="time (min)", ylabel="speed (rpm)", yscale=scale)
        axes.legend()
    chart = str(figure_charts(figure))
    for pattern, factor in (
        (r'class="line s0" data-name="model" d="(.*?)"', 1.0),
        (r'class="points grey" d="(.*?)"', 1.5),
    ):
        x, y = curve(chart, pattern)
        np.testing.assert_allclose(x, X, atol=0.01)
        np.testing.assert_allclose(y, factor * X, rtol=0.01)
    x, y = curve(chart, r'class="wide" d="(.*?)Z"')
    assert {*np.round(y / x, 1)} == {0.5, 2.0}
    x, y = axes_of(chart)
    (across,) = re.findall(r'class="alert dashed" d="M0 ([\d.]+)H1000"', chart)
    (along,) = re.findall(r'class="alert" d="M([\d.]+) 0V1000"', chart)
    assert values([across], y, -1)[0] == pytest.approx(3.0, rel=0.01)
    assert values([along], x, 1)[0] == pytest.approx(4.0, rel=0.01)
    assert 'data-unit="min"' in chart
    assert ">speed (rpm)</text>" in chart
    assert chart.count(" model</span>") == chart.count(" measured</span>") == 1


def test_bars_of_errors_and_of_histograms_keep_their_values():
    draws = np.random.default_rng(1).normal(size=500)
    heights, edges = np.histogram(draws, bins=20)
    with panels(1, 2, height=3.0) as (figure, (left, right)):
        left.errorbar(X, X, 2.0, fmt="o", color=MODEL, capsize=3)
        right.stairs(heights, edges, fill=True, color=BAND)
        right.set_yticks([])
    chart = str(figure_charts(figure))
    first, second = chart.split('<svg class="chart"')[1:3]
    ends = re.findall(r"M\S+ ([\d.]+)V([\d.]+)", re.search(r'class="span s0" d="(.*?)"', first)[1])
    low, high = np.array(ends, dtype=float).T
    _, y = axes_of(first)
    np.testing.assert_allclose(values(high, y, -1) - values(low, y, -1), 4.0, atol=0.02)
    assert first.count('class="points s0') == 1  # the caps are not drawn as points
    _, up = curve(second, r'class="narrow" d="(.*?)Z"')
    np.testing.assert_allclose(up[1:-1:2], heights, atol=0.1)
    assert 'class="y"' not in second


def test_panels_that_share_an_axis_are_zoomed_together_and_one_column_is_as_wide_as_the_page():
    with panels(3, height=6.0, sharex=True) as (figure, rows):
        for axes in rows:
            axes.plot(X, X)
        rows[-1].set_xlabel("time (s)")
    chart = str(figure_charts(figure, "name"))
    assert re.findall(r'data-group="(\w+)"', chart) == ["name0"] * 3
    assert chart.count(">time (s)</text>") == 3
    assert '<div class="charts wide">' in chart
    with panels(1, 2, height=3.0) as (figure, rows):
        for axes in rows:
            axes.plot(X, X)
    chart = str(figure_charts(figure, "name"))
    assert re.findall(r'data-group="(\w+)"', chart) == ["name0", "name1"]
    assert '<div class="charts">' in chart


@pytest.mark.parametrize(
    ("names", "ticks"), [(["a", "b"], ["a", "b"]), (["x" * 40, "y"], ["1", "2"])]
)
def test_names_of_places_are_ticks_or_numbered_where_they_are_too_long(names, ticks):
    with panels(2, height=4.0, sharex=True) as (figure, rows):
        for axes in rows:
            axes.errorbar([0, 1], [1.0, 2.0], 0.1, fmt="o")
        rows[-1].set_xticks(range(2), names)
        rows[-1].set_xlim(-0.5, 1.5)
    chart = str(figure_charts(figure))
    assert re.findall(r'<text class="x"[^>]*>(.*?)</text>', chart) == 2 * ticks
    assert chart.count(f'data-columns="{"|".join(names)}"') == 2
    assert re.findall(r'<text class="x" x="([\d.]+)"', chart)[0] == f"{52 + 378 * 0.25:.1f}"


def test_texts_are_at_their_place_whether_in_values_or_in_the_frame():
    with panels(2, 2, height=4.0) as (figure, grid):
        axes = grid[0, 1]
        axes.set(xlim=(0.0, 10.0), ylim=(1.0, 100.0), yscale="log")
        axes.text(2.0, 10.0, "value")
        axes.text(5.0, 0.5, "end", transform=axes.get_xaxis_transform(), ha="right")
        axes.text(0.5, 1.0, "frame", transform=axes.transAxes, ha="center")
        grid[0, 0].set_ylabel("angle (rad)")
        grid[1, 0].set_ylabel("rate (rad/s)")
    chart = str(figure_charts(figure))
    found = re.findall(
        r'data-x="(\S+)" data-y="(\S+)" x="\S+" y="\S+" text-anchor="(\w+)">(\w+)', chart
    )
    places = {name: (float(x), float(y), side) for x, y, side, name in found}
    assert places["value"] == (2.0, 10.0, "start")
    assert places["end"] == (pytest.approx(5.0), pytest.approx(10.0), "end")
    assert places["frame"] == (pytest.approx(5.0), pytest.approx(100.0), "middle")
    titles = re.findall(r'class="title"[^>]*>(.*?)</text>', chart)
    assert titles == ["angle (rad)", "angle (rad)", "rate (rad/s)", "rate (rad/s)"]


def test_colours_of_cells_are_an_image_with_its_range_in_the_key():
    with panels(height=3.0) as (figure, axes):
        image = axes.pcolormesh(np.arange(4.0), np.arange(3.0), np.arange(12.0).reshape(3, 4))
        figure.colorbar(image, ax=axes, label="torque, mN·m")
    chart = str(figure_charts(figure))
    assert chart.count('<svg class="chart" viewBox="0 0 440') == 1
    assert 'href="data:image/png;base64,' in chart
    assert "torque, mN·m: 0 to 11" in chart


def test_cells_of_an_image_are_as_wide_as_they_are():
    x, y = np.array([0.0, 1.0, 4.0]), np.array([0.0, 2.0, 3.0, 4.0])
    values = np.arange(6.0).reshape(3, 2)
    with panels(height=3.0) as (figure, axes):
        mesh = axes.pcolormesh(x, y, values)
    data = re.search(r'base64,([^"]+)', str(figure_charts(figure)))[1]
    pixels = imread(io.BytesIO(b64decode(data)))
    cells = values[[2, 1, 0, 0]][:, [0, 1, 1, 1]]
    np.testing.assert_allclose(pixels, mesh.to_rgba(cells), atol=1.0 / 255.0)


def test_large_points_and_thick_bars_stay_so():
    with panels(height=3.0) as (figure, axes):
        axes.plot([0.0, 1.0], [0.0, 1.0], "o", ms=4)
        axes.plot([0.0, 1.0], [0.0, 2.0], ".", ms=4)
        for width in (0.9, 2.5):
            axes.errorbar([0.0], [1.0], [0.5], lw=width)
    chart = str(figure_charts(figure))
    for kind in ("points", "span"):
        assert len(re.findall(f'class="{kind} (?!picked)', chart)) == 2
    assert len(re.findall(r'class="points[^"]* large"', chart)) == 1
    assert len(re.findall(r'class="span[^"]* thick"', chart)) == 1


def test_a_ring_is_no_dot():
    with panels(height=3.0) as (figure, axes):
        axes.plot([0.0], [1.0], "o", color=MARK)
        axes.plot([1.0], [0.5], "o", color=MARK, mfc="none")
    chart = str(figure_charts(figure))
    alert = re.findall(r'class="points alert large" d="(.*?)"', chart)
    assert re.findall(r'class="points hole" d="(.*?)"', chart) == alert[1:]


def test_long_numbers_of_an_axis_do_not_touch():
    marks = ticks(Axis(0.00401, 0.0040201, ""), Axis(0.0, 1.0, ""), 236, (), ())
    texts = re.findall(r'class="x" x="(.*?)" y=.*?>(.*?)</text>', "".join(marks))
    places = [float(x) for x, _ in texts]
    assert len(texts) > 1
    assert min(np.diff(places)) > LETTER * max(len(text) for _, text in texts)


def test_an_axis_that_is_linear_near_zero_keeps_the_order_of_all_values():
    axis = Axis(-1e6, 1e6, "", linear=1.0)
    places = axis.place(np.array([-1e6, -10.0, -1.0, -0.5, 0.0, 0.5, 1.0, 10.0, 1e6]))
    np.testing.assert_allclose(places + places[::-1], 1000.0)
    assert np.all(np.diff(places) > 0.0)
    # within the linear part equal steps are equal, beyond it decades are
    assert places[4] - places[3] == pytest.approx(places[5] - places[4])
    assert places[7] - places[6] == pytest.approx((places[8] - places[7]) / 5.0)
    assert 0.0 in axis.ticks()
    assert axis.ticks() == [-v for v in reversed(axis.ticks())]


def test_dates_are_the_ticks_of_an_axis_in_days(browser, tmp_path):
    when = np.datetime64("2024-02-27") + np.arange(9)  # of a leap year
    with panels(height=3.0) as (figure, axes):
        axes.plot(when, np.arange(9.0), color=MODEL)
        locator = AutoDateLocator()
        axes.xaxis.set_major_locator(locator)
        axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))
    content = str(figure_charts(figure))
    (axis, _), (x, _) = axes_of(content), curve(content, r'class="line s0"[^>]* d="(.*?)"')
    axis = axis._replace(since=re.search(r'data-since="(\S+)"', content)[1])
    assert [axis.named(round(day)) for day in x] == [*when.astype(str)]
    assert axis.named(round(x[0]) + 0.75) == "02-27 18:00"
    page = tmp_path / "page.html"
    page.write_text(f"{content}<script>{SCRIPT.read_text()}</script>")
    browser.open(page.as_uri())
    days = [axis.low, *axis.ticks(), 0.123, 3.999]
    shown = browser.ask(f"{json.dumps(days)}.map(gyrostatCharts[0].named)")
    assert shown == [axis.named(day) for day in days]
    second = 1.0 / 86400.0
    for low, length in ((3.5, 40 * second), (3.5, 5 / 1440), (0.1, 1.4), (-3.0, 30.0)):
        part = axis._replace(low=low, high=low + length)
        ticks = part.ticks()
        names = [axis.named(day) for day in ticks]
        assert 3 < len({*names}) == len(names)
        steps = np.diff(ticks)
        np.testing.assert_allclose(steps, steps[0], atol=1e-9)
        assert round(86400 * steps[0]) in {10, 60, 21600, 432000}
        ends = f"gyrostatCharts[0].x = {[low, low + length]}"
        browser.ask(f"({ends}, gyrostatCharts[0].zoom(gyrostatCharts[0].view), 0)")
        drawn = "[...gyrostatCharts[0].svg.querySelectorAll('text.x')].map(t => t.textContent)"
        assert browser.ask(drawn) == names


@pytest.mark.parametrize(
    ("label", "text"),
    [("$h_1$", "h₁"), ("$K_{21}$", "K₂₁"), (r" _a \$5", "_a $5"), ("a\n(N·m)", "a (N·m)")],
)
def test_labels_are_plain_text(label, text):
    assert plain_text(label) == text
