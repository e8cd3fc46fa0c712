"""Percentiles with confidence, and what drives a metric."""

import numpy as np
import pytest

from gyrostat.campaign.summary import chance_level, percentile_of, rank_correlation


@pytest.mark.parametrize(("percent", "count"), [(50.0, 40), (95.0, 200), (99.7, 3000)])
def test_the_interval_holds_the_true_percentile_as_often_as_it_says(percent, count):
    random = np.random.default_rng(2)
    held = []
    for _ in range(1000):
        found = percentile_of(random.random(count), percent)
        held.append(not (found.low > percent / 100.0 or found.high < percent / 100.0))
    # discrete ranks give at least what is promised; 1000 tries scatter by 0.7 %
    assert 0.95 - 0.02 < np.mean(held) < 0.99


def test_too_few_runs_do_not_bound_a_high_percentile():
    found = percentile_of(np.arange(200.0), 99.7)
    assert found.value == 199.0
    assert np.isnan(found.high)
    assert found.low < 199.0
    assert np.isnan(percentile_of(np.full(3, np.nan), 50.0).value)


def test_runs_without_the_metric_do_not_count():
    values = np.array([3.0, np.nan, 1.0, 2.0])
    assert percentile_of(values, 50.0).value == 2.0


def test_rank_correlation_sees_any_rising_law_and_nothing_else():
    random = np.random.default_rng(5)
    drawn = random.normal(size=(500, 3))
    drawn[:, 2] = 1.0
    rho = rank_correlation(drawn, np.exp(3.0 * drawn[:, 0]))
    assert rho[0] == pytest.approx(1.0)
    assert abs(rho[1]) < 2.0 * chance_level(500)
    assert np.isnan(rho[2])
    assert np.all(np.isnan(rank_correlation(drawn, np.ones(500))))
    metric = -drawn[:, 1]
    metric[:400] = np.nan
    assert rank_correlation(drawn, metric)[1] == pytest.approx(-1.0)
