"""The filter without a friction model against the paper's matrices, and what it does with gaps."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.estimation import FrictionTorqueFilter

RHO, RHO_1, RHO_0, PERIOD = 0.01, 0.1, 0.1, 1.0
FILTER = FrictionTorqueFilter(RHO, RHO_1, RHO_0)


@jax.jit
def filtered(measured, impulses):
    def tick(estimate, now):
        measurement, impulse = now
        corrected = FILTER.correct(estimate, measurement)
        return FILTER.predict(corrected, impulse, PERIOD), corrected

    return jax.lax.scan(tick, FILTER.start(), (measured, impulses))[1]


def textbook(measured, impulses):
    """Eqs. (11)-(14), (17) of the paper with matrices."""
    transition = np.array([[1.0, -PERIOD], [0.0, 1.0]])
    spread = RHO_1**2 * np.array(
        [[PERIOD**3 / 3.0, -(PERIOD**2) / 2.0], [-(PERIOD**2) / 2.0, PERIOD]]
    )
    x, p, states, gains = np.zeros(2), RHO_0**2 * np.eye(2), [], []
    for y, impulse in zip(measured, impulses, strict=True):
        gain = p[:, 0] / (p[0, 0] + RHO**2)
        x = x + gain * (y - x[0])
        p = (np.eye(2) - np.outer(gain, [1.0, 0.0])) @ p
        states.append(x)
        gains.append(gain)
        x = transition @ x + [impulse, 0.0]
        p = transition @ p @ transition.T + spread
    return np.array(states), gains[-1]


def test_equals_the_equations_of_the_paper():
    random = np.random.default_rng(1)
    measured, impulses = random.standard_normal((2, 200))
    found = filtered(measured, impulses)
    states, gain = textbook(measured, impulses)
    np.testing.assert_allclose(found.momentum, states[:, 0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.friction, states[:, 1], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(FILTER.steady_gain(PERIOD), gain, rtol=1e-9)


def test_a_missing_measurement_is_counted_and_left_out():
    measured = np.ones(50)
    measured[[10, 20, 21]] = np.nan
    found = filtered(measured, np.zeros(50))
    assert float(found.missed[-1]) == 3.0
    assert np.all(np.isfinite(found.momentum))
    # uncertainty grows over the gap, and the next measurement takes it away again
    variance = np.asarray(found.walk.momentum_variance)
    assert variance[21] > variance[20] > variance[19]
    assert variance[30] == pytest.approx(variance[19], rel=1e-6)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan])
def test_what_is_no_covariance_is_refused(bad):
    with pytest.raises(InputError, match="torque_drift: found"):
        FrictionTorqueFilter(RHO, bad, RHO_0).check()


def test_whole_numbers_start_it_too():
    start = FILTER.start(momentum=1, friction=0)
    end = jax.lax.scan(lambda x, _: (FILTER.predict(x, 0.5, 1.0), None), start, None, length=2)[0]
    assert float(end.momentum) == 2.0
