"""Charts of records and fits: every mark is where its numbers are."""

import re

import numpy as np

from gyrostat.core.units import RPM
from gyrostat.reports import record_charts
from gyrostat.reports.axis import Axis
from gyrostat.reports.chart import Chart
from gyrostat.reports.chart_frame import HEIGHT, WIDTH
from gyrostat.telemetry import Record


def record(count):
    """A wheel that slows down through zero, with one sample missing."""
    time = np.linspace(0.0, 10.0, count)
    model = (100.0 - 20.0 * time) * RPM
    speed = model + 3.0 * RPM
    speed[count // 4] = np.nan
    current = np.where(time < 5.0, 0.1, -0.1)
    return Record("ramp", time, current, speed, np.isfinite(speed)), model


def span(chart, name):
    return [float(v) for v in re.search(rf'data-{name}="(\S+) (\S+)"', chart).groups()]


def heights(path, chart):
    """Values of the vertical places of a path."""
    low, high = span(chart, "y")
    places = [float(v) for v in re.findall(r"[ML]\S+ ([-\d.]+)", path)]
    return low + (1.0 - np.array(places) / 1000.0) * (high - low)


def test_a_record_is_drawn_with_its_model_residuals_and_crossing():
    given, model = record(201)
    (speeds, currents), (residuals,) = record_charts(given, model, np.full(201, 4.0), 3.0)
    for chart in (speeds, residuals):
        # zero speed is at 5 s of 10 s; the missing sample is not drawn
        assert re.findall(r'class="event" d="M([\d.]+) 0V1000"', chart) == ["500.0"]
        assert re.search(r'points measured" d="(.*?)"', chart)[1].count("M") == 200
    assert "zero crossings: 1" in speeds
    line = re.search(r'data-name="model" d="(.*?)"', speeds)[1]
    np.testing.assert_allclose(heights(line, speeds), model / RPM, atol=0.05)
    dots = re.search(r'points measured" d="(.*?)"', residuals)[1]
    np.testing.assert_allclose(heights(dots, residuals), 3.0, atol=0.1)
    # two sigma of model and noise together: 2 * hypot(4, 3) rad/s
    for name, sense in (("upper limit", 1.0), ("lower limit", -1.0)):
        limit = re.search(rf'data-name="{name}" d="(.*?)"', residuals)[1]
        np.testing.assert_allclose(heights(limit, residuals), sense * 10.0 / RPM, rtol=1e-3)
    drawn = re.search(r'data-name="current" d="(.*?)"', currents)[1]
    assert re.findall(r"[ML](\S+)", drawn) == ["0.0", "500.0", "500.0", "1000.0"]
    np.testing.assert_allclose(heights(drawn, currents), [0.1, 0.1, -0.1, -0.1], atol=1e-4)
    # the column beside it is as high
    sizes = [int(re.search(rf"0 0 {WIDTH} (\d+)", c)[1]) for c in (speeds, currents, residuals)]
    assert sizes[0] + sizes[1] == sizes[2]


def test_long_records_are_thinned():
    given, model = record(50_001)
    (speeds, _), (residuals,) = record_charts(given, model, None, 1.0)
    assert all(chart.count("h0") <= 7000 for chart in (speeds, residuals))
    assert len(residuals) < 200_000


def test_a_low_chart_has_fewer_ticks_and_spans_are_where_their_values_are():
    def ticks(height):
        chart = Chart("t", Axis(0.0, 10.0, "x"), Axis(0.0, 10.0, ""), height=height)
        chart.spans(np.array([5.0]), np.array([2.0]), np.array([4.0]), "age1")
        assert '<path class="span age1" d="M500.0 800.0V600.0"/>' in chart.svg()
        return chart.svg().count('class="y"')

    assert ticks(HEIGHT) == 6
    assert ticks(HEIGHT // 2) == 3
