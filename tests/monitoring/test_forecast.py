"""Forecast against the law of first passage, and its coverage on simulated wheels."""

import numpy as np
import pytest
import scipy.stats

from gyrostat.monitoring.change.forecast import Series, first_passage, forecast

DAYS = np.arange(1.0, 400.0)


def ahead(values, variance, limit, onsets=()):
    """Forecast from daily values."""
    size = len(values)
    series = Series(np.array(values), np.full(size, variance), np.ones(size))
    return forecast(series, onsets, limit, DAYS)


def test_first_passage_is_inverse_gaussian():
    gap, slope, variance = 0.3, 4e-3, 1e-3
    law = scipy.stats.invgauss(mu=gap / slope / (gap**2 / variance), scale=gap**2 / variance)
    ours = first_passage(DAYS, np.array(gap), np.array(slope), np.array(variance))
    assert ours == pytest.approx(law.cdf(DAYS), abs=1e-10)


def test_away_from_the_limit_it_may_never_be_reached():
    # P(ever) = exp(2 v g/s²) for a drift away from the limit
    gap, slope, variance = 0.1, -1e-3, 1e-3
    late = first_passage(np.array([1e7]), np.array(gap), np.array(slope), np.array(variance))
    assert late[0] == pytest.approx(np.exp(2.0 * slope * gap / variance), rel=1e-3)


def test_forecast_of_a_known_line_is_exact():
    line = 1.0 + 2e-3 * np.arange(200.0)
    assert ahead(line, 1e-10, 1.0 + 2e-3 * 229).quantile(0.5) == pytest.approx(30.0, abs=1.5)


def test_a_quiet_wheel_does_not_reach_the_limit():
    random = np.random.default_rng(1)
    quiet = ahead(1.0 + 5e-3 * random.standard_normal(150), 25e-6, 1.5)
    assert quiet.reached[90] < 0.02
    assert quiet.quantile(0.5) == np.inf


def test_onset_of_the_growth_narrows_the_forecast():
    random = np.random.default_rng(2)
    day = np.arange(150.0)
    values = 1.0 + 4e-3 * np.maximum(day - 80.0, 0.0) + 5e-3 * random.standard_normal(150)
    limit = 1.0 + 4e-3 * 110.0
    widths = [
        each.quantile(0.9) - each.quantile(0.1)
        for each in (ahead(values, 25e-6, limit, onsets) for onsets in ((), (75, 80, 85)))
    ]
    assert widths[1] < 0.6 * widths[0]
    known = ahead(values, 25e-6, limit, (75, 80, 85))
    assert known.quantile(0.02) < 41.0 < known.quantile(0.98)


def test_intervals_cover_their_share():
    covered, runs = 0, 40
    for seed in range(runs):
        random = np.random.default_rng([seed, 4])
        slope = random.uniform(2e-3, 5e-3)
        wander = np.cumsum(3e-5 * random.standard_normal(400))
        truth = 1.0 + np.cumsum(slope + wander)
        end = int(np.argmax(truth > 1.6))
        noisy = truth[: end - 30] + 5e-3 * random.standard_normal(max(end - 30, 0))
        found = ahead(noisy, 25e-6, 1.6)
        covered += found.quantile(0.1) <= 31.0 <= found.quantile(0.9)
    # 80 % of 40, with twice its error
    assert 0.67 < covered / runs < 0.95
