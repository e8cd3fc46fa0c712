"""Forecast against the law of first passage, and its coverage on simulated wheels."""

import numpy as np
import pytest
import scipy.stats

from gyrostat.monitoring.change.forecast import Trend, first_passage

DAYS = np.arange(1.0, 400.0)


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
    trend = Trend()
    for day in range(200):
        trend.update(1.0 + 2e-3 * day, 1e-10)
    forecast = trend.forecast(1.0 + 2e-3 * 229, DAYS)
    assert forecast.quantile(0.5) == pytest.approx(30.0, abs=1.5)


def test_a_quiet_wheel_does_not_reach_the_limit():
    random = np.random.default_rng(1)
    trend = Trend()
    for _ in range(150):
        trend.update(1.0 + 5e-3 * random.standard_normal(), 25e-6)
    assert trend.forecast(1.5, DAYS).reached[90] < 0.02
    assert trend.forecast(1.5, DAYS).quantile(0.5) == np.inf


def test_intervals_cover_their_share():
    covered, runs = 0, 60
    for seed in range(runs):
        random = np.random.default_rng([seed, 4])
        slope = random.uniform(2e-3, 5e-3)
        wander = np.cumsum(3e-5 * random.standard_normal(400))
        truth = 1.0 + np.cumsum(slope + wander)
        end = int(np.argmax(truth > 1.6))
        if end < 80:
            continue
        trend = Trend()
        for day in range(end - 30):
            trend.update(truth[day] + 5e-3 * random.standard_normal(), 25e-6)
        forecast = trend.forecast(1.6, DAYS)
        covered += forecast.quantile(0.1) <= 31.0 <= forecast.quantile(0.9)
    # 80 % of 60 with its error
    assert 0.62 < covered / runs < 0.95
