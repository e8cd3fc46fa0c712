"""Curves of the charts in reports."""

import numpy as np
import pytest

from gyrostat.reports.axis import axis_of
from gyrostat.reports.thinned import thinned


@pytest.mark.parametrize("is_log", [False, True])
@pytest.mark.parametrize(
    "values",
    [
        *([], [0.0], [3.0], [3.0, 3.0], [-3.0], [np.nan], [np.inf], [np.inf, 1.0]),
        *([5e-324], [0.0, 5e-324], [1e300], [-1e308, 1e308], [np.nan, 2.0]),
    ],
    ids=str,
)
def test_an_axis_has_a_range_whatever_its_values(values, is_log):
    axis = axis_of(np.array(values, dtype=float), "x", is_log=is_log)
    assert 0.0 < axis.high - axis.low < np.inf
    assert axis.ticks()
    finite = [v for v in values if 1e-300 < abs(v) <= 1e300 and (v > 0.0 or not is_log)]
    assert np.all((axis.place(np.array(finite)) > 0.0) & (axis.place(np.array(finite)) < 1000.0))


def test_a_curve_is_thinned_without_losing_its_extremes():
    time = np.linspace(0.0, 1.0, 100_000)
    values = np.sin(50.0 * time)
    values[777], values[99_000], values[5000:9000] = 3.0, -3.0, np.nan
    x, y = thinned(time, values, 500)
    assert len(x) <= 500
    assert np.all(np.diff(x) > 0.0)
    assert (np.max(y), np.min(y)) == (3.0, -3.0)


@pytest.mark.parametrize("count", [501, 1000, 1601, 4999])
def test_each_interval_of_a_thinned_curve_keeps_its_first_extremes(count):
    random = np.random.default_rng(count)
    time, values = np.arange(count) * 0.25, np.round(random.standard_normal(count), 1)
    values[random.random(count) < 0.2], values[100:140] = np.nan, np.inf
    kept = []
    for part in np.array_split(np.arange(count), 250):
        fine = part[np.isfinite(values[part])]
        if len(fine):
            kept += sorted({fine[np.argmin(values[fine])], fine[np.argmax(values[fine])]})
    x, y = thinned(time, values, 500)
    np.testing.assert_array_equal(x, time[kept])
    np.testing.assert_array_equal(y, values[kept])
