"""Sobol indices from a table of runs, against analytic solutions and openturns."""

import numpy as np
import pytest
from numpy.polynomial.hermite_e import hermegauss
from numpy.polynomial.legendre import leggauss
from scipy.special import ndtr, ndtri
from scipy.stats import t as student

from gyrostat.campaigns.chaos import basis_of
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.effects import GROUPS, Inputs, find_effects, inputs_of, jackknife
from gyrostat.core.orthonormal import HERMITE, LEGENDRE
from gyrostat.scenario import Dispersion


def independent(random, runs, uniform):
    """Inputs of a made-up campaign, and their standard variables."""
    share = random.random((runs, len(uniform)))
    names = [(f"x{k}",) for k in range(len(uniform))]
    families = [LEGENDRE if each else HERMITE for each in uniform]
    return Inputs(names, share, families, np.arange(len(uniform)))


def ishigami(share, a=7.0, b=0.1):
    x = np.pi * (2.0 * share - 1.0)
    return np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0])


def indices_of_ishigami(a=7.0, b=0.1):
    """T. Ishigami and T. Homma, "An importance quantification technique", 1990."""
    first = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2
    second, both = a**2 / 8.0, b**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    total = first + second + both
    return np.array([first, second, 0.0]) / total, np.array([first + both, second, both]) / total


WEIGHTS = np.array([0.0, 0.5, 3.0, 9.0, 99.0])


def g_function(share):
    parts = (np.abs(4.0 * share - 2.0) + WEIGHTS) / (1.0 + WEIGHTS)
    return np.prod(parts, axis=1)


def indices_of_g():
    """I. M. Sobol', "Theorems and examples on high dimensional model representation", 2003."""
    alone = 1.0 / (3.0 * (1.0 + WEIGHTS) ** 2)
    total = np.prod(1.0 + alone) - 1.0
    return alone / total, alone * np.prod(1.0 + alone) / (1.0 + alone) / total


@pytest.mark.parametrize("degree", [6, 10])
def test_the_polynomials_are_orthonormal(degree):
    """By quadrature that is exact for their products."""
    node, weight = leggauss(degree + 1)
    values = LEGENDRE.values(0.5 * (node + 1.0), degree)
    np.testing.assert_allclose(values.T * (0.5 * weight) @ values, np.eye(degree + 1), atol=1e-12)
    node, weight = hermegauss(degree + 1)
    values = HERMITE.values(ndtr(node), degree)
    gram = values.T * (weight / np.sqrt(2.0 * np.pi)) @ values
    np.testing.assert_allclose(gram, np.eye(degree + 1), atol=1e-6)


def test_terms_of_many_variables_are_those_of_the_most_important():
    basis = basis_of([LEGENDRE] * 30, np.arange(30)[::-1], 100)
    assert len(set(basis.terms)) == len(basis.terms) == basis.cuts[-1] <= 100
    alone = {term[0][0] for term in basis.terms if len(term) == 1 and term[0][1] == 1}
    assert alone == set(range(30))
    pairs = {variable for term in basis.terms for variable, _ in term if len(term) == 2}
    assert pairs
    assert min(pairs) > 15


@pytest.mark.parametrize("runs", [400, 10_000])
def test_indices_of_ishigami_are_the_analytic_ones(runs):
    inputs = independent(np.random.default_rng(1), runs, [True] * 3)
    (found,) = find_effects(inputs, ishigami(inputs.share)[:, None])
    first, total = indices_of_ishigami()
    assert found.why == ""
    assert found.q2 > 0.99
    np.testing.assert_allclose(found.first[:, 0], first, atol=0.01)
    np.testing.assert_allclose(found.total[:, 0], total, atol=0.01)


def test_indices_of_the_g_function_are_the_analytic_ones():
    """Its kinks are no polynomials: what these do not follow is missing in the indices."""
    inputs = independent(np.random.default_rng(2), 10_000, [True] * 5)
    (found,) = find_effects(inputs, g_function(inputs.share)[:, None])
    for part, exact in zip((found.first, found.total), indices_of_g(), strict=True):
        np.testing.assert_allclose(part[:, 0], exact, atol=0.01 + 1.0 - found.q2)
    assert found.q2 > 0.97


def test_the_interval_covers_the_truth():
    """A linear model with noise: the indices are the squared coefficients."""
    slopes, noise = np.array([1.0, 0.7, 0.5, 0.2]), 0.5
    variance = np.sum(slopes**2) + noise**2
    exact, held = slopes**2 / variance, []
    for seed in range(25):
        random = np.random.default_rng(seed)
        inputs = independent(random, 300, [False, True, False, True])
        is_uniform = [each is LEGENDRE for each in inputs.families]
        scale = np.where(is_uniform, np.sqrt(12.0) * (inputs.share - 0.5), ndtri(inputs.share))
        values = (scale @ slopes)[:, None] + noise * random.normal(size=(300, 10))
        for found in find_effects(inputs, values):
            if not found.why:
                held += [(p[:, 1] <= exact) & (exact <= p[:, 2]) for p in found[-2:]]
    assert len(held) > 300
    # 95 %; the cases of one set of inputs are correlated
    assert 0.92 < np.mean(held) < 0.98


def test_noise_and_too_few_runs_are_told_apart():
    random = np.random.default_rng(4)
    inputs = independent(random, 300, [True] * 14)
    scaled = np.sqrt(12.0) * (inputs.share - 0.5)
    noisy = scaled[:, 0] + random.normal(size=300)
    pairs = sum(scaled[:, i] * scaled[:, j] for i in range(10) for j in range(i))
    found = find_effects(inputs, np.stack([noisy, pairs], axis=1))
    assert found[0].why.startswith("not explained by the dispersed values: 4")
    assert found[1].why.endswith("and more runs would help")
    assert all(np.all(np.isnan(each.first)) and each.q2 < 0.8 for each in found)
    few = inputs._replace(share=inputs.share[:42])
    (found_of_few,) = find_effects(few, noisy[:42, None])
    assert found_of_few.why == "not enough runs: 42, at least 45 are needed"
    # nothing but noise: no index is given
    assert max(each.q2 for each in find_effects(inputs, random.normal(size=(300, 20)))) < 0.1


def test_runs_without_the_metric_are_left_out_or_refused():
    inputs = independent(np.random.default_rng(5), 1000, [True] * 3)
    values = np.repeat(ishigami(inputs.share)[:, None], 4, axis=1)
    values[::30, 1] = np.nan
    values[::10, 2] = np.nan
    values[:, 3] = 7.0
    whole, few, many, same = find_effects(inputs, values)
    assert (few.without, few.runs, few.why) == (34, 966, "")
    np.testing.assert_allclose(few.first[:, 0], whole.first[:, 0], atol=0.01)
    assert many.why.startswith("100 of 1000 runs do not have it; in the others the dispersed")
    assert same.why == "it is the same in all runs"


def test_the_jackknife_removes_a_bias_that_falls_with_the_number_of_runs():
    """An estimate that is off by c / n: without a group, by c / (n (1 - 1 / groups))."""
    left = np.full((GROUPS, 1), 0.4 + 0.05 / (1.0 - 1.0 / GROUPS))
    found = jackknife(np.concatenate([[[0.45]], left]))
    np.testing.assert_allclose(found, [[0.4, 0.4, 0.4]], rtol=0.0, atol=1e-14)


def test_the_jackknife_interval_of_a_mean_is_that_of_student():
    groups = np.random.default_rng(9).normal(0.5, 0.01, GROUPS)
    left = (np.sum(groups) - groups) / (GROUPS - 1)
    ((value, low, high),) = jackknife(np.array([np.mean(groups), *left])[:, None])
    half = student.ppf(0.975, GROUPS - 1) * np.std(groups, ddof=1) / np.sqrt(GROUPS)
    assert value == pytest.approx(np.mean(groups), rel=1e-12)
    # the quantile stands in the code with four digits
    np.testing.assert_allclose([value - low, high - value], half, rtol=3e-4)


def test_the_inputs_are_those_of_the_distributions(scenario):
    random = np.random.default_rng(6)
    joint = Dispersion(
        ("wheel.a.viscous", "wheel.a.motor_constant"), "covariance", ((1e-8, 0.0), (1e-4, 2e-4))
    )
    changed = scenario.replace(dispersions=(*scenario.dispersions, joint))
    drawn, _ = draw(changed, 3, np.arange(200))
    columns = {"run": np.arange(200), **dict(zip(changed.dispersed, drawn.T, strict=True))}
    inputs = inputs_of(changed, 3, columns)
    assert inputs.names[-1] == joint.keys
    assert inputs.names[:-1] == [(key,) for key in scenario.dispersed]
    slope = drawn[:, -1] + 1e-7 * random.normal(size=200)
    (found,) = find_effects(inputs, slope[:, None])
    assert found.total[-1, 0] == pytest.approx(1.0, abs=0.01)
    columns["wheel.a.viscous"] = columns["wheel.a.viscous"] + 1e-9
    assert "not those that the scenario draws" in inputs_of(changed, 3, columns)
    del columns["wheel.a.viscous"]
    assert inputs_of(changed, 3, columns) == "the table of runs has no column wheel.a.viscous"


def test_indices_agree_with_openturns():
    openturns = pytest.importorskip("openturns")
    random = np.random.default_rng(8)
    inputs = independent(random, 1000, [False, False, True])
    z, u = ndtri(inputs.share), 2.0 * inputs.share[:, 2] - 1.0
    values = np.exp(0.3 * z[:, 0]) * (1.0 + u**2) + 0.5 * z[:, 1] * u
    (found,) = find_effects(inputs, values[:, None])
    marginals = [openturns.Normal(), openturns.Normal(), openturns.Uniform(-1.0, 1.0)]
    chaos = openturns.LeastSquaresExpansion(
        openturns.Sample(np.column_stack([z[:, :2], u])),
        openturns.Sample(values[:, None]),
        openturns.JointDistribution(marginals),
    )
    chaos.run()
    oracle = openturns.FunctionalChaosSobolIndices(chaos.getResult())
    for k in range(3):
        assert found.first[k, 0] == pytest.approx(oracle.getSobolIndex(k), abs=0.01)
        assert found.total[k, 0] == pytest.approx(oracle.getSobolTotalIndex(k), abs=0.01)
