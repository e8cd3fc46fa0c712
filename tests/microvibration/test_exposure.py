"""Weights of an exposure and MTF against motions that are sampled in time."""

import numpy as np
import pytest

from gyrostat.microvibration.exposure import (
    drift_weight,
    gaussian_mtf,
    jitter_weight,
    mtf,
    relative_weight,
    shift_weight,
    sinusoid_mtf,
    smear_mtf,
    smear_weight,
)

EXPOSURE = 0.2
TIME = (np.arange(4000) + 0.5) / 4000.0 * EXPOSURE


def sampled(frequency, start):
    return np.sqrt(2.0) * np.cos(frequency * (TIME + start[:, None]))


@pytest.mark.parametrize("frequency", [0.1, 1.0, 7.0, 30.0, 31.4, 200.0])
def test_weights_are_the_mean_squares_of_sampled_exposures(frequency):
    start = np.arange(720) / 720.0 * 2.0 * np.pi / frequency
    motion = sampled(frequency, start)
    mean = motion.mean(axis=1)
    centred = TIME - TIME.mean()
    slope = motion @ centred / (centred @ centred)
    drift = slope[:, None] * centred
    rest = motion - mean[:, None] - drift
    close = {"rel": 2e-5, "abs": 1e-12}
    assert shift_weight(frequency, EXPOSURE) == pytest.approx(np.mean(mean**2), **close)
    assert smear_weight(frequency, EXPOSURE) == pytest.approx(np.mean(drift**2), **close)
    assert jitter_weight(frequency, EXPOSURE) == pytest.approx(np.mean(rest**2), **close)
    about = np.mean((motion - mean[:, None]) ** 2)
    assert relative_weight(frequency, EXPOSURE) == pytest.approx(about, **close)
    later = sampled(frequency, start + 0.7).mean(axis=1)
    expected = np.mean((later - mean) ** 2)
    assert drift_weight(frequency, EXPOSURE, 0.7) == pytest.approx(expected, **close)


def test_mtf_of_single_motions_is_that_of_sampled_ones():
    detail = np.array([0.0, 2e4, 1e5])
    phase = np.arange(2000) / 2000.0 * 2.0 * np.pi
    amplitude, length, sigma = 2e-6, 5e-6, 1e-6

    def blurred(motion):
        return np.abs(np.exp(2j * np.pi * detail[:, None] * motion).mean(axis=1))

    np.testing.assert_allclose(
        sinusoid_mtf(detail, amplitude), blurred(amplitude * np.sin(phase)), atol=1e-9
    )
    ramp = length * (np.arange(20000) + 0.5) / 20000.0
    np.testing.assert_allclose(smear_mtf(detail, length), blurred(ramp), atol=1e-6)
    noise = sigma * np.random.default_rng(0).standard_normal(200_000)
    np.testing.assert_allclose(gaussian_mtf(detail, sigma), blurred(noise), atol=0.005)


@pytest.mark.parametrize("frequency", [[3.0], [600.0], [3.0, 600.0, 1007.0]])
def test_mtf_of_tones_in_an_exposure_is_the_mean_of_sampled_exposures(frequency):
    frequency = np.array(frequency)
    amplitude = np.full(len(frequency), 3e-6)
    detail = np.array([1e4, 5e4])
    generator = np.random.default_rng(1)
    values = []
    for _ in range(400):
        phase = generator.uniform(0.0, 2.0 * np.pi, len(frequency))
        motion = amplitude @ np.cos(frequency[:, None] * TIME + phase[:, None])
        values.append(np.abs(np.exp(2j * np.pi * detail[:, None] * motion).mean(axis=1)))
    result = mtf(detail, frequency, amplitude, 0.0, EXPOSURE)
    np.testing.assert_allclose(result, np.mean(values, axis=0), atol=0.015)
    assert result[1] < 0.995
