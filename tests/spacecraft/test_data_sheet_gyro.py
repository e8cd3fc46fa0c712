"""Gyro of a data sheet: low-pass filter, flicker noise, resolution, axes."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.identification.gyro.allan_deviation import allan_deviations
from gyrostat.spacecraft import DataSheetGyro, RateGyro
from gyrostat.spacecraft.data_sheet_gyro import GyroMemory
from gyrostat.spacecraft.rate_gyro import BodyMotion

STILL = BodyMotion(jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.zeros(3))


@jax.jit
def step(gyro, before, now, memory, period, key):
    return gyro(before, now, memory, period, key)


@jax.jit
def at_rest(gyro, period, keys):
    """Samples of a body at rest, (samples, 3)."""

    def one(memory, key):
        rate, memory = gyro(STILL, STILL, memory, period, key)
        return memory, rate

    return jax.lax.scan(one, gyro.start(STILL), keys)[1]


def about_z(angle, rate):
    attitude = Rotation.from_rotvec([0.0, 0.0, angle]).as_quat(scalar_first=True)
    return BodyMotion(jnp.asarray(attitude), jnp.array([0.0, 0.0, rate]))


def run(gyro, motions, period):
    memory, rates = gyro.start(motions[0]), []
    for before, now in pairwise(motions):
        rate, memory = step(gyro, before, now, memory, period, jax.random.key(0))
        rates.append(np.asarray(rate))
    return np.array(rates)


@pytest.mark.parametrize(("bandwidth", "largest"), [(0.4, 4e-4), (5.0, 4e-4), (np.inf, 1e-9)])
def test_low_pass_filter_is_that_of_its_equation(bandwidth, largest):
    """Against the integral of y' = (w - y) / T at a rate of sin 2 t, as a share of the rate."""
    period, time = 0.1, 0.1 * np.arange(41)
    motions = [about_z(0.05 * (1.0 - np.cos(2.0 * t)), 0.1 * np.sin(2.0 * t)) for t in time]
    rates = run(DataSheetGyro(RateGyro(), bandwidth=jnp.asarray(bandwidth)), motions, period)[:, 2]
    if np.isinf(bandwidth):
        expected = np.diff([0.05 * (1.0 - np.cos(2.0 * t)) for t in time]) / period
    else:
        lag = 1.0 / (2.0 * np.pi * bandwidth)
        solved = solve_ivp(
            lambda t, y: [(0.1 * np.sin(2.0 * t) - y[0]) / lag, y[0]],
            (0.0, 4.0),
            [0.0, 0.0],
            t_eval=time,
            rtol=1e-10,
            atol=1e-13,
        )
        expected = np.diff(solved.y[1]) / period
    np.testing.assert_allclose(rates, expected, atol=0.1 * largest)


def test_flicker_noise_has_the_flat_allan_deviation_of_its_bias_instability():
    """4 x 3 axes of 60 000 samples: within 2 % of 0.664 B, and the scatter of the estimate."""
    sizes = np.array([10, 100, 1000])
    gyro = DataSheetGyro(RateGyro(), bias_instability=2.0)
    keys = jax.random.split(jax.random.key(0), (4, 60_000))
    rates = np.asarray(jax.vmap(at_rest, (None, None, 0))(gyro, 0.5, keys))
    axes = np.moveaxis(rates, 1, -1).reshape(12, -1)
    variances = [allan_deviations(axis, sizes) ** 2 for axis in axes]
    flat = 2.0 * np.sqrt(2.0 * np.log(2.0) / np.pi)
    np.testing.assert_allclose(np.sqrt(np.mean(variances, axis=0)), flat, rtol=0.06)


def test_sum_of_processes_is_within_two_per_cent_of_flicker_noise():
    """Allan variance of Gauss-Markov processes, IEEE Std 952-1997, annex C."""
    lags, ratio = 0.5 * 10.0 ** np.arange(7), np.geomspace(10.0, 1e5, 100)[:, None]
    each = 2.0 * lags / ratio
    share = lags / (2.0 * ratio)
    each *= 1.0 - share * (3.0 - 4.0 * np.exp(-ratio / lags) + np.exp(-2.0 * ratio / lags))
    variance = np.log(10.0) / np.pi * each.sum(axis=1)
    deviation = np.sqrt(variance / (2.0 * np.log(2.0) / np.pi))
    assert np.max(np.abs(deviation - 1.0)) < 0.02


def test_angle_resolution_loses_no_angle_and_has_the_quantisation_of_its_step():
    step_size, period = 1e-5, 0.2
    gyro = DataSheetGyro(RateGyro(1e-4), angle_resolution=step_size)
    keys = jax.random.split(jax.random.key(1), 4000)
    coarse = np.asarray(at_rest(gyro, period, keys))
    fine = np.asarray(at_rest(DataSheetGyro(RateGyro(1e-4)), period, keys))
    turns = period * coarse / step_size
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    gap = period * (np.cumsum(coarse, axis=0) - np.cumsum(fine, axis=0))
    assert np.max(np.abs(gap)) <= 0.5 * step_size * (1.0 + 1e-6)
    assert np.std(gap) == pytest.approx(step_size / np.sqrt(12.0), rel=0.03)


def test_rate_resolution_rounds_the_rate():
    gyro = DataSheetGyro(RateGyro(1e-3), rate_resolution=2e-4)
    rates = np.asarray(at_rest(gyro, 0.5, jax.random.split(jax.random.key(2), 50))) / 2e-4
    np.testing.assert_allclose(rates, np.round(rates), atol=1e-9)
    assert np.ptp(rates) > 3.0


def test_axes_that_are_not_at_right_angles_mix_the_rates():
    rate, period = np.array([0.03, -0.02, 0.05]), 0.25
    turned = Rotation.from_rotvec(period * rate).as_quat(scalar_first=True)
    before = BodyMotion(STILL.attitude, jnp.asarray(rate))
    now = BodyMotion(jnp.asarray(turned), jnp.asarray(rate))
    gyro = DataSheetGyro(
        RateGyro(scale_factor=[1e-3, 0.0, 0.0]), nonorthogonality=[1e-3, 2e-3, 3e-3]
    )
    found = step(gyro, before, now, gyro.start(before), period, jax.random.key(0))[0]
    expected = rate * [1.001, 1.0, 1.0]
    expected[1] += 1e-3 * rate[0]
    expected[2] += 2e-3 * rate[0] + 3e-3 * rate[1]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_without_errors_of_its_own_it_is_the_rate_gyro():
    inner = RateGyro(1e-4, 1e-6, [1e-5, 0.0, 2e-5], [1e-3, 0.0, 0.0], [0.01, 0.0, 0.02], 0.04)
    gyro, key = DataSheetGyro(inner), jax.random.key(3)
    before, now = about_z(0.0, 0.05), about_z(0.0126, 0.052)
    rate, memory = step(gyro, before, now, gyro.start(before), 0.25, key)
    plain, bias = step(inner, before, now, inner.start(before), 0.25, key)
    np.testing.assert_allclose(rate, plain, rtol=1e-14)
    np.testing.assert_array_equal(memory.bias, bias)
    assert isinstance(memory, GyroMemory)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"bias_instability": -1.0}, "bias instability"),
        ({"bandwidth": 0.0}, "bandwidth"),
        ({"nonorthogonality": [np.nan, 0.0, 0.0]}, "nonorthogonality"),
        ({"angle_resolution": -1e-6}, "angle resolution"),
        ({"rate_resolution": np.inf}, "rate resolution"),
    ],
)
def test_wrong_numbers_are_refused(values, message):
    with pytest.raises(InputError, match=message):
        DataSheetGyro(RateGyro(), **values).check()
