"""The filters against python-control, and against an extended filter built on scipy's solver."""

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionScaleFilter, FrictionTorqueFilter
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

OBSERVE = np.array([[1.0, 0.0]])


def transition(period):
    """Eq. (12) of Moreira, Lopes and Kuga."""
    return np.array([[1.0, -period], [0.0, 1.0]])


def spread(drift, period):
    """Eq. (13)."""
    return drift**2 * np.array(
        [[period**3 / 3.0, -(period**2) / 2.0], [-(period**2) / 2.0, period]]
    )


@pytest.mark.parametrize(
    ("rho", "drift", "period"),
    [(0.01, 0.1, 1.0), (0.01, 1e-3, 10.0), (1e-6, 1e3, 1.0), (0.01, 1e-5, 0.01), (1.0, 1.0, 1e3)],
)
def test_the_steady_gain_is_that_of_python_control(rho, drift, period):
    gain = FrictionTorqueFilter(rho, drift, 1.0).steady_gain(period)
    carried, _, _ = control.dlqe(
        transition(period), np.eye(2), OBSERVE, spread(drift, period), [[rho**2]]
    )
    # theirs is the gain of the prediction
    np.testing.assert_allclose(transition(period) @ gain, carried[:, 0], rtol=1e-6)


def test_the_steady_gain_keeps_its_digits_where_the_riccati_equation_is_hard_to_solve():
    """For a slow walk the gain of h tends to sqrt(2 l), that of N to -l / T, l² = q T³ / r."""
    rho, drift, period = 10.0, 1e-9, 0.1
    small = drift * period**1.5 / rho
    gain = FrictionTorqueFilter(rho, drift, 1.0).steady_gain(period)
    np.testing.assert_allclose(gain, [np.sqrt(2.0 * small), -small / period], rtol=3e-6)


@pytest.mark.parametrize("period", [0.0, -1.0, np.nan])
def test_a_period_that_does_not_go_forward_is_refused(period):
    with pytest.raises(InputError, match="period: found"):
        FrictionTorqueFilter(0.01, 0.1, 0.1).steady_gain(period)


def test_a_whole_run_is_that_of_python_control():
    """Predicted means and covariances on the paper's model, with a known torque."""
    rho, drift, first, period, count = 0.01, 0.1, 0.1, 1.0, 120
    random = np.random.default_rng(4)
    impulses = 0.02 + 0.01 * random.standard_normal(count)
    measured = np.cumsum(impulses - 0.01) + rho * random.standard_normal(count)
    own = FrictionTorqueFilter(rho, drift, first)

    @jax.jit
    def filtered(measured, impulses):
        def tick(estimate, now):
            corrected = own.correct(estimate, now[0])
            return own.predict(corrected, now[1], period), (estimate, corrected)

        return jax.lax.scan(tick, own.start(), (measured, impulses))[1]

    before, after = filtered(measured, impulses)
    wheel = control.ss(
        transition(period), [[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], OBSERVE, np.zeros((1, 3)), period
    )
    estimator = control.create_estimator_iosystem(
        wheel,
        spread(drift, period),
        np.array([[rho**2]]),
        first**2 * np.eye(2),
        control_indices=[0],
        disturbance_indices=[1, 2],
    )
    found = control.input_output_response(
        estimator,
        period * np.arange(count),
        np.vstack([measured, impulses]),
        np.concatenate([np.zeros(2), (first**2 * np.eye(2)).ravel()]),
    )
    momentum, friction, own_variance, both, _, other = found.states
    for ours, theirs in (
        (before.momentum, momentum),
        (before.friction, friction),
        (before.walk.momentum_variance, own_variance),
        (-before.walk.covariance, both),
        (before.walk.torque_variance, other),
        (after.innovation, measured - momentum),
        (after.innovation_variance, own_variance + rho**2),
    ):
        np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.max(np.abs(theirs)))


B, C, TS, WS, J, KM = 4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879, 1.5e-3, 0.0228
SIGMA, DRIFT, SHAKE, PERIOD = 0.3, 3e-3, 2e-5, 0.5


def carried_by_scipy(speed, scale, current):
    """Speed and its derivatives by speed and scale after a period, variations and all.

    At a crossing the variations jump by the acceleration after over that before.
    """

    def acceleration(speed, sense):
        level = C + (TS - C) * np.exp(-((speed / WS) ** 2))
        return (KM * current - scale * (B * speed + sense * level)) / J

    def rate(_, y, sense):
        w = y[0]
        bend = -2.0 * w / WS**2 * (TS - C) * np.exp(-((w / WS) ** 2))
        slope = -scale * (B + sense * bend) / J
        by_scale = (acceleration(w, sense) - KM * current / J) / scale
        return [acceleration(w, sense), slope * y[1], slope * y[2] + by_scale]

    def zero(_, y, sense):
        return y[0]

    zero.terminal = True
    options = {"rtol": 1e-11, "atol": 1e-13, "max_step": 0.01}
    y, time, sense = np.array([speed, 1.0, 0.0]), 0.0, np.sign(speed)
    while time < PERIOD:
        zero.direction = -sense
        piece = solve_ivp(rate, (time, PERIOD), y, args=(sense,), events=zero, **options)
        time, y = piece.t[-1], piece.y[:, -1]
        if piece.status == 1:
            assert abs(KM * current) > scale * TS  # it crosses: the tests do not let it stick
            jump = acceleration(0.0, -sense) / acceleration(0.0, sense)
            y, sense = np.array([0.0, jump * y[1], jump * y[2]]), -sense
    return y


def test_the_extended_filter_is_the_textbook_one():
    """Spin-up, reversal through zero and back; the model carried and linearised by scipy."""
    currents = np.repeat([0.09, -0.09, 0.07], (12, 25, 30))
    true = [4.0]
    for current in currents[:-1]:
        true.append(carried_by_scipy(true[-1], 1.2, current)[0])
    measured = true + SIGMA * np.random.default_rng(6).standard_normal(len(true))
    measured[[5, 30]] = np.nan
    own = FrictionScaleFilter(Wheel(J, KM, Stribeck(B, C, TS, WS)), SIGMA, DRIFT, SHAKE)

    @jax.jit
    def filtered(measured, currents):
        def tick(estimate, now):
            corrected = own.correct(estimate, now[0])
            return own.predict(corrected, now[1], PERIOD), corrected

        return jax.lax.scan(tick, own.start(3.0, 2.0), (measured, currents))[1]

    found = filtered(jnp.asarray(measured), jnp.asarray(currents))
    x, p = np.array([3.0, 1.0]), np.diag([4.0, 0.09])
    noise = np.diag([(SHAKE / J) ** 2 * PERIOD, DRIFT**2 * PERIOD])
    crossings = 0
    for k, (y, current) in enumerate(zip(measured, currents, strict=True)):
        if np.isfinite(y):
            gain = p @ OBSERVE.T / (OBSERVE @ p @ OBSERVE.T + SIGMA**2)
            x = x + gain[:, 0] * (y - x[0])
            p = (np.eye(2) - gain @ OBSERVE) @ p
        # a crossing is carried in steps of a few tenths of the Stribeck speed: that leaves 5e-7 in
        # the speed and 1e-5 of its derivatives, and goes away with shorter ones
        np.testing.assert_allclose(found.state[k], x, rtol=1e-6, atol=1e-6)
        sigma = np.sqrt(np.diag(p))
        assert np.max(np.abs(found.covariance[k] - p) / np.outer(sigma, sigma)) < 3e-5
        after, by_speed, by_scale = carried_by_scipy(*x, current)
        crossings += after * x[0] < 0.0
        step = np.array([[by_speed, by_scale], [0.0, 1.0]])
        x, p = np.array([after, x[1]]), step @ p @ step.T + noise
    assert crossings >= 2
    assert float(found.missed[-1]) == 2.0
    assert float(found.unresolved[-1]) == 0.0
