"""The observer of a body's rate: its poles, and the torque that it finds."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import RateEstimate, RateObserver

INERTIA = 0.495


@jax.jit
@jax.jacfwd
def derivative_of_error(values, bandwidth, period):
    own = RateObserver(INERTIA, bandwidth)
    estimate = own.correct(RateEstimate(*values), 0.0, period)
    return jnp.stack(own.predict(estimate, 0.0, period))


@pytest.mark.parametrize(("bandwidth", "period"), [(3.0, 0.1), (0.2, 0.05), (9.0, 0.5)])
def test_both_poles_are_those_of_the_bandwidth(bandwidth, period):
    """Characteristic polynomial of the error from sample to sample: (z - exp(-w T))²."""
    matrix = np.asarray(derivative_of_error(np.array([0.3, 0.7]), bandwidth, period))
    pole = np.exp(-bandwidth * period)
    assert np.trace(matrix) == pytest.approx(2.0 * pole, rel=1e-12)
    assert np.linalg.det(matrix) == pytest.approx(pole**2, rel=1e-12)


def test_finds_what_the_known_torque_leaves_out_and_nothing_else():
    own, period, missed = RateObserver(INERTIA, 3.0), 0.1, -7e-4
    estimate, rate = own.start(), 0.0
    random = np.random.default_rng(0)
    for _ in range(120):
        estimate = own.correct(estimate, rate, period)
        known = 1e-3 * random.standard_normal()
        rate += (known + missed) / INERTIA * period
        estimate = own.predict(estimate, known, period)
    assert float(estimate.torque) == pytest.approx(missed, rel=1e-9)
    assert float(estimate.rate) == pytest.approx(rate, rel=1e-9)
