"""The Riccati solver against scipy, its own equation in NumPy, and differences."""

import re

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrostat.control.design.riccati import lyapunov, riccati
from gyrostat.core.jax64 import jax, jnp

DOUBLE_INTEGRATORS = np.kron(np.eye(3), [[0.0, 1.0], [0.0, 0.0]])


def problem(kind, random):
    """A stabilisable problem of 6 states whose Q sees every undamped mode.

    Where two inputs are meant, a third one does nothing: so one program solves most problems.
    """

    def normal(*shape):
        return random.normal(size=shape)

    def two_inputs():
        return np.append(normal(6, 2), np.zeros((6, 1)), axis=1), np.eye(3)

    def spread(*shape, decades=3.0):
        return 10.0 ** random.uniform(-decades, decades, shape)

    if kind == "single input":
        return normal(6, 6), normal(6, 1), np.eye(6), np.eye(1)
    if kind == "unstable":
        dynamics = normal(6, 6) + 2.0 * np.eye(6)
        input, effort = two_inputs()
        return dynamics, input, np.eye(6), effort
    if kind == "semidefinite":
        half = normal(2, 6)
        dynamics = DOUBLE_INTEGRATORS + 0.1 * normal(6, 6)
        input, effort = two_inputs()
        return dynamics, input, half.T @ half, effort
    if kind == "double integrators":
        input = np.kron(np.eye(3), [[0.0], [1.0 / 12.0]])
        return DOUBLE_INTEGRATORS, input, np.diag(spread(6)), np.diag(spread(3))
    if kind == "chain":
        weight = np.diag([spread().item(), 0.0, 0.0, 0.0, 0.0, 0.0])
        return np.diag(np.ones(5), 1), np.eye(6)[:, 5:], weight, np.eye(1)
    if kind == "bad units":
        units = np.diag(spread(6, decades=4.0))
        inverse = np.linalg.inv(units)
        return units @ normal(6, 6) @ inverse, units @ normal(6, 3), inverse @ inverse, np.eye(3)
    frequency = spread(3, decades=1.0)
    swings = np.kron(np.diag(frequency), [[0.0, 1.0], [-1.0, 0.0]])
    return swings, normal(6, 3), np.eye(6), np.eye(3) * spread().item()


KINDS = [
    "single input",
    "unstable",
    "semidefinite",
    "double integrators",
    "chain",
    "bad units",
    "undamped",
]


def rounding(dynamics, reach, weight, cost):
    """Relative change of P for a relative change of the data by one rounding."""
    closed = dynamics - reach @ cost
    operator = np.kron(np.eye(6), closed.T) + np.kron(closed.T, np.eye(6))
    norm = np.linalg.norm
    size = 2.0 * norm(dynamics) * norm(cost) + norm(weight) + norm(reach) * norm(cost) ** 2
    return 2.2e-16 * size / np.linalg.svd(operator, compute_uv=False)[-1] / norm(cost)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=60)
def test_against_scipy(kind, seed):
    dynamics, input, weight, effort = problem(kind, np.random.default_rng(seed))
    expected = scipy.linalg.solve_continuous_are(dynamics, input, weight, effort)
    found = riccati(dynamics, input, weight, effort)
    cost, norm = np.asarray(found.cost), np.linalg.norm
    reach = input @ np.linalg.solve(effort, input.T)
    left = dynamics.T @ cost + cost @ dynamics + weight - cost @ reach @ cost
    size = 2.0 * norm(dynamics) * norm(cost) + norm(weight) + norm(reach) * norm(cost) ** 2
    assert found.valid
    assert norm(left) < 1e-10 * size
    assert found.residual < 1e-14
    error = norm(cost - expected) / norm(expected)
    assert error < 1e-14 + 100.0 * rounding(dynamics, reach, weight, expected)
    assert np.max(np.linalg.eigvals(dynamics - input @ found.gain).real) < 0.0
    np.testing.assert_allclose(
        found.gain, np.linalg.solve(effort, input.T @ cost), rtol=1e-9, atol=1e-9 * norm(found.gain)
    )


def test_the_residual_against_the_cost_itself():
    """Of 300 random problems with three inputs, none leaves 1e-10 of |P|."""
    random = np.random.default_rng(3)
    dynamics, input = random.normal(size=(300, 6, 6)), random.normal(size=(300, 6, 3))
    found = jax.vmap(riccati, (0, 0, None, None))(dynamics, input, np.eye(6), np.eye(3))
    cost = np.asarray(found.cost)
    half = np.swapaxes(dynamics, 1, 2) @ cost
    spread = cost @ input
    left = half + np.swapaxes(half, 1, 2) + np.eye(6) - spread @ np.swapaxes(spread, 1, 2)
    assert np.all(found.valid)
    assert np.max(np.linalg.norm(left, axis=(1, 2)) / np.linalg.norm(cost, axis=(1, 2))) < 1e-10
    # a batch is the same function
    one = riccati(dynamics[7], input[7], np.eye(6), np.eye(3))
    np.testing.assert_allclose(cost[7], one.cost, rtol=1e-10)


def test_closed_form_of_a_double_integrator():
    """P of x'' = u / J with Q = diag(q1, q2): by hand from the three scalar equations."""
    inertia, q1, q2, r = 12.0, 50.0, 10.0, 100.0
    found = riccati(
        np.array([[0.0, 1.0], [0.0, 0.0]]),
        np.array([[0.0], [1.0 / inertia]]),
        np.diag([q1, q2]),
        np.array([[r]]),
    )
    stiffness = np.sqrt(q1 / r)
    damping = np.sqrt(q2 / r + 2.0 * inertia * stiffness)
    np.testing.assert_allclose(found.gain, [[stiffness, damping]], rtol=1e-13)


def test_derivative_against_differences():
    random = np.random.default_rng(5)
    dynamics, input, weight, effort = problem("semidefinite", random)
    point = dynamics, input, weight + 0.1 * np.eye(6), effort  # definite on both sides
    along = [random.normal(size=part.shape) for part in point]
    along[2], along[3] = along[2] + along[2].T, along[3] + along[3].T

    def gain(scale):
        return riccati(*(p + scale * a for p, a in zip(point, along, strict=True))).gain

    @jax.jit
    def derivatives(scale):
        backward = jax.grad(lambda s: jnp.sum(gain(s) ** 2))(scale)
        return *jax.jvp(gain, (scale,), (1.0,)), backward

    value, slope, backward = derivatives(0.0)
    step = 1e-5
    ahead, behind = (np.asarray(gain(s)) for s in (step, -step))
    np.testing.assert_allclose(slope, (ahead - behind) / (2.0 * step), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(backward, 2.0 * np.sum(value * slope), rtol=1e-9)


def with_mode(eigenvalue, *, reached=False, seen=True):
    """Five modes that two inputs and the weight reach, and one; a third input does nothing."""
    random = np.random.default_rng(11)
    dynamics = np.zeros((6, 6))
    dynamics[:5, :5] = random.normal(size=(5, 5))
    dynamics[5, 5] = eigenvalue
    input = random.normal(size=(6, 2))
    input[5] *= reached
    input = np.append(input, np.zeros((6, 1)), axis=1)
    return dynamics, input, np.diag([1.0] * 5 + [float(seen)]), np.eye(3)


@pytest.mark.parametrize(
    ("what", "arguments"),
    [
        ("a drift that nothing stops", with_mode(0.0)),
        ("an unseen drift that nothing stops", with_mode(0.0, seen=False)),
        ("growth that nothing stops", with_mode(0.7)),
        ("unseen growth that nothing stops", with_mode(0.7, seen=False)),
        ("a drift that costs nothing", with_mode(0.0, reached=True, seen=False)),
        ("efforts that pay", (*with_mode(-1.0)[:3], np.diag([1.0, -1.0, 1.0]))),
        ("no number", (np.full((6, 6), np.nan), *with_mode(-1.0)[1:])),
    ],
)
def test_what_cannot_be_solved_says_so(what, arguments):
    assert not riccati(*arguments).valid, what


def test_what_decays_by_itself_needs_no_input():
    found = riccati(*with_mode(-0.2))
    assert found.valid
    np.testing.assert_allclose(found.cost[5, 5], 1.0 / 0.4, rtol=1e-12)


def test_too_few_doublings_say_so():
    """A swing damped to a share of 1e-4 needs more than the default."""
    swings, input, weight, _ = problem("undamped", np.random.default_rng(0))
    assert not riccati(swings, input, weight, 1e8 * np.eye(3)).valid


def test_lyapunov_against_scipy():
    random = np.random.default_rng(2)
    stable = random.normal(size=(6, 6)) - 4.0 * np.eye(6)
    constant = random.normal(size=(6, 6))
    constant = constant + constant.T
    found, remainder = jax.jit(lyapunov)(stable, constant)
    expected = scipy.linalg.solve_continuous_lyapunov(stable.T, -constant)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12)
    assert remainder < 1e-12
    assert not jax.jit(lyapunov)(-stable, constant)[1] < 1.0


def test_only_what_may_fly():
    """Loops of fixed count and plain arithmetic: no factorisation of a library, no sorting."""
    text = str(jax.make_jaxpr(riccati)(*with_mode(-1.0)))
    for name in ("lu", "qr", "sort", "cholesky", "while", "cond", "eigh", "svd", "random_bits"):
        assert not re.search(rf"= {name}\b", text), name
