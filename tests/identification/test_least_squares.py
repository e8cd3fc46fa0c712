"""The square-root solver against closed forms and scipy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares, rosen

from gyrostat.identification.fit.least_squares import Prior, minimise, triangularise
from gyrostat.identification.fit.loss import LOSSES, Huber, Quadratic


def linear(rows, right):
    return lambda x: (right - rows @ x, rows)


def nothing_known(count):
    return Prior(np.zeros(count), np.full(count, np.inf))


def test_triangle_is_a_square_root_of_the_normal_equations():
    random = np.random.default_rng(3)
    rows, right = random.standard_normal((40, 5)), random.standard_normal(40)
    triangle, reduced = triangularise(rows, right)
    np.testing.assert_allclose(triangle.T @ triangle, rows.T @ rows, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(triangle.T @ reduced, rows.T @ right, rtol=1e-12, atol=1e-12)
    assert np.all(np.tril(triangle, -1) == 0.0)


@given(st.integers(0, 10**6))
def test_linear_problem_with_a_priori_equals_the_kalman_update(seed):
    random = np.random.default_rng(seed)
    rows, right = random.standard_normal((12, 3)), random.standard_normal(12)
    mean, sigma = random.standard_normal(3), random.uniform(0.1, 3.0, 3)
    solution = minimise(linear(rows, right), np.zeros(3), Prior(mean, sigma), Quadratic())
    before = np.diag(sigma**2)
    gain = before @ rows.T @ np.linalg.inv(rows @ before @ rows.T + np.eye(12))
    np.testing.assert_allclose(solution.x, mean + gain @ (right - rows @ mean), atol=1e-10)
    np.testing.assert_allclose(solution.covariance(), before - gain @ rows @ before, atol=1e-10)
    assert solution.converged


def test_ill_conditioned_problem_keeps_digits_that_normal_equations_lose():
    small = 1e-9
    rows = np.array([[1.0, 1.0], [small, 0.0], [0.0, small]])
    exact = np.array([2.0, -1.0])
    solution = minimise(linear(rows, rows @ exact), np.zeros(2), nothing_known(2), Quadratic())
    np.testing.assert_allclose(solution.x, exact, rtol=1e-6)
    assert np.linalg.matrix_rank(rows.T @ rows) == 1


def test_a_priori_residual_stays_relative_to_the_original_a_priori():
    """Were the a-priori moved along with the iterate, a curved problem would end elsewhere."""

    def evaluate(x):
        return np.array([4.0 - x[0] ** 2]), np.array([[2.0 * x[0]]])

    solution = minimise(
        evaluate,
        np.array([1.0]),
        Prior(np.array([1.0]), np.array([0.5])),
        Quadratic(),
        tolerance=1e-8,
    )
    x = solution.x[0]
    assert 2.0 * x * (4.0 - x**2) - (x - 1.0) / 0.25 == pytest.approx(0.0, abs=1e-4)


def test_rosenbrock_valley_needs_damping_and_is_reached():
    def evaluate(x):
        residual = np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])
        return residual, np.array([[20.0 * x[0], -10.0], [1.0, 0.0]])

    solution = minimise(
        evaluate,
        np.array([-1.9, 2.0]),
        nothing_known(2),
        Quadratic(),
        tolerance=1e-8,
        max_iterations=200,
    )
    assert solution.converged
    assert rosen(solution.x) < 1e-12


def test_inadmissible_start_and_trials():
    def positive_only(x):
        return None if x[0] <= 0.0 else (np.array([np.log(x[0])]), np.array([[-1.0 / x[0]]]))

    assert minimise(positive_only, np.array([-1.0]), nothing_known(1), Quadratic()) is None
    solution = minimise(positive_only, np.array([8.0]), nothing_known(1), Quadratic())
    assert solution.x[0] == pytest.approx(1.0, abs=1e-3)


def test_a_wall_far_from_the_optimum_is_no_arrival():
    def up_to_one(x):
        return None if x[0] > 1.0 else (100.0 * (5.0 - x), np.array([[100.0]]))

    solution = minimise(up_to_one, np.array([0.0]), nothing_known(1), Quadratic())
    assert solution.x[0] < 1.0
    assert not solution.converged
    assert "not admissible" in solution.reason


def test_a_jacobian_that_points_uphill_is_no_arrival():
    solution = minimise(
        lambda x: (10.0 * (x - 5.0), np.array([[10.0]])),
        np.array([0.0]),
        nothing_known(1),
        Quadratic(),
    )
    assert not solution.converged
    assert "no correction lowered the cost" in solution.reason


def test_a_minimum_on_a_kink_is_an_arrival():
    """The cost (1 + |x|)²/2 falls towards zero from both sides with a slope that never vanishes."""

    def evaluate(x):
        return np.array([-1.0 - abs(x[0])]), np.array([[np.sign(x[0])]])

    solution = minimise(evaluate, np.array([-0.7]), nothing_known(1), Quadratic())
    assert solution.converged
    assert abs(solution.x[0]) < 0.1


def test_knowledge_of_a_difference_is_that_of_a_measured_one():
    random = np.random.default_rng(4)
    rows, right = random.standard_normal((9, 2)), random.standard_normal(9)
    prior = Prior(np.array([0.0, 0.3]), np.array([np.inf, 0.05]), {1: 0})
    solution = minimise(linear(rows, right), np.zeros(2), prior, Quadratic())
    whole = np.vstack([rows, np.array([-1.0, 1.0]) / 0.05])
    expected = np.linalg.lstsq(whole, np.append(right, 0.3 / 0.05), rcond=None)[0]
    np.testing.assert_allclose(solution.x, expected, atol=1e-10)
    np.testing.assert_allclose(solution.covariance(), np.linalg.inv(whole.T @ whole), rtol=1e-9)


def test_out_of_iterations_is_said():
    def evaluate(x):
        return np.array([np.exp(x[0])]), np.array([[-np.exp(x[0])]])

    solution = minimise(evaluate, np.array([0.0]), nothing_known(1), Quadratic(), max_iterations=4)
    assert not solution.converged
    assert solution.iterations == 4


@pytest.mark.parametrize(("name", "scipy_name"), [("huber", "huber"), ("quadratic", "linear")])
def test_minimum_of_a_loss_agrees_with_scipy(name, scipy_name):
    random = np.random.default_rng(7)
    time = np.linspace(0.0, 4.0, 80)
    data = 3.0 * np.exp(-0.7 * time) + 0.05 * random.standard_normal(80)
    data[::9] += 2.0

    def evaluate(x):
        decay = np.exp(-x[1] * time)
        return (data - x[0] * decay) / 0.05, np.column_stack([decay, -x[0] * time * decay]) / 0.05

    ours = minimise(evaluate, np.array([2.0, 1.0]), nothing_known(2), LOSSES[name], tolerance=1e-7)
    theirs = least_squares(
        lambda x: evaluate(x)[0],
        [2.0, 1.0],
        jac=lambda x: -evaluate(x)[1],
        loss=scipy_name,
        f_scale=Huber().knee,
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-12,
    )
    np.testing.assert_allclose(ours.x, theirs.x, rtol=1e-6)


@pytest.mark.parametrize("name", sorted(LOSSES))
def test_weights_and_curvatures_are_the_derivatives_of_the_loss(name):
    loss = LOSSES[name]
    residual = np.array([-4.0, -1.0, -0.2, 0.3, 1.1, 2.5, 9.0])
    step = 1e-6
    slope = (loss.value(residual + step) - loss.value(residual - step)) / (2.0 * step)
    np.testing.assert_allclose(loss.weight(residual) * residual, slope, rtol=1e-6)

    def gradient(r):
        return loss.weight(r) * r

    bend = (gradient(residual + step) - gradient(residual - step)) / (2.0 * step)
    np.testing.assert_allclose(loss.curvature(residual), bend, rtol=1e-5, atol=1e-9)
