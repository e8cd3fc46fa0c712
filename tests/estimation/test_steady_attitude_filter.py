"""The filter of star tracker and gyro, against its own pole placement and its noise."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import SteadyAttitudeFilter

PERIOD, BANDWIDTH = 0.1, 0.05


def rotation(quaternion):
    return Rotation.from_quat(np.asarray(quaternion), scalar_first=True)


@pytest.fixture(scope="module")
def run():
    filter = SteadyAttitudeFilter(BANDWIDTH)

    def step(estimate, sample):
        estimate = filter(estimate, *sample, PERIOD)
        return estimate, estimate

    return jax.jit(lambda *samples: jax.lax.scan(step, filter.start(), samples)[1])


def turning(count, rate):
    """A body at a steady rate, rad/s."""
    turns = Rotation.from_rotvec(np.outer(PERIOD * np.arange(count), rate))
    quaternions = (Rotation.from_rotvec([0.3, -1.0, 2.0]) * turns).as_quat(scalar_first=True)
    return jnp.asarray(quaternions), jnp.tile(jnp.asarray(rate), (count, 1))


def test_bias_is_learnt_with_both_poles_at_the_bandwidth(run):
    bias = np.array([2e-5, -1e-5, 3e-5])
    attitude, rate = turning(3000, np.array([1e-4, -2e-4, 5e-5]))
    found = run(attitude, rate + bias)
    time = PERIOD * np.arange(len(attitude))
    # e'' + 2 w e' + w^2 e = 0 from e = 0, e' = bias error
    shape = 1.0 - (1.0 + BANDWIDTH * time) * np.exp(-BANDWIDTH * time)
    assert np.allclose(found.bias, np.outer(shape, bias), atol=0.01 * np.max(bias))
    assert np.allclose(found.bias[-1], bias, rtol=1e-4)
    miss = (rotation(attitude).inv() * rotation(found.attitude)).as_rotvec()
    expected = np.outer(time * np.exp(-BANDWIDTH * time), bias)
    assert np.allclose(miss, expected, atol=0.02 * np.max(expected))
    assert np.max(np.abs(miss[-1])) < 1e-8


def test_noise_of_the_tracker_is_cut_as_a_second_order_filter_does(run):
    sigma, count = 5e-5, 40_000
    attitude, rate = turning(count, np.zeros(3))
    random = np.random.default_rng(0)
    seen = rotation(attitude) * Rotation.from_rotvec(random.normal(0.0, sigma, (count, 3)))
    found = run(jnp.asarray(seen.as_quat(scalar_first=True)), rate)
    miss = (rotation(attitude).inv() * rotation(found.attitude)).as_rotvec()[2000:]
    # white noise through (2 w s + w^2)/(s + w)^2: variance sigma^2 T 5 w / 4
    expected = sigma * np.sqrt(1.25 * BANDWIDTH * PERIOD)
    assert np.sqrt(np.mean(miss**2)) == pytest.approx(expected, rel=0.15)


def test_sign_of_a_quaternion_is_of_no_account(run):
    attitude, rate = turning(50, np.array([0.1, 0.0, 0.0]))
    signs = jnp.where(jnp.arange(50)[:, None] % 2 == 0, 1.0, -1.0)
    found, same = run(attitude * signs, rate), run(attitude, rate)
    between = (rotation(found.attitude).inv() * rotation(same.attitude)).magnitude()
    assert np.max(between) < 1e-7


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, np.nan, np.inf])
def test_bad_bandwidths_are_refused(bandwidth):
    with pytest.raises(InputError, match="attitude filter bandwidth"):
        SteadyAttitudeFilter(bandwidth).check()
