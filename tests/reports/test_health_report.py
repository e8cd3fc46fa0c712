"""Page and picture of flying wheels: what they show of a stated history."""

import re

import numpy as np
import pytest

from gyrostat.monitoring.change.assess import Limit, assess
from gyrostat.monitoring.change.detector import AlarmSettings
from gyrostat.monitoring.health import Health
from gyrostat.monitoring.windows import Windows
from gyrostat.reports.health import health_page
from gyrostat.reports.health_series import BINS, wheel_series
from tests.monitoring.window_tables import STATED, window_table


def history(**values):
    """Forty days with a growth of 20 % of the Coulomb torque from day 20 on."""
    days = np.arange(40)
    noise = 1.0 + 0.01 * np.random.default_rng(4).standard_normal(40)
    coulomb = STATED["coulomb"] * np.where(days < 20, 1.0, 1.2) * noise
    return window_table(days, **({"coulomb": coulomb} | values))


def health_of(*tables, limit=1.5e-3):
    windows, settings = Windows.joined(tables), AlarmSettings()
    limits = {name: Limit(limit) for name in windows.wheels}
    conditions = assess(windows, settings, limits=limits)
    return Health(windows, {"rows": 7}, ("a note",), tuple(conditions), settings)


@pytest.fixture(scope="module")
def health():
    """Wheel a grows; wheel <b> is healthy, and not observable for a week."""
    blind = np.isin(np.arange(40), np.arange(5, 12))
    unknown = {f"{name}_observable": ~blind for name in ("coulomb", "viscous")}
    flat = np.full(40, STATED["coulomb"])
    return health_of(history(), history(wheel="<b>", coulomb=flat, valid=~blind, **unknown))


def test_surface_is_the_change_of_the_friction_at_each_speed(health):
    table = health.windows.wheel("a")
    series = wheel_series(table, health.conditions[0])
    speeds = 0.5 * (series.speeds[1:] + series.speeds[:-1]) * np.pi / 30.0
    inside = (speeds > 155.0) & (speeds < 245.0)
    expected = 0.2 * 1e-3 / (1e-3 + 1e-6 * speeds[inside])
    got = series.change[inside][:, 25:].mean(axis=1)
    np.testing.assert_allclose(got, expected, atol=0.008)
    assert series.per_bin == 1
    assert not series.unsteady.any()


def test_years_are_binned_and_windows_without_an_estimate_are_marked():
    days = np.r_[0:1000, 1100:3650]
    fine = ~((days >= 2000) & (days < 2400))
    table = window_table(days, viscous_observable=fine, coulomb=np.linspace(1e-3, 2e-3, days.size))
    condition = assess(table.where(np.arange(3)))[0]
    whole = wheel_series(table, condition.__class__(**(vars(condition) | _histories(table))))
    assert len(whole.edges) - 1 <= BINS
    assert whole.unit == "years"
    assert whole.edges[-1] == pytest.approx(3650 / 365.25, rel=0.02)
    middle = whole.middle * 365.25
    blind = whole.trends["viscous"].unknown
    assert blind[(middle > 2050) & (middle < 2350)].all()
    assert not blind[(middle < 1950) | (middle > 2450)].any()
    # a gap has neither an estimate nor the mark of one that failed
    gap = (middle > 1045) & (middle < 1060)
    assert np.isnan(whole.trends["coulomb"].value[gap]).all()
    # the mean of a bin is the mean of its windows
    first = table["coulomb"][: whole.per_bin].mean()
    assert whole.trends["coulomb"].value[0] == pytest.approx(first, rel=1e-12)


def _histories(table):
    """Histories of a health as long as a table, all 1."""
    ones, count = np.ones(len(table)), len(table)
    verdict = assess(table.where(np.arange(1)))[0].verdicts[0]
    return {
        "start": table["start"],
        "level": np.ones((count, 4)),
        "level_sigma": np.ones((count, 4)),
        "verdicts": (verdict,) * count,
        "friction": ones,
        "friction_sigma": ones,
    }


def test_page_shows_verdicts_first_and_why_a_parameter_has_no_value(health):
    page = health_page(health, command="gyrostat monitor <x>")
    above = page[: page.index("<h2")]
    assert re.search(r'class="invalid"><a href="#wheel1">a</a>: ALARM: ', above)
    assert re.search(r'class="good"><a href="#wheel2">&lt;b&gt;</a>: no change found', above)
    assert '<p class="warning">a note</p>' in above
    assert "not observable, because the speed keeps one sign" in page
    assert "friction limit of 1.5 mN·m" in page
    assert "<b>:" not in page
    first, second = page.split('<h2 id="wheel')[1:3]
    assert first.count('<svg class="chart" viewBox="0 0 440') == 6
    # the week in which b is not observable, on all charts of b but the alarm statistic
    assert second.count('data-group="&lt;b&gt;"') == 6
    assert first.count('class="cells unknown" d="M0 0H') == 1  # the key
    assert second.count('class="cells unknown"') == 1 + 5
    assert 'class="cells shade' in first.split("<figcaption")[0]


def test_page_of_wheels_without_a_valid_window_says_so():
    never = np.zeros(3, bool)
    table = window_table(np.arange(3), valid=never, why=["no current"] * 3)
    page = health_page(health_of(table), command="x")
    assert "not valid: no current" in page
    empty = Health(Windows.of([]), {"rows": 0})
    assert "The telemetry gives no window." in health_page(empty, command="x")


def test_health_is_drawn_and_shown_with_its_text(health):
    figure = health.plot()
    assert len(figure.axes) == 2 * 3
    html = health._repr_html_()
    assert html.startswith("<pre>a: 40 of 40 windows valid")
    assert "data:image/png;base64," in html
