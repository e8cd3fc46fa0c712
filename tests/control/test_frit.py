"""On-line FRIT: least squares against a batch solution, and gains that are known beforehand."""

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import FirstOrderLags, LeastSquares, OnlineFrit, recursive_least_squares
from gyrostat.control.adaptive.frit import regression
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

PERIOD, F = 0.1, np.array([0.5, 0.5])
SAMPLED = -np.log(1.0 - F * PERIOD) / PERIOD
"""Rate of a lag whose sampled pole is 1 - F Ts: the closed loop of integrators."""


def tuner(**changes):
    fields = {
        "feedback": jnp.asarray(F),
        "reference": FirstOrderLags(jnp.asarray(SAMPLED)),
        "forgetting": 0.99,
        "smoothing": 1.0,
        "dead_zone": jnp.zeros(2),
        "initial_gain": jnp.zeros((2, 2)),
        "filters_from_output": True,
    }
    return OnlineFrit(**{**fields, **changes})


def test_recursion_gives_the_weighted_batch_solution():
    random = np.random.default_rng(1)
    count, forgetting, first = 60, 0.93, np.array([0.3, -1.0, 2.0])
    x, y = random.standard_normal((count, 3)), random.standard_normal(count)
    root = random.standard_normal((3, 3))
    prior = root @ root.T + np.eye(3)

    def step(state, sample):
        return recursive_least_squares(state, *sample, forgetting), None

    start = LeastSquares(jnp.asarray(first), jnp.asarray(prior))
    found, _ = jax.lax.scan(step, start, (jnp.asarray(x), jnp.asarray(y)))
    weights = forgetting ** (count - 1.0 - np.arange(count))
    information = forgetting**count * np.linalg.inv(prior) + (x.T * weights) @ x
    right = forgetting**count * np.linalg.inv(prior) @ first + (x.T * weights) @ y
    np.testing.assert_allclose(found.estimate, np.linalg.solve(information, right), rtol=1e-10)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(information), rtol=1e-9)


@eqx.filter_jit
def fed(frit, output, error, input):
    def step(memory, sample):
        y, e, u = sample
        xi_eta = regression(frit, memory, y)
        memory = frit(memory, error=e, input=u, output=y, period=PERIOD)
        return memory, (memory.gain, memory.rows.estimate, xi_eta)

    signals = tuple(jnp.asarray(one) for one in (output, error, input))
    return jax.lax.scan(step, frit.start(signals[0][0]), signals)[1]


def recorded(disturbance, count=400):
    """Integrators with any input and a disturbance of it: outputs, errors, inputs."""
    random = np.random.default_rng(2)
    error, input = random.standard_normal((2, count, 2))
    output = np.zeros((count, 2))
    output[0] = 3.0, -2.0
    for k in range(count - 1):
        output[k + 1] = output[k] + PERIOD * (input[k] + disturbance(error[k], k))
    return output, error, input


def test_a_gain_that_answers_the_disturbance_exactly_is_found():
    wanted = np.array([[0.7, -0.2], [0.1, 1.3]])
    # so little prior information that it is forgotten
    frit = tuner(initial_covariance=1e8)
    gain, estimate, _ = fed(frit, *recorded(lambda error, _: -wanted @ error))
    np.testing.assert_allclose(estimate[-1], wanted, atol=1e-6)
    np.testing.assert_allclose(gain[-1], estimate[-1], atol=0.0)


def test_eta_is_the_disturbance_through_the_reference_model():
    def disturbance(_, k):
        return np.array([np.sin(0.05 * k), 0.3])

    signals = recorded(disturbance)
    _, _, (_, eta) = fed(tuner(), *signals)
    seen = np.zeros(2)
    for k in range(len(eta)):
        np.testing.assert_allclose(eta[k], -seen, atol=1e-12)
        seen = (1.0 - F * PERIOD) * seen + F * PERIOD * disturbance(None, k)
    _, _, (_, from_zero) = fed(tuner(filters_from_output=False), *signals)
    lag = (1.0 - F[0] * PERIOD) ** np.arange(len(eta))
    np.testing.assert_allclose(from_zero - eta, -F * np.outer(lag, signals[0][0]), atol=1e-12)


def test_low_pass_and_dead_zone_are_those_of_the_paper():
    signals = recorded(lambda error, _: -error)
    gain, estimate, _ = fed(tuner(smoothing=0.2, dead_zone=jnp.array([0.8, 1e9])), *signals)
    heeded = np.abs(signals[1][:, 0]) >= 0.8
    assert 100 < np.sum(heeded) < 300
    k = np.zeros(2)
    for i in range(len(gain)):
        k = 0.8 * k + 0.2 * np.asarray(estimate[i, 0]) if heeded[i] else k
        np.testing.assert_allclose(gain[i, 0], k, atol=1e-13)
        if i and not heeded[i]:
            np.testing.assert_array_equal(estimate[i, 0], estimate[i - 1, 0])
    np.testing.assert_array_equal(gain[:, 1], 0.0)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"forgetting": 0.0}, r"FRIT forgetting: found 0, expected in \(0, 1\]"),
        ({"forgetting": 1.01}, "FRIT forgetting"),
        ({"smoothing": np.nan}, "FRIT smoothing"),
        ({"smoothing": -0.1}, "FRIT smoothing"),
        ({"initial_covariance": 0.0}, "FRIT initial covariance"),
        ({"dead_zone": np.array([-1.0, 0.0])}, "FRIT dead zone"),
        ({"initial_gain": np.zeros((2, 3))}, "FRIT initial gain"),
        ({"feedback": np.array([np.inf, 1.0])}, "FRIT feedback"),
        ({"reference": FirstOrderLags(np.array([0.0, 1.0]))}, "lag rate"),
    ],
)
def test_what_is_no_tuning_is_refused(changed, words):
    tuner().check()
    with pytest.raises(InputError, match=words):
        tuner(**changed).check()
