"""What drives a metric: rank correlations, one level for all of them, and the power left."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, rankdata, spearmanr

from gyrostat.campaigns import drivers
from gyrostat.campaigns.drivers import find_drivers
from gyrostat.campaigns.ranks import doubled_ranks


def campaign(random, runs=60, keys=8):
    """Draws without any influence; metrics that depend on each other, with ties and gaps."""
    drawn = random.normal(size=(runs, keys))
    common = random.normal(size=runs)
    metrics = common[:, None] + 0.3 * random.normal(size=(runs, 7))
    metrics[:, 1] = np.round(metrics[:, 1])
    metrics[:, 2] = random.random(runs) < 0.04  # nearly always the same
    metrics[random.random(runs) < 0.9, 3] = np.nan  # of a handful of runs
    metrics[common > 1.0, 4] = np.nan
    metrics[:, 5] = 3.0
    metrics[random.random(runs) < 0.1] = np.nan  # runs that failed
    return drawn, metrics


def test_rank_correlations_are_spearmans():
    drawn, metrics = campaign(np.random.default_rng(5))
    drawn[:, 2] = 1.0
    found = find_drivers(drawn, metrics)
    for k in range(drawn.shape[1]):
        for m in range(metrics.shape[1]):
            fine = np.isfinite(metrics[:, m])
            if k == 2 or np.ptp(metrics[fine, m]) == 0.0:
                assert np.isnan(found.rank_correlation[k, m])
                continue
            exact = spearmanr(drawn[fine, k], metrics[fine, m])[0]
            assert found.rank_correlation[k, m] == pytest.approx(exact, abs=1e-12)
    assert np.isnan(found.chance_level[5])
    assert not np.any(found.named()[2])
    np.testing.assert_array_equal(find_drivers(drawn, metrics).chance_level, found.chance_level)


def test_of_campaigns_without_a_driver_few_name_one():
    """The 99.9 % limit at a level of 5 %; benchmarks/soak_drivers.py shuffles a flown one."""
    random, count = np.random.default_rng(7), 40
    found = [find_drivers(*campaign(random)).named() for _ in range(count)]
    assert sum(map(np.any, found)) <= binom.ppf(0.999, count, drivers.LEVEL)


def test_a_driver_is_named_and_no_other():
    """0.5 of 200 runs is seven standard deviations; 0.8 of 20 is beyond chance as well."""
    random, right, wrong = np.random.default_rng(3), 0, 0
    for runs, strength in ((200, 0.6), (20, 3.0)) * 5:
        drawn, metrics = campaign(random, runs)
        metrics[:, 0] = strength * drawn[:, 4] ** 3 + random.normal(size=runs)
        named = find_drivers(drawn, metrics).named()
        right += named[4, 0]
        named[4, 0] = False
        wrong += np.any(named)
    assert right >= 9
    assert wrong <= binom.ppf(0.999, 10, drivers.LEVEL)


@pytest.mark.parametrize("runs", [1, 2, 3, 4])
def test_a_handful_of_runs_names_nothing(runs):
    drawn = np.arange(1.0, runs + 1.0)[:, None] * [1.0, -2.0]
    found = find_drivers(drawn, np.stack([drawn[:, 0], np.full(runs, np.nan)], axis=1))
    assert not np.any(found.named())


def test_of_many_runs_some_are_permuted(monkeypatch):
    random = np.random.default_rng(1)
    drawn, metrics = random.normal(size=(900, 6)), random.normal(size=(900, 5))
    every = find_drivers(drawn, metrics).chance_level
    monkeypatch.setattr(drivers, "MOST_RUNS", 300)
    np.testing.assert_allclose(find_drivers(drawn, metrics).chance_level, every, rtol=0.05)
    assert every[0] > 1.3 * 1.96 / np.sqrt(899.0)  # that of a single pair at 5 %


@given(st.lists(st.integers(-3, 3), min_size=1, max_size=30))
def test_equal_values_have_their_mean_rank(values):
    np.testing.assert_array_equal(0.5 * doubled_ranks(np.array(values, float)), rankdata(values))
