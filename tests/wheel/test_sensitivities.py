"""Derivatives by automatic differentiation: through crossings, breakaway and rest."""

from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import DirectionalStribeck, Stribeck, ViscousCoulomb

ASYMMETRIC = {
    "viscous_positive": 4e-6,
    "viscous_negative": 6e-6,
    "coulomb_positive": 0.8e-3,
    "coulomb_negative": 0.95e-3,
    "static_positive": 1.1e-3,
    "static_negative": 1.2e-3,
    "stribeck_speed": 1.0,
}


SAMPLES = 3001


@partial(jax.jit, static_argnames=("friction", "hold"))
def speeds(values, time, current, friction=Stribeck, hold="zero-order"):
    """By inertia, motor constant, friction parameters and initial speed."""
    wheel = Wheel(values[0], values[1], friction(*values[2:-1]))
    return speed_response(wheel, time, current, values[-1], hold=hold)[0]


# Compiled once for each model and hold: every record here has as many samples.
sensitivities = jax.jit(jax.jacfwd(speeds), static_argnames=("friction", "hold"))


def central_differences(values, relative, record):
    """Fourth-order differences by each value, and where no crossing passes a sample meanwhile."""
    differences, smooth = [], []
    for k, value in enumerate(values):
        step = np.zeros(len(values))
        step[k] = relative * value
        moved = np.array([speeds(values + n * step, *record) for n in (-2, -1, 1, 2)])
        stencil = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * step[k])
        differences.append(stencil @ moved)
        smooth.append(np.all(np.sign(moved) == np.sign(moved[0]), axis=0))
    return np.array(differences).T, np.array(smooth).T


@pytest.mark.parametrize("hold", ["zero-order", "linear"])
@pytest.mark.parametrize("friction", [Stribeck, DirectionalStribeck])
def test_sensitivities_agree_with_central_differences_through_crossings(paper, friction, hold):
    """By every parameter and the initial speed; within 1e-6 of the largest."""
    own = paper[2:] if friction is Stribeck else tuple(ASYMMETRIC.values())
    values = np.array([*paper[:2], *own, 0.9])
    time = np.arange(SAMPLES) * 0.02
    if hold == "zero-order":
        current = np.array([-0.11, 0.14, -0.13, 0.12])[(time / 15.0 + 1e-9).astype(int) % 4]
    else:
        amplitude = 0.06 if friction is Stribeck else 0.085
        current = amplitude * np.sin(2.0 * np.pi * time / 17.0)
    record = (time, current, friction, hold)
    slopes = np.asarray(sensitivities(values, *record))
    trajectory = np.asarray(speeds(values, *record))
    if hold == "zero-order":
        assert np.sum(trajectory[1:] * trajectory[:-1] < 0.0) >= 4
    else:
        assert np.sum(trajectory == 0.0) > 20
    difference, smooth = central_differences(values, 3e-4, record)
    assert np.mean(smooth) > 0.99
    error = np.max(np.abs(difference - slopes) * smooth, axis=0) / np.max(np.abs(slopes), axis=0)
    assert np.all(error < 1e-7), error


def test_sensitivities_agree_with_the_variational_equations_and_the_saltation_factor(paper):
    """dS/dt = f_w S + f_p by scipy on either side of the crossing, S times f+/f- between."""
    inertia, motor, viscous, coulomb, static, scale = paper
    current, initial, end = -0.1, 3.0, 6.0

    def fields(speed, sense):
        """f, df/dw and df/dp for J, k_m, b, c, T_s, w_s and the initial speed."""
        decay = np.exp(-((speed / scale) ** 2))
        excess = (static - coulomb) * decay
        rate = (motor * current - viscous * speed - sense * (coulomb + excess)) / inertia
        by_speed = (-viscous + sense * excess * 2.0 * speed / scale**2) / inertia
        by_scale = -sense * excess * 2.0 * speed**2 / scale**3
        others = [current, -speed, -sense * (1.0 - decay), -sense * decay, by_scale, 0.0]
        return rate, by_speed, np.array([-rate, *others]) / inertia

    def solve(start, stop, state, sense):
        def system(_, y):
            rate, by_speed, by_value = fields(y[0], sense)
            return [rate, *(by_speed * y[1:] + by_value)]

        def zero(_, y):
            return y[0]

        zero.terminal, zero.direction = True, -sense
        options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.01}
        return solve_ivp(system, (start, stop), state, events=zero, **options)

    before = solve(0.0, end, [initial, *np.zeros(6), 1.0], 1.0)
    assert before.status == 1
    factor = fields(0.0, -1.0)[0] / fields(0.0, 1.0)[0]
    after = solve(before.t[-1], end, [0.0, *(factor * before.y[1:, -1])], -1.0)
    assert 0.1 < factor < 0.9
    time, currents = np.linspace(0.0, end, SAMPLES), np.full(SAMPLES, current)
    slopes = sensitivities(np.array([*paper, initial]), time, currents)[-1]
    np.testing.assert_allclose(slopes, after.y[1:, -1], rtol=1e-7)


@jax.jit
def end_of_a_coulomb_wheel(values):
    """Speed after the last of 33 samples: by inertia, k_m, c, current, initial speed and step."""
    inertia, motor, coulomb, current, initial, step = values
    wheel = Wheel(inertia, motor, ViscousCoulomb(0.0, coulomb))
    return speed_response(wheel, step * jnp.arange(33), jnp.full(33, current), initial)[0]


slopes_of_a_coulomb_wheel = jax.jit(jax.jacfwd(end_of_a_coulomb_wheel))


def exact_slopes(inertia, motor, coulomb, current, initial, step):
    """Of w(t) = f+ (t - t0) with f± = (k_m I ± c) / J and t0 = -w0 / f-."""
    after, before = (motor * current + coulomb) / inertia, (motor * current - coulomb) / inertia
    left = 32.0 * step + initial / before
    jump = initial * after / before**2

    def total(of_after, of_before):
        return of_after * left - jump * of_before

    return [
        total(-after / inertia, -before / inertia),
        total(current / inertia, current / inertia),
        total(1.0 / inertia, -1.0 / inertia),
        total(motor / inertia, motor / inertia),
        after / before,
        32.0 * after,
    ]


@pytest.mark.parametrize("step", [0.01, 0.137, 0.5])
def test_a_sensitivity_jumps_at_a_crossing_by_the_ratio_of_the_accelerations(step):
    values = [0.7, 1.3, 0.4, -1.1, 13.7 * step * (1.3 * 1.1 + 0.4) / 0.7, step]
    expected = exact_slopes(*values)
    slopes = np.asarray(slopes_of_a_coulomb_wheel(np.array(values)))
    np.testing.assert_allclose(slopes[-1], expected, rtol=1e-12)


def test_a_crossing_that_falls_on_a_sample_keeps_its_sensitivities():
    """With numbers of few bits the speed at a sample is exactly zero, as in any round example."""
    random = np.random.default_rng(0)
    exactly_at_a_sample = 0
    for _ in range(200):
        step, at = random.integers(1, 40) / 64.0, int(random.integers(1, 20))
        current = -random.integers(5, 80) / 4.0
        values = [1.0, 1.0, 1.0, current, (1.0 - current) * step * at, step]
        speeds_there = np.asarray(end_of_a_coulomb_wheel(np.array(values)))
        exactly_at_a_sample += speeds_there[at] == 0.0
        slopes = np.asarray(slopes_of_a_coulomb_wheel(np.array(values)))[-1]
        np.testing.assert_allclose(slopes, exact_slopes(*values), rtol=1e-9)
    assert exactly_at_a_sample > 20


def test_a_breakaway_on_a_ramp_passes_its_derivative_on():
    """w = k s (t - t_b)² / 2J with t_b = T_s / (k s), T_s = c."""
    time = np.linspace(0.0, 4.0, 9)

    def end(values):
        inertia, motor, coulomb, slope = values
        wheel = Wheel(inertia, motor, ViscousCoulomb(0.0, coulomb))
        return speed_response(wheel, time, slope * time, 0.0, hold="linear")[0][-1]

    inertia, motor, coulomb, slope = 0.7, 1.3, 1.9, 0.9
    since = 4.0 - coulomb / (motor * slope)
    climb = motor * slope
    expected = [
        -0.5 * climb * since**2 / inertia**2,
        slope * (0.5 * since**2 + since * coulomb / climb) / inertia,
        -since / inertia,
        motor * (0.5 * since**2 + since * coulomb / climb) / inertia,
    ]
    slopes = jax.jit(jax.jacfwd(end))(np.array([inertia, motor, coulomb, slope]))
    np.testing.assert_allclose(slopes, expected, rtol=1e-12)


def test_sticking_forgets_everything_that_was_before(paper):
    """At rest all sensitivities are exactly zero; after the next breakaway w0 has no effect."""
    time = np.arange(SAMPLES) * 0.02
    current = np.where(time < 20.0, 0.0, 0.05)
    values = np.array([*paper, 2.0])
    slopes = np.asarray(sensitivities(values, time, current))
    trajectory = np.asarray(speeds(values, time, current))
    rest = trajectory == 0.0
    assert np.sum(rest) > 500
    assert np.all(slopes[rest] == 0.0)
    moving_again = time > 20.0
    assert np.all(trajectory[moving_again] > 0.0)
    assert np.all(slopes[moving_again, -1] == 0.0)
    assert np.all(slopes[moving_again, :2] != 0.0)


def test_branches_not_taken_leak_nothing_into_the_sensitivities_of_a_batch(paper):
    """Under vmap both branches of every choice are computed; resting and turning wheels mix."""
    time = np.arange(SAMPLES) * 0.01
    record = (time, 0.09 * np.sin(time), Stribeck, "linear")
    initial = np.array([0.0, 0.0, 1e-300, 1e-9, -1e-3, 0.3, -2.0, 50.0])
    motor = paper[1] * np.array([0.0, 1.0, 1.0, 0.2, 1.0, 1.0, -1.0, 3.0])
    lanes = np.array([[paper[0], m, *paper[2:], w] for m, w in zip(motor, initial, strict=True)])
    together = jax.jit(jax.vmap(lambda values: jax.jacfwd(speeds)(values, *record)))(lanes)
    assert np.all(np.isfinite(together))
    largest = np.max(np.abs(together), axis=(0, 1))
    for lane, slopes in zip(lanes, together, strict=True):
        single = sensitivities(lane, *record)
        np.testing.assert_allclose(slopes / largest, single / largest, rtol=0.0, atol=1e-11)
