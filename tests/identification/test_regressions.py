"""Regressions of hypotheses that share eliminations, against each regression alone."""

from itertools import product

import numpy as np
import pytest

from gyrostat.identification.uncertainty.regressions import Regressions

WIDTHS = (1, 3, 2)
MEANS = (np.zeros(1), np.array([0.4, 0.0, -1.1]), np.zeros(2))


@pytest.fixture(scope="module")
def case():
    """Two levels, two parameters, and three effects; the second is certain and has a mean."""
    random = np.random.default_rng(3)
    columns = random.standard_normal((2, 30, 9)) * np.geomspace(1.0, 1e3, 9)
    products = np.einsum("gti,gtj->gij", columns, columns)
    information = np.array([[2.0, 0.3], [0.3, 1.0]])
    choices = np.array(list(product((0.0, 0.1, 2.0), (0.5, 3.0), (0.0, 0.7))))
    pull = np.array([0.2, -0.5])
    return Regressions(products, information, pull, WIDTHS, choices[1:], MEANS)


def alone(case, level, choice):
    """Normal matrix, right-hand side and sum of squares of one hypothesis, absent columns out."""
    present = np.repeat(choice > 0.0, WIDTHS)
    sigma, mean = np.repeat(choice, WIDTHS)[present], np.concatenate(MEANS)[present]
    at = 1 + np.flatnonzero(np.r_[True, True, present])
    precision = np.zeros((len(at), len(at)))
    precision[:2, :2] = case.information
    precision[2:, 2:] = np.diag(sigma**-2)
    centre = np.r_[np.linalg.solve(case.information, case.pull), mean]
    matrix = case.products[level][np.ix_(at, at)] + precision
    right = case.products[level][at, 0] + precision @ centre
    squares = case.products[level][0, 0] + centre @ precision @ centre
    return at - 1, sigma, matrix, right, squares


def test_deviances_are_those_of_each_regression_alone(case):
    found = case.deviances()
    for (level, which), deviance in np.ndenumerate(found):
        _, sigma, matrix, right, squares = alone(case, level, case.choices[which])
        misfit = squares - right @ np.linalg.solve(matrix, right)
        # the determinant is that in prior sigmas
        logs = np.linalg.slogdet(matrix)[1] + 2.0 * np.sum(np.log(sigma))
        assert deviance == pytest.approx(misfit + logs, rel=1e-11)


def test_moments_are_those_of_each_regression_alone(case):
    level, which = np.array([[1, 0, 1, 0], [0, 4, 7, 10]])
    found = case.moments(level, which)
    for k, (g, h) in enumerate(zip(level, which, strict=True)):
        at, _, matrix, right, _ = alone(case, g, case.choices[h])
        inverse, (mean, variance) = np.linalg.inv(matrix), np.zeros((2, 8))
        mean[at], variance[at] = inverse @ right, np.diag(inverse)
        np.testing.assert_allclose(found[0][k], mean, rtol=1e-9)
        np.testing.assert_allclose(found[1][k], inverse[:2, :2], rtol=1e-9)
        np.testing.assert_allclose(found[2][k], variance, rtol=1e-9)


def test_parameters_without_information_are_refused(case):
    bare = Regressions(
        np.zeros((1, 9, 9)), np.zeros((2, 2)), case.pull, WIDTHS, case.choices, MEANS
    )
    with np.errstate(invalid="ignore"), pytest.raises(np.linalg.LinAlgError):
        bare.deviances()
