"""A lot of wheels: distribution without errors of the fits, tolerance limits, outliers, sets."""

from itertools import combinations

import numpy as np
import pytest
from scipy import integrate, optimize, stats

from gyrostat.core.skewed_normal import deviation, score_of, value_at
from gyrostat.identification.lot.best_set import best_set, true_values
from gyrostat.identification.lot.correlation import correlation, spread_covariance
from gyrostat.identification.lot.likelihood import log_likelihood, share_below
from gyrostat.identification.lot.limits import (
    one_sided_factor,
    tolerance_limits,
    two_sided_factor,
)
from gyrostat.identification.lot.lot_table import score_correlation
from gyrostat.identification.lot.outliers import outliers
from gyrostat.identification.lot.over_dates import control_chart, drift
from gyrostat.identification.lot.posterior import SHAPES, lot_draws

LOTS = [(10.0, 1.0, 0.0), (10.0, 2.0, 0.4), (10.0, 0.5, -0.6)]


def lot_of(random, count, shape="normal", ratio=0.5):
    """Estimates of a lot about 10 with a spread of 1, and the sigmas of their errors."""
    score = random.standard_normal(count)
    true = 10.0 + score if shape == "normal" else 10.0 * np.exp(0.3 * score)
    errors = ratio * np.exp(0.3 * random.standard_normal(count))
    return true + errors * random.standard_normal(count), errors


@pytest.mark.parametrize(
    ("count", "one", "two"),
    [(10, 2.911, 3.393), (20, 2.396, 2.760), (50, 2.065, 2.382), (100, 1.927, 2.234)],
)
def test_classical_factors_are_those_of_the_tables(count, one, two):
    """Odeh and Owen 1980, ISO 16269-6: 95 % of the population with 95 % confidence."""
    assert one_sided_factor(count, 0.95, 0.95) == pytest.approx(one, abs=6e-4)
    assert two_sided_factor(count, 0.95, 0.95) == pytest.approx(two, abs=6e-4)


@pytest.mark.parametrize(("content", "confidence"), [(0.9, 0.95), (0.99, 0.9), (0.997, 0.6)])
def test_classical_factors_by_an_independent_library(content, confidence):
    noncentrality = np.sqrt(35) * stats.norm.ppf(content)
    expected = stats.nct.ppf(confidence, 34, noncentrality) / np.sqrt(35)
    assert one_sided_factor(35, content, confidence) == pytest.approx(expected, rel=1e-6)

    def sure(z):
        half = two_sided_factor(35, content, confidence)
        ends = z / np.sqrt(35) + half * np.array([-1.0, 1.0])
        offset, reach = ends.mean(), np.ptp(ends) / 2.0

        def excess(s):
            return np.ptp(stats.norm.cdf([offset - reach * s, offset + reach * s])) - content

        least = optimize.brentq(excess, 1e-3, 50.0)
        return stats.chi2.sf(34 * least**2, 34) * stats.norm.pdf(z)

    assert integrate.quad(sure, -6, 6, epsabs=1e-6)[0] == pytest.approx(confidence, abs=1e-4)


@pytest.mark.parametrize("count", [20, 100])
def test_without_errors_the_limits_are_the_classical_ones(count):
    values = np.random.default_rng(910800).standard_normal(count)
    limits = tolerance_limits(lot_draws(values, np.full(count, 1e-4), "normal"), 0.95, 0.95)
    ends = (np.array([limits.lower, limits.upper, limits.low, limits.high]) - values.mean()) / (
        values.std(ddof=1)
    )
    one, two = (f(count, 0.95, 0.95) for f in (one_sided_factor, two_sided_factor))
    np.testing.assert_allclose(ends, [-one, one, -two, two], rtol=6e-3)


def test_log_normal_limits_without_errors_are_classical_ones_of_the_logarithms():
    logs = 0.4 * np.random.default_rng(910801).standard_normal(20)
    limits = tolerance_limits(lot_draws(np.exp(logs), np.full(20, 1e-4), "log-normal"), 0.95, 0.95)
    one = one_sided_factor(20, 0.95, 0.95) * logs.std(ddof=1)
    ends = np.log([limits.lower, limits.upper])
    np.testing.assert_allclose((ends - logs.mean()) / one, [-1.0, 1.0], rtol=1e-2)
    mirrored = lot_draws(-np.exp(logs), np.full(20, 1e-4), "log-normal")
    assert tolerance_limits(mirrored, 0.95, 0.95).lower == pytest.approx(-limits.upper, rel=1e-3)


def test_equal_errors_are_taken_out_by_the_closed_form():
    """(n - 1) S^2 / (tau^2 + s^2) is chi-square: the quantiles of the spread are known."""
    values, error = 10.0 + np.random.default_rng(910802).standard_normal(40), 0.6
    draws = lot_draws(values, np.full(40, error), "normal")
    for share in (0.1, 0.5, 0.9):
        level = stats.chi2.ppf(1.0 - share, 39)
        expected = np.sqrt(39 * values.var(ddof=1) / level - error**2)
        assert draws.quantile(draws.scale, share) == pytest.approx(expected, rel=3e-3)
    assert draws.quantile(draws.location, 0.5) == pytest.approx(values.mean(), abs=3e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_spread_of_the_estimates_is_too_large_and_that_of_the_lot_is_not(shape):
    random = np.random.default_rng(910803)
    ratios = []
    for _ in range(12):
        values, errors = lot_of(random, 100, ratio=0.75)
        draws = lot_draws(values, errors, shape, 512)
        sigma = float(deviation(*draws.typical()[1:]))
        ratios.append([sigma, values.std(ddof=1)])
    wheels, estimates = np.mean(ratios, axis=0)
    # the errors have a root mean square of 0.82: sqrt(1 + 0.82^2) = 1.29
    assert estimates == pytest.approx(1.29, abs=0.08)
    assert wheels == pytest.approx(1.0, abs=0.09)


@pytest.mark.parametrize("lot", LOTS)
@pytest.mark.parametrize("error", [0.05, 0.6, 3.0])
def test_density_and_share_of_an_estimate_are_integrals_over_the_wheels(lot, error):
    values = value_at(np.array([-1.5, 0.2, 2.2]), *lot) + np.array([0.5, -1.0, 1.0]) * error
    density = np.exp(log_likelihood(values, np.full(3, error))(np.array([lot]))[0])
    share = share_below(values, np.full(3, error), *(np.full(3, part) for part in lot))
    score = np.linspace(-9.0, 9.0, 200_001)
    x, weight = value_at(score, *lot), stats.norm.pdf(score) * (score[1] - score[0])
    for k, value in enumerate(values):
        exact = weight @ stats.norm.pdf(value, x, error)
        assert density[k] == pytest.approx(exact, rel=5e-3)
        assert share[k] == pytest.approx(weight @ stats.norm.cdf(value, x, error), abs=2e-4)


def test_a_log_normal_distribution_is_a_skewed_normal_one():
    score = np.linspace(-3.0, 3.0, 7)
    law = stats.lognorm(0.5, scale=4.0)
    np.testing.assert_allclose(value_at(score, 4.0, 2.0, 0.5), law.ppf(stats.norm.cdf(score)))
    np.testing.assert_allclose(score_of(value_at(score, 4.0, 2.0, 0.5), 4.0, 2.0, 0.5), score)
    assert deviation(2.0, 0.5) == pytest.approx(law.std())
    assert score_of([-1.0, 9.0], 4.0, 2.0, [0.5, -0.5]).tolist() == [-np.inf, np.inf]


@pytest.mark.parametrize("shape", ["normal", "log-normal"])
def test_limits_of_an_unknown_shape_hold(shape):
    """`benchmarks/lot.py` measures it: 93 to 97 %; here 50 lots: 41 are 4 sigma fewer."""
    random = np.random.default_rng(910804)
    law = stats.norm(10.0, 1.0) if shape == "normal" else stats.lognorm(0.3, scale=10.0)
    held = np.zeros(2)
    for _ in range(50):
        values, errors = lot_of(random, 30, shape)
        limits = tolerance_limits(lot_draws(values, errors, "unknown", 1024), 0.95, 0.95)
        held += [law.cdf(limits.lower) <= 0.05, law.cdf(limits.upper) >= 0.95]
    assert held.min() > 41


def test_outliers_do_not_hide_each_other():
    values, errors = lot_of(np.random.default_rng(910805), 40, ratio=0.2)
    assert outliers(values, errors, "unknown", 4) == []
    values[[3, 30]] += 12.0
    suspects = outliers(values, errors, "normal", 4)
    assert {suspect.wheel for suspect in suspects} == {3, 30}


@pytest.mark.parametrize("seed", range(4))
def test_three_outliers_of_one_size_are_found(seed):
    # they widen the lot and skew it, so that the least likely wheel of the whole lot is a good one
    random = np.random.default_rng(910860 + seed)
    values, errors = 1.0 + 0.08 * random.standard_normal(24), np.full(24, 0.01)
    values[:3] *= 2.0
    suspects = outliers(values, errors, "normal", 4)
    assert {suspect.wheel for suspect in suspects} == {0, 1, 2}
    assert max(suspect.chance for suspect in suspects) < 0.05


def test_a_large_error_makes_no_outlier():
    values, errors = lot_of(np.random.default_rng(910806), 40, ratio=0.2)
    values[5] += 12.0
    errors[5] = 8.0
    assert outliers(values, errors, "normal", 4) == []


def test_correlated_errors_are_no_correlation_of_the_wheels():
    random, count = np.random.default_rng(910807), 400
    errors = np.tile([[0.5, -0.45], [-0.45, 0.5]], (count, 1, 1))
    spread = np.array([[1.0, 0.5], [0.5, 1.0]])
    values = random.multivariate_normal([0, 0], spread, count)
    values += random.multivariate_normal([0, 0], errors[0], count)
    result = correlation(values, errors)
    expected = np.cov(values.T) - errors[0]
    np.testing.assert_allclose(spread_covariance(values, errors), expected)
    assert result.low[0, 1] < 0.5 < result.high[0, 1]
    assert result.value[0, 1] == pytest.approx(0.5, abs=0.15)
    assert result.estimates[0, 1] < 0.15
    unknown = correlation(values, 3.0 * errors)
    assert np.isnan(unknown.value[0, 1])


def test_correlation_of_the_normal_numbers_gives_that_of_the_values():
    matrix = np.array([[1.0, 0.6], [0.6, 1.0]])
    shape = np.array([0.5, -0.3])
    behind = score_correlation(matrix, shape)[0, 1]
    node, weight = np.polynomial.hermite_e.hermegauss(40)
    first, second = np.meshgrid(node, node)
    x = value_at(first, 0.0, 1.0, shape[0])
    y = value_at(behind * first + np.sqrt(1.0 - behind**2) * second, 0.0, 1.0, shape[1])
    share = np.outer(weight, weight) / weight.sum() ** 2
    center_x, center_y = x - np.sum(share * x), y - np.sum(share * y)
    product = np.sum(share * center_x * center_y)
    norm = np.sqrt(np.sum(share * center_x**2) * np.sum(share * center_y**2))
    assert product / norm == pytest.approx(0.6, rel=1e-6)


def test_cusum_of_a_shift_of_one_sigma_signals_at_its_eleventh_wheel():
    """The sum grows by 1 - 0.5 a wheel, and 5 is not beyond the limit of 5."""
    chart = control_chart(np.array([0.0] * 10 + [1.0] * 15 + [-3.5]))
    assert chart.above[19] == pytest.approx(5.0)
    assert chart.shifts == (20,)
    assert chart.beyond == (25,)
    assert chart.above[21] == pytest.approx(0.5)
    assert control_chart(-np.array([1.0] * 11)).below[-1] == pytest.approx(5.5)


def test_control_charts_have_the_stated_rates_of_false_signals():
    """One wheel in 370 and in 465 (Montgomery, table 9.3), within 4 sigma."""
    chart = control_chart(np.random.default_rng(910811).standard_normal(200_000))
    assert len(chart.beyond) == pytest.approx(200_000 / 370.4, abs=4.0 * np.sqrt(540.0))
    assert len(chart.shifts) == pytest.approx(200_000 / 465.0, abs=4.0 * np.sqrt(430.0))


def test_drift_is_a_weighted_line_whose_sigma_has_the_spread_of_the_wheels():
    random = np.random.default_rng(910808)
    days = np.sort(random.uniform(0.0, 730.5, 60))
    values = 10.0 + 3.0 * days / 365.25 + np.hypot(1.0, 0.5) * random.standard_normal(60)
    trend = drift(days, values, np.full(60, 0.5), 1.0)
    sigma = np.hypot(1.0, 0.5) / np.sqrt(np.sum((days - days.mean()) ** 2)) * 365.25
    assert trend.slope == pytest.approx(np.polyfit(days / 365.25, values, 1)[0], rel=1e-9)
    assert sigma * 0.999 <= trend.sigma <= 1.3 * sigma
    assert trend.significant
    assert drift(np.repeat([0.0, 1.0], 30), values, np.full(60, 0.5), 1.0) is None


@pytest.mark.parametrize("rule", ["lowest", "highest", "matched"])
def test_the_best_set_is_the_best_of_all_sets(rule):
    values = np.random.default_rng(910809).uniform(1.0, 2.0, 11)
    draws = np.tile(values, (5, 1))
    cost = {"lowest": np.mean, "highest": lambda x: -np.mean(x), "matched": np.var}[rule]
    expected = min(combinations(range(11), 4), key=lambda wheels: cost(values[list(wheels)]))
    best = best_set(rule, "coulomb", draws, 4)
    assert best.wheels == expected
    assert (best.probability, best.excess) == (1.0, 0.0)


def test_the_probability_of_the_best_set_is_that_of_the_true_values():
    """Of two wheels the lower estimate belongs to the lower one with a known probability."""
    lot, error = (0.0, 1.0, 0.0), np.array([0.5, 0.5])
    draws = true_values(np.array([0.0, 0.4]), error, lot, np.random.default_rng(910810))
    shrunk, sigma = 0.4 / 1.25, np.sqrt(0.25 / 1.25)
    assert draws.mean(axis=0) == pytest.approx([0.0, shrunk], abs=0.03)
    assert draws.std(axis=0) == pytest.approx(sigma, rel=0.05)
    best = best_set("lowest", "coulomb", draws, 1)
    assert best.wheels == (0,)
    expected = stats.norm.cdf(shrunk / (np.sqrt(2.0) * sigma))
    assert best.probability == pytest.approx(expected, abs=0.03)
