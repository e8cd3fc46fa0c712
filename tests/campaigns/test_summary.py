"""Percentiles with confidence."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.stats import binom

from gyrostat.campaigns.summary import _binomial_quantile, percentile_of
from gyrostat.reports.campaign_content import told_percentile


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


@pytest.mark.parametrize("percent", [5.0, 50.0, 95.0, 99.7])
def test_the_value_is_that_of_the_rank_definition(percent):
    values = np.random.default_rng(3).random(1234)
    exact = np.percentile(values, percent, method="inverted_cdf")
    assert percentile_of(values, percent).value == exact


def test_ends_of_an_interval_read_apart():
    entry = {"value": 0.35203, "low": 0.352001, "high": 0.352052}
    assert told_percentile(entry, "1") == ("0.35203", "0.352", "0.35205")
    same = dict.fromkeys(("value", "low", "high"), 1e-3)
    assert told_percentile(same, "N·m") == ("1000 µN·m",) * 3
    assert told_percentile({**entry, "high": None}, "rad") == ("20.17 deg", "20.168 deg", "none")


@given(st.floats(1e-6, 1.0 - 1e-6), st.integers(1, 20000), st.floats(1e-4, 1.0 - 1e-4))
@example(0.5, 87, 0.5)  # the cumulative probability of 43 is exactly one half
def test_quantiles_are_those_of_the_binomial_distribution(level, count, share):
    found = _binomial_quantile(level, count, share)
    assert binom.cdf(found, count, share) >= level * (1.0 - 1e-9)
    assert binom.cdf(found - 1, count, share) < level * (1.0 + 1e-9)
