"""Sampled posterior: its density, its limits, its sampler and its verdict."""

import importlib.util
import json
import re
from dataclasses import replace

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.text import measured
from gyrostat.core.units import RPM
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.uncertainty import posterior_sampler
from gyrostat.identification.uncertainty.posterior import Marginal, Posterior, judged
from gyrostat.identification.uncertainty.posterior_density import (
    coordinates,
    density,
    posed,
    record_data,
)
from gyrostat.identification.uncertainty.torque_noise import TorqueNoise
from gyrostat.reports.page import fit_page
from gyrostat.wheel.friction import Stribeck

NOISE = 5.0 * RPM
NAMES = ("motor_constant", "viscous", "coulomb", "static", "initial_speed")


@pytest.fixture(scope="module")
def problem(record):
    """Prediction of a record, all values, and the covariance in white noise."""
    prediction = SpeedPrediction([record(duration=30.0)], Stribeck, "zero-order")
    values = {
        "motor_constant": 0.0228,
        "inertia": 1.5e-3,
        "viscous": 4.83e-6,
        "coulomb": 0.8795e-3,
        "static": 0.9055e-3,
        "stribeck_speed": 0.418879,
        "current_bias": 0.0,
        "initial_speed": 0.5,
    }
    sigma = np.array([2e-4, 2e-6, 30e-6, 50e-6, 0.1])
    return prediction, values, np.diag(sigma**2)


def test_the_density_is_that_of_white_residuals(problem):
    prediction, values, covariance = problem
    data = posed(
        prediction, NAMES, values, covariance, Prior.unknown(5), [record_data(prediction, 0, NOISE)]
    )
    log_density = jax.jit(density(Stribeck, "zero-order", prediction.shared))
    u = jnp.array([0.3, -0.2, 0.1, 0.5, -0.1])
    x, determinant = data.coordinates.values(u)
    shifted = np.array(data.start)
    shifted[data.free] = x
    ((speed, _),) = prediction(shifted)
    residual = (prediction.records[0].speed - speed) / NOISE
    assert log_density(u, data) - determinant == pytest.approx(-0.5 * residual @ residual)


def test_random_torques_and_effects_enter_as_a_dense_covariance(problem):
    """Against the covariance matrix of the linear system, with one coefficient integrated out."""
    prediction, values, covariance = problem
    count = len(prediction.records[0].time)
    random = np.random.default_rng(0)
    transition, gain = random.uniform(0.9, 1.0, count - 1), random.uniform(50.0, 70.0, count - 1)
    walk, kept = np.full(count - 1, 1e-7), np.full(count - 1, 0.9)
    crossings, fixed = np.full(count - 1, 0.04), np.full(count - 1, 0.002)
    noise = TorqueNoise(gain, crossings, walk, 1e-6, -0.5 * gain, kept, 4e-6, fixed)
    column = random.standard_normal((count, 1))
    made = record_data(prediction, 0, NOISE, noise, (0.5, 2.0), transition, column)
    data = posed(prediction, NAMES, values, covariance, Prior.unknown(5), [made])
    # speed error by ripple, by steps of the torque and by the ripple at starts
    sources, torque, start = (np.zeros((count, 3 * count)) for _ in range(3))
    torque[0, count] = 2.0 * np.sqrt(noise.first)
    start[0, 2 * count] = 0.5 * np.sqrt(noise.ripple)
    for k in range(count - 1):
        sources[k + 1] = transition[k] * sources[k] + gain[k] * (torque[k] - 0.5 * start[k])
        sources[k + 1, k] = np.sqrt(0.25 * noise.crossings[k] + noise.fixed[k])
        torque[k + 1] = torque[k]
        torque[k + 1, count + 1 + k] = 2.0 * np.sqrt(noise.walk[k])
        start[k + 1] = 0.9 * start[k]
        start[k + 1, 2 * count + 1 + k] = 0.5 * np.sqrt(noise.ripple * (1.0 - 0.9**2))
    dense = NOISE**2 * np.eye(count) + sources @ sources.T + column @ column.T
    u = jnp.array([0.3, -0.2, 0.1, 0.5, -0.1])
    x, determinant = data.coordinates.values(u)
    shifted = np.array(data.start)
    shifted[data.free] = x
    ((speed, _),) = prediction(shifted)
    residual = prediction.records[0].speed - speed
    found = density(Stribeck, "zero-order", prediction.shared)(u, data) - determinant
    assert found == pytest.approx(-0.5 * residual @ np.linalg.solve(dense, residual), rel=1e-8)


def test_the_coordinates_reach_every_possible_wheel_and_no_other():
    values = np.array([0.0228, 1e-6, 0.9e-3, 0.85e-3])
    sigma = np.diag([2e-5, 2e-6, 30e-6, 80e-6])
    found = coordinates(Stribeck, NAMES[:4], values, sigma**2)
    drawn = 3.0 * np.random.default_rng(0).standard_normal((2000, 4))
    wheels, _ = jax.vmap(found.values)(jnp.asarray(drawn))
    assert np.all(wheels[:, 1] > 0.0)
    assert np.all(wheels[:, 3] > wheels[:, 2])
    # the determinant is that of the map
    u = jnp.array([0.2, -0.4, 0.3, -1.0])
    _, jacobian = np.linalg.slogdet(jax.jacfwd(lambda v: found.values(v)[0])(u))
    _, other = np.linalg.slogdet(jax.jacfwd(lambda v: found.values(v)[0])(-u))
    assert jacobian - other == pytest.approx(float(found.values(u)[1] - found.values(-u)[1]))


def test_without_the_sampler_one_line_says_so(record, monkeypatch):
    monkeypatch.setattr(posterior_sampler, "find_spec", lambda name: None)
    with pytest.raises(
        gs.InputError,
        match=r"found no blackjax, expected the packages of the extra posterior",
    ):
        gs.identify(record(), inertia=1.5e-3, posterior=True)


@pytest.fixture
def sampler():
    if importlib.util.find_spec("blackjax") is None:
        pytest.skip("blackjax, of the extra posterior, is not installed")


def gaussian(u, precision):
    """A correlated Gaussian."""
    return -0.5 * u @ precision @ u


def test_the_posterior_of_a_gaussian_is_that_gaussian(sampler):
    # far from the unit covariance of the start
    covariance = np.array([[0.01, 0.08], [0.08, 2.0]])
    drawn, accepted = posterior_sampler.sample(gaussian, jnp.asarray(np.linalg.inv(covariance)), 2)
    found = judged(drawn, ["a", "b"], [(1, 0)], accepted)
    assert found.valid
    assert 0.15 < found.accepted < 0.5
    many = min(m.effective for m in found.marginals)
    sigma = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        np.cov(drawn.reshape(-1, 2).T) / np.outer(sigma, sigma),
        covariance / np.outer(sigma, sigma),
        atol=5.0 * np.sqrt(2.0 / many),
    )
    expected = np.sqrt(covariance[0, 0] + covariance[1, 1] - 2.0 * covariance[0, 1])
    difference = found.marginals[2]
    assert difference.name == "b-a"
    assert difference.sigma == pytest.approx(expected, rel=0.1)
    assert difference.quantiles[-1] == pytest.approx(1.96 * expected, rel=0.15)


def test_chains_that_did_not_mix_are_no_valid_posterior(sampler):
    random = np.random.default_rng(0)
    apart = random.standard_normal((4, 200, 1)) + np.array([0.0, 0.0, 0.0, 3.0])[:, None, None]
    found = judged(apart, ["a"], [], 0.3)
    assert not found.valid
    assert "the chains differ in a" in found.faults[0]
    assert "effective draws" in found.faults[1]
    assert found.to_dict()["valid"] is False


def test_text_json_and_report_show_the_posterior_beside_the_gaussian(given):
    names = [*given.names, "static-coulomb"]
    random = np.random.default_rng(0)
    marginals = tuple(
        Marginal(n, 1.0, 0.1, np.linspace(0.8, 1.2, 5), 1.2, 50.0, random.standard_normal(200))
        for n in names
    )
    fault = "static has only 50 effective draws"
    fit = replace(given, posterior=Posterior(marginals, 4, 0.3, (), (fault,)))
    text = str(fit)
    assert f"no valid posterior: {fault}" in text
    assert "posterior: 200 draws in 4 chains" in text
    row = next(line for line in text.splitlines() if "static-coulomb" in line and " to " in line)
    assert "0.8 to 1.2" in row
    place = [fit.names.index(n) for n in ("static", "coulomb")]
    variance = np.array([1.0, -1.0]) @ fit.covariance[np.ix_(place, place)] @ np.array([1.0, -1.0])
    low = fit.parameters["static"] - fit.parameters["coulomb"] - 1.959964 * np.sqrt(variance)
    assert f"{low:.4g} to " in row
    content = json.loads(json.dumps(fit.to_dict(), allow_nan=False))["posterior"]
    assert content["valid"] is False
    assert content["parameters"]["coulomb"]["interval_95"] == [0.8, 1.2]
    assert content["parameters"]["coulomb"]["quantiles"]["0.5"] == 1.0
    page = fit_page(fit, command="test")
    assert "no valid posterior" in page
    assert "rad/s " not in page
    assert not re.search(r"\bN·m\b(?![·/])", page)
    value, sigma = fit.parameters["coulomb"], fit.sigma[fit.names.index("coulomb")]
    shown = measured(1e3 * value, 1e3 * sigma)
    assert f'{shown}</span> <span class="whole">mN·m' in page
    assert "<td>800 to 1200</td>" in page  # 0.8 to 1.2 N·m
    assert (
        page.count('<div class="charts')
        == fit_page(given, command="test").count('<div class="charts') + 1
    )
