"""Distributions of dispersed values, against SciPy, quadrature and analytic variances."""

import hashlib
from pathlib import Path

import numpy as np
import pytest
from scipy import integrate, stats

from gyrostat.campaigns.draws import draw, values_at
from gyrostat.campaigns.effects import find_effects, inputs_of
from gyrostat.core.errors import InputError
from gyrostat.scenario import Dispersion, Scenario
from gyrostat.scenario.kinds import distributions
from gyrostat.scenario.kinds.distributions import DISTRIBUTIONS, NAMED, distribution_of
from gyrostat.scenario.unlikely import unlikely_numbers
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.search.worst_case import WorstCase

KEY = "wheel.a.speed"
NOMINAL = 3.0
ALONE = {
    "normal": ((0.4,), stats.norm(3.0, 0.4)),
    "log_normal": ((0.4,), stats.lognorm(0.4, scale=3.0)),
    "uniform": ((2.0, 7.0), stats.uniform(2.0, 5.0)),
    "triangular": ((2.0, 7.0, 3.0), stats.triang(0.2, 2.0, 5.0)),
    "triangular at its end": ((3.0, 7.0, 3.0), stats.triang(0.0, 3.0, 4.0)),
    "truncated_normal": ((0.4, 2.5, 5.0), stats.truncnorm(-1.25, 5.0, 3.0, 0.4)),
    "truncated_normal at both": ((0.4, 2.5, 3.3), stats.truncnorm(-1.25, 0.75, 3.0, 0.4)),
    "truncated_normal below": ((0.4, 2.9, np.inf), stats.truncnorm(-0.25, np.inf, 3.0, 0.4)),
}
"""Name -> parameters, and the distribution of SciPy."""


def alone(name, parameters):
    made = Dispersion((KEY,), name.partition(" ")[0], (parameters,))
    return distribution_of(made, {KEY: NOMINAL})


def test_each_distribution_is_tested():
    assert {name.partition(" ")[0] for name in ALONE} == set(NAMED)
    assert set(DISTRIBUTIONS) - set(NAMED) == {"covariance", "lot"}


@pytest.mark.parametrize(("name", "given"), ALONE.items(), ids=ALONE)
def test_quantiles_and_bounds_are_those_of_scipy(name, given):
    parameters, expected = given
    found = alone(name, parameters)
    share = np.concatenate([np.linspace(0.001, 0.999, 333), [1e-7, 1.0 - 1e-7]])
    np.testing.assert_allclose(found.quantile(share[:, None])[:, 0], expected.ppf(share), rtol=1e-9)
    assert list(found.faults()) == []
    low, high = expected.support()
    if name != "log_normal":  # nothing is below 0, but no parameter says so
        assert [float(each[0]) for each in found.bounds()] == pytest.approx([low, high])
    assert found.is_bounded()[0] == (np.isfinite(low) and np.isfinite(high))
    ends = [
        bound if np.isfinite(bound) and name != "log_normal" else expected.ppf(stats.norm.cdf(x))
        for bound, x in ((low, -3.0), (high, 3.0))
    ]
    assert [float(each[0]) for each in found.extremes(3.0)] == pytest.approx(ends, rel=1e-9)


def test_a_lot_is_log_normal_and_normal_with_a_correlation():
    rows = ((4.0, 2.0, 0.5, 1.0, 0.0), (-1.0, 0.3, 0.0, 0.6, 0.8))
    keys = ("wheel.a.coulomb", "wheel.a.viscous")
    found = distribution_of(Dispersion(keys, "lot", rows), dict.fromkeys(keys, 99.0))
    share = np.random.default_rng(910860).random((20_000, 2))
    values = found.quantile(share)
    expected = stats.lognorm(0.5, scale=4.0).ppf(share[:, 0])
    np.testing.assert_allclose(values[:, 0], expected, rtol=1e-9)
    score = (values[:, 1] + 1.0) / 0.3
    assert stats.kstest(score, "norm").pvalue > 0.001
    assert np.corrcoef(stats.norm.ppf(share[:, 0]), score)[0, 1] == pytest.approx(0.6, abs=0.02)
    assert found.is_joint()
    assert list(found.faults()) == []
    low, high = found.extremes(3.0)
    np.testing.assert_allclose(low, [4.0 * np.exp(-1.5), -1.9])
    np.testing.assert_allclose(high, [4.0 * np.exp(1.5), -0.1])


def test_the_upper_end_is_as_exact_as_the_lower_one():
    """Values of a share near 1 from the distance to 1, which has more digits."""
    found = alone("truncated_normal", (0.4, -np.inf, 3.0 + 0.4 * 9.0))
    share = np.array([[1.0 - 2.0**-53]])
    expected = 3.0 - 0.4 * stats.norm.ppf(2.0**-53)
    assert float(found.quantile(share)[0, 0]) == pytest.approx(expected, rel=1e-3)
    assert float(found.quantile(np.array([[1.0]]))[0, 0]) == pytest.approx(6.6)


@pytest.mark.parametrize("name", ["triangular", "triangular at its end", "truncated_normal"])
def test_polynomials_are_orthonormal_over_the_density(name):
    """By quadrature over the value, not over the share."""
    parameters, expected = ALONE[name]
    (family,) = alone(name, parameters).families()
    kink, degree = parameters[-1] if name == "triangular" else 3.0, family.highest
    node, weight = np.polynomial.legendre.leggauss(60)
    gram = np.zeros((degree + 1, degree + 1))
    low, high = expected.support()
    for start, end in ((low, kink), (kink, high)):
        value = start + 0.5 * (end - start) * (node + 1.0)
        density = 0.5 * (end - start) * weight * expected.pdf(value)
        basis = family.values(expected.cdf(value), degree)
        gram += basis.T * density @ basis
    np.testing.assert_allclose(gram, np.eye(degree + 1), atol=1e-5)


def test_a_half_open_normal_has_polynomials_of_its_own_density():
    parameters, expected = ALONE["truncated_normal below"]
    (family,) = alone("truncated_normal below", parameters).families()
    value = np.array([2.95, 3.2, 4.0])
    basis = family.values(expected.cdf(value), 2)
    np.testing.assert_allclose(basis[:, 1], (value - expected.mean()) / expected.std(), atol=1e-6)
    product, _ = integrate.quad(
        lambda x: expected.pdf(x) * np.prod(family.values(np.array([expected.cdf(x)]), 2)[0]),
        2.9,
        6.0,
    )
    assert product == pytest.approx(0.0, abs=1e-6)


@pytest.fixture
def with_dispersions(scenario):
    """The small scenario with other dispersions."""
    return lambda *rows: scenario.replace(dispersions=tuple(Dispersion(*row) for row in rows))


def test_the_indices_of_a_sum_are_the_shares_of_the_variance(with_dispersions):
    rows = [
        (("wheel.a.speed",), "triangular", ((-2.0, 7.0, 3.0),)),
        (("wheel.b.speed",), "truncated_normal", ((4.0, -22.0, -19.0),)),
        (("start.rate.x",), "normal", ((0.01,),)),
    ]
    made = with_dispersions(*rows)
    nominal = made.values["wheel.b.speed"]
    variances = [
        stats.triang(5.0 / 9.0, -2.0, 9.0).var(),
        stats.truncnorm((-22.0 - nominal) / 4.0, (-19.0 - nominal) / 4.0, nominal, 4.0).var(),
        1e-4,
    ]
    runs = np.arange(400)
    drawn, _ = draw(made, 3, runs)
    columns = {"run": runs, **dict(zip(made.dispersed, drawn.T, strict=True))}
    inputs = inputs_of(made, 3, columns)
    weights = np.array([1.0, 2.0, 300.0])
    (found,) = find_effects(inputs, (drawn @ weights)[:, None])
    expected = weights**2 * variances / np.sum(weights**2 * variances)
    np.testing.assert_allclose(found.first[:, 0], expected, atol=0.05)
    assert found.q2 > 1.0 - 1e-9


def test_draws_are_the_same_in_every_version(with_dispersions):
    rows = [
        (("start.rate.x",), "normal", ((0.01,),)),
        (("wheel.b.speed",), "uniform", ((6.0, 10.0),)),
        (("wheel.a.inertia",), "log_normal", ((0.5,),)),
        (("wheel.a.viscous", "wheel.a.coulomb"), "covariance", ((3e-9, 0.0), (-4e-7, 3e-7))),
    ]
    made = with_dispersions(*rows)
    share = np.array([[0.25, 0.5, 0.75, 0.1, 0.9]])
    nominal = [made.values[key] for key in made.dispersed]
    z = stats.norm.ppf(share[0])
    expected = [
        nominal[0] + 0.01 * z[0],
        8.0,
        nominal[2] * np.exp(0.5 * z[2]),
        nominal[3] + 3e-9 * z[3],
        nominal[4] - 4e-7 * z[3] + 3e-7 * z[4],
    ]
    np.testing.assert_allclose(values_at(made, share)[0], expected, rtol=1e-13)
    drawn, _ = draw(made, 3, np.arange(3))
    assert drawn[:, 1].tolist() == [9.817485406980861, 9.73619729739907, 9.638087893678527]
    bits = hashlib.sha256(np.ascontiguousarray(draw(made, 5, np.arange(5000))[0][:, 1]).tobytes())
    assert bits.hexdigest()[:16] == "87142d462357621b"


@pytest.fixture
def weibull(monkeypatch):
    """The distribution that CONTRIBUTING.md adds."""
    text = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    module: dict[str, object] = {"__name__": "weibull"}
    exec(text.partition("dispersion/weibull.py`:\n\n```python\n")[2].partition("```")[0], module)
    monkeypatch.setitem(distributions.DISTRIBUTIONS, "weibull", module["Weibull"])


def test_a_class_with_a_quantile_function_is_all_that_a_distribution_needs(
    weibull, with_dispersions
):
    made = with_dispersions(
        (("wheel.a.motor_constant",), "weibull", ((3.0,),)),
        (("start.rate.x",), "normal", ((0.01,),)),
    )
    drawn, _ = draw(made, 1, np.arange(1000))
    scale = made.values["wheel.a.motor_constant"]
    expected = stats.weibull_min(3.0, scale=scale)
    assert stats.kstest(drawn[:, 0], expected.cdf).pvalue > 1e-3
    columns = {"run": np.arange(1000), **dict(zip(made.dispersed, drawn.T, strict=True))}
    (found,) = find_effects(inputs_of(made, 1, columns), drawn[:, :1])
    np.testing.assert_allclose(found.first[:, 0], [1.0, 0.0], atol=1e-3)
    assert Scenario.from_text(made.text()) == made


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        (("lognormal", ((0.1,),)), "found distribution 'lognormal', expected one of covariance, "),
        (("normal", ((0.1, 0.2),)), "found parameters ((0.1, 0.2),), expected (sigma) for each"),
        (("normal", ()), "found parameters (), expected (sigma) for each key"),
        (("normal", ((-0.1,),)), "found normal with sigma of ((-0.1,),), expected a sigma above 0"),
        (("normal", ((np.nan,),)), "expected a sigma above 0"),
        (("uniform", ((2.0, 1.0),)), "expected more than low"),
        (("covariance", ((1.0, 0.0),)), "expected a square matrix with a row for each key"),
    ],
)
def test_dispersions_of_python_that_cannot_be_are_one_line(with_dispersions, row, expected):
    with pytest.raises(InputError) as caught:
        with_dispersions((("wheel.a.speed",), *row))
    assert expected in str(caught.value)
    assert "dispersion of wheel.a.speed: found" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.fixture
def read(short):
    """Reads the short scenario with a dispersion of the wheel's inertia, 1.5e-5 kg·m² or so."""

    def with_lines(lines, key="wheel.a.inertia"):
        more = f'[[dispersion]]\nkey = "{key}"\n{lines}\n'
        return read_scenario(short('kind = "three_axis"', more))

    return with_lines


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ('distribution = "triangular"\nlow = "-10 %"\nhigh = "20 %"', (0.9, 1.2, 1.0)),
        (
            'distribution = "triangular"\nlow = "-10 %"\nhigh = "20 %"\nmode = "5 %"',
            (0.9, 1.2, 1.05),
        ),
        (
            'distribution = "truncated_normal"\nsigma = "4 %"\nlow = "-10 %"',
            (0.04, 0.9, np.inf),
        ),
        ('distribution = "uniform"\nlow = "-10 %"\nhigh = "10 %"', (0.9, 1.1)),
    ],
)
def test_parameters_of_a_file_are_relative_to_the_nominal_value(read, lines, expected):
    found = read(lines)
    ratios = np.array(found.dispersions[0].parameters[0]) / found.values["wheel.a.inertia"]
    np.testing.assert_allclose(ratios, expected, rtol=1e-12)
    assert Scenario.from_text(found.text()) == found
    drawn = draw(found, 0, np.arange(300))[0][:, 0] / found.values["wheel.a.inertia"]
    assert expected[0] * (expected[0] > 0.1) <= np.min(drawn) < 0.99
    assert np.max(drawn) > 1.01


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ('distribution = "triangle"', "distribution: found 'triangle', expected one of log_normal"),
        ('distribution = "covariance"', "found 'covariance', expected one of log_normal, normal,"),
        ('distribution = "triangular"\nlow = "-1 %"', "key dispersion[0].high: found None"),
        (
            'distribution = "triangular"\nlow = "1 %"\nhigh = "2 %"',
            "mode: found 'none', expected low to high, by default the nominal value",
        ),
        (
            'distribution = "triangular"\nlow = "2 %"\nhigh = "1 %"',
            "high: found '1 %', expected more than low",
        ),
        (
            'distribution = "truncated_normal"\nsigma = "1 %"\nhigh = "-1 %"',
            "high: found '-1 %', expected at least the nominal value",
        ),
        (
            'distribution = "truncated_normal"\nsigma = "1 %"\nlow = "1 %"',
            "low: found '1 %', expected at most the nominal value",
        ),
        ('distribution = "truncated_normal"\nsigma = 0.0', "expected a sigma above 0"),
        (
            'distribution = "truncated_normal"\nsigma = "50 %"\nlow = "-150 %"',
            "low: found '-150 %', expected wheel.a.inertia",
        ),
        (
            'distribution = "normal"\nsigma = "1 %"\nlow = 0.0',
            "low: found an unknown key, expected key, distribution, sigma",
        ),
        ('distribution = "uniform"\nlow = nan\nhigh = 1.0', "low: found nan"),
    ],
)
def test_dispersions_of_a_file_that_cannot_be_are_one_line(read, lines, expected):
    with pytest.raises(InputError) as caught:
        read(lines)
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_logarithm_of_nothing_is_refused(read):
    with pytest.raises(InputError, match="distribution: found 'log_normal', expected another one"):
        read('distribution = "log_normal"\nsigma = 0.1', key="start.rate.x")


def test_a_stored_scenario_of_another_version_is_one_line(scenario):
    other = scenario.text().replace('"parameters"', '"spread"')
    with pytest.raises(
        InputError, match=r"found other attributes .*spread.* that stored it"
    ) as hit:
        Scenario.from_text(other)
    assert "spread" in str(hit.value)
    assert "\n" not in str(hit.value)


def test_bounds_in_degrees_without_a_unit_are_named(short):
    more = (
        '[[dispersion]]\nkey = "start.attitude_error.x"\ndistribution = "uniform"\n'
        "low = -20.0\nhigh = 20.0\n"
    )
    lines = unlikely_numbers(read_scenario(short('kind = "three_axis"', more)))
    assert [line.partition(" rad")[0] for line in lines] == [
        "unlikely: dispersion of start.attitude_error.x, low: -20",
        "unlikely: dispersion of start.attitude_error.x, high: 20",
    ]


def test_a_box_reaches_the_limits_of_every_limited_distribution(with_dispersions):
    made = with_dispersions(
        (("wheel.a.speed",), "triangular", ((-2.0, 7.0, 3.0),)),
        (("start.rate.x",), "normal", ((0.01,),)),
    )
    box = WorstCase.of(made, "error_max", "box").bounds
    assert box.limited.tolist() == [True, False]
    share = stats.norm.cdf(box.normal(np.array([[-1.0, -1.0], [1.0, 1.0]])))
    drawn = values_at(made, share)
    np.testing.assert_allclose(drawn[:, 0], [-2.0, 7.0])
    np.testing.assert_allclose(drawn[:, 1] - made.values["start.rate.x"], [-0.03, 0.03])
