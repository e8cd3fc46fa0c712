"""Residual tests: their size under independence and their power against correlation."""

from itertools import pairwise, permutations

import numpy as np
import pytest
from scipy.stats import chi2, f, kstest, norm

from gyrostat.identification.fit.loss import Huber, Quadratic
from gyrostat.identification.read.statistics import (
    Whiteness,
    autocorrelation,
    block_tests,
    correlation_length,
    noise_level,
    quantum,
    serial_meat,
    whiteness,
)
from gyrostat.identification.uncertainty.sigmas import residual_levels


def test_probabilities_are_uniform_for_white_residuals():
    random = np.random.default_rng(0)
    tests = [whiteness(random.standard_normal(400)) for _ in range(300)]
    assert kstest([t.ljung_box_probability for t in tests], "uniform").pvalue > 0.01
    # the run count is discrete, so its probabilities are only nearly uniform
    assert np.mean([t.runs_probability < 0.05 for t in tests]) == pytest.approx(0.05, abs=0.04)


@pytest.mark.parametrize("rho", [0.2, -0.2])
def test_correlated_residuals_are_not_white(rho):
    random = np.random.default_rng(1)
    noise = random.standard_normal(2000)
    for k in range(1, len(noise)):
        noise[k] += rho * noise[k - 1]
    assert not whiteness(noise).white


@pytest.mark.parametrize(("shared", "shown"), [(0.07, False), (0.4, True)])
def test_a_pattern_that_three_thousand_samples_do_not_show_is_ignored(shared, shown):
    """Means of four samples that share their ends have a correlation of 0.07."""
    noise = np.random.default_rng(2).standard_normal(100_001)
    # correlation of neighbours: share / (1 + share**2)
    share = (1.0 - np.sqrt(1.0 - 4.0 * shared**2)) / (2.0 * shared)
    residual = noise[1:] + share * noise[:-1]
    every, few = whiteness(residual), whiteness(residual, power=3000)
    for name in ("ljung_box_probability", "runs_probability"):
        assert getattr(every, name) < 1e-9
        assert (getattr(few, name) < 1e-4) == shown


def test_constant_residuals_have_one_run_and_no_crash():
    test = whiteness(np.zeros(50))
    assert test.runs == 1
    assert np.isfinite(test.ljung_box_probability)


def test_noise_level_ignores_steps_and_slopes():
    random = np.random.default_rng(2)
    time = np.arange(5000) * 0.1
    speed = 3.0 * time + 40.0 * (time > 200.0) + 0.7 * random.standard_normal(5000)
    assert noise_level(speed) == pytest.approx(0.7, rel=0.05)


def test_noise_level_of_a_coarse_tachometer_is_not_zero():
    speed = 2.83 * np.round(np.linspace(0.0, 100.0, 3000) / 2.83)
    assert 0.0 < noise_level(speed) < 2.83


def test_noise_level_of_rare_steps_is_their_standard_deviation():
    """Where most second differences are zero: steps up and down in a twentieth of the samples."""
    random = np.random.default_rng(5)
    noise = random.choice([-1.0, 0.0, 1.0], 40_000, p=[0.025, 0.95, 0.025])
    assert noise_level(2.0 * noise) == pytest.approx(2.0 * np.sqrt(0.05), rel=0.02)


def test_ljung_box_statistic_equals_its_definition():
    """Ljung and Box 1978: n (n + 2) sum of rho_k² / (n - k), chi-square with as many lags."""
    residual = np.random.default_rng(6).standard_normal(45)
    centred = residual - np.mean(residual)
    rho = [
        sum(centred[i] * centred[i + k] for i in range(45 - k)) / sum(centred**2)
        for k in range(1, 9)
    ]
    expected = 45 * 47 * sum(r**2 / (45 - k) for k, r in enumerate(rho, start=1))
    test = whiteness(residual)
    np.testing.assert_allclose(autocorrelation(residual, 8), rho, rtol=0.0, atol=1e-14)
    assert test.lags == 8
    assert test.ljung_box == pytest.approx(expected, rel=1e-12)
    assert test.ljung_box_probability == pytest.approx(chi2.sf(expected, 8), rel=1e-12)


def test_serial_covariance_equals_the_weighted_sum_of_newey_and_west():
    """Weight 1 - k / (lags + 1) of each lag k, written out sample by sample."""
    scores = np.random.default_rng(7).standard_normal((12, 2))
    expected = sum(
        (1.0 - abs(i - j) / 4.0) * np.outer(scores[i], scores[j])
        for i in range(12)
        for j in range(12)
        if abs(i - j) <= 3
    )
    np.testing.assert_allclose(serial_meat(scores, 3), expected, rtol=0.0, atol=1e-13)


def test_residual_levels_count_the_estimated_parameters():
    """Unbiased variance of a straight-line fit: NumPy's residual sum over n - 2."""
    time = np.arange(40.0)
    measured = 3.0 * time + np.random.default_rng(8).standard_normal(40)
    line, squares, *_ = np.polyfit(time, measured, 1, full=True)
    residual = measured - np.polyval(line, time)
    (level,) = residual_levels([residual], 2, Quadratic())
    assert level == pytest.approx(np.sqrt(squares[0] / 38.0), rel=1e-12)


def test_residual_levels_of_a_robust_loss_are_those_of_a_normal_core():
    """The median absolute deviation of normal samples, with a tenth of outliers."""
    core = np.random.default_rng(9).normal(0.0, 0.3, 20_000)
    outliers = np.full(400, 50.0)
    (level,) = residual_levels([np.concatenate([core, outliers])], 3, Huber())
    assert level == pytest.approx(0.3, rel=0.04)


def test_quantum_is_found_only_where_there_is_one():
    random = np.random.default_rng(3)
    smooth = random.standard_normal(3000)
    assert quantum(smooth) is None
    assert quantum(0.25 * np.round(4.0 * smooth)) == pytest.approx(0.25)


def test_serial_covariance_matches_the_long_run_variance_of_an_autoregression():
    rho, count = 0.6, 200_000
    random = np.random.default_rng(4)
    series = random.standard_normal(count)
    for k in range(1, count):
        series[k] += rho * series[k - 1]
    lags = correlation_length(series)
    estimate = serial_meat(series[:, None], 4 * lags)[0, 0] / count
    assert estimate == pytest.approx(1.0 / (1.0 - rho) ** 2, rel=0.1)


def test_all_tests_together_reject_white_residuals_in_one_record_of_twenty():
    """Residuals of a linear fit, whose parameters take away slow variation."""
    random = np.random.default_rng(5)
    time = np.linspace(-1.0, 1.0, 400)
    rows = np.column_stack([np.ones(400), time, time**2, np.sign(np.sin(20.0 * time))])
    basis = np.linalg.qr(rows)[0]
    rejected = 0
    for _ in range(600):
        noise = random.standard_normal(400)
        rejected += not whiteness(noise - basis @ (basis.T @ noise), 7.0 * rows).white
    assert 0.025 < rejected / 600 < 0.075


def test_probabilities_of_block_means_are_uniform_for_white_residuals():
    random = np.random.default_rng(6)
    found = [block_tests(random.standard_normal(500)) for _ in range(300)]
    for length in (2, 8, 32):
        assert kstest([each[length] for each in found], "uniform").pvalue > 0.01


def test_block_tests_are_those_of_the_f_distribution():
    """Degrees of freedom as traces of projectors, written out as matrices; SciPy's distribution."""
    random, count = np.random.default_rng(8), 64
    rows = np.column_stack([np.ones(count), np.linspace(-1.0, 1.0, count)])
    residual_space = np.eye(count) - rows @ np.linalg.pinv(rows)
    for level in (0.0, 0.3, 0.6):
        noise = random.standard_normal(count) + level * np.sin(np.arange(count) / 4.0)
        residual = residual_space @ noise
        found = block_tests(residual, rows)
        assert [*found] == [2, 4, 8]
        for length, probability in found.items():
            blocks = np.kron(np.eye(count // length), np.full((length, length), 1.0 / length))
            between, freedom = residual @ blocks @ residual, np.trace(blocks @ residual_space)
            rest = count - 2 - freedom
            ratio = (between / freedom) / ((residual @ residual - between) / rest)
            tail = f.sf(ratio, freedom, rest)
            assert probability == pytest.approx(2.0 * min(tail, 1.0 - tail), abs=3e-3)


def test_the_probability_of_all_tests_is_that_of_bonferroni_and_one_at_most():
    parts = {"runs": 3, "runs_expected": 3.0, "lags": 2, "ljung_box": 1.0}
    parts |= {"block_lengths": (2, 4), "ljung_box_probability": 0.4}
    found = Whiteness(**parts, runs_probability=0.3, block_probabilities=(0.02, 0.5))
    assert found.probability == pytest.approx(4 * 0.02)
    assert found.worst_block == (2, 0.02)
    assert (
        Whiteness(**parts, runs_probability=0.3, block_probabilities=(0.9, 0.5)).probability == 1.0
    )


def test_block_means_see_what_twenty_lags_do_not():
    random = np.random.default_rng(7)
    slow = 0.2 * np.sin(np.arange(3000) / 150.0)
    tests = [whiteness(random.standard_normal(3000) + slow) for _ in range(20)]
    assert sum(not test.white for test in tests) >= 19
    assert sum(test.ljung_box_probability < 0.01 for test in tests) < 15


def test_the_power_of_more_samples_than_there_are_changes_nothing():
    residual = np.random.default_rng(11).standard_normal(300)
    assert whiteness(residual, power=600) == whiteness(residual)


def test_runs_are_those_of_wald_and_wolfowitz():
    """Mean and variance of the runs over all orders of the signs, counted."""
    signs = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0])
    orders = {tuple(each) for each in permutations(signs)}
    runs = [1 + sum(a != b for a, b in pairwise(each)) for each in orders]
    series = np.array([0.4, 0.3, -0.2, 0.9, -0.5, -0.3, -0.8])
    # the median is one of the values below it
    found = whiteness(series)
    assert (found.runs, found.runs_expected) == (4, pytest.approx(np.mean(runs)))
    z = abs(4 - np.mean(runs)) / np.std(runs)
    assert found.runs_probability == pytest.approx(2.0 * norm.sf(z), rel=1e-12)


def test_one_white_record_of_twenty_is_rejected():
    """The documented false-alarm rate of all tests together, 5 %."""
    random = np.random.default_rng(7)
    rejected = [not whiteness(random.standard_normal(300)).white for _ in range(4000)]
    assert 0.035 < np.mean(rejected) < 0.06
