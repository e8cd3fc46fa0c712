"""Noise of the samples of a current, and steps between them, bias nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples, blocks_of
from gyrostat.monitoring.drive_samples import lag_noise, sample_noise, step_variance
from gyrostat.monitoring.estimate import _moments
from gyrostat.monitoring.moments import LAG
from tests.monitoring.closed_loop import NOMINAL
from tests.monitoring.test_instruments import scores

DURATION = 43200
RPM = np.pi / 30.0
SHEET = {"motor_constant": 0.05 * 0.027, "viscous": 0.3 * 5e-6}


def turned(torque, seed, *, period=1, noise=0.005, mixed=0.0, fallen=1.0):
    """Telemetry of a wheel with an acceleration torque at each second, in N·m, and friction noise.

    `mixed` of a sample of the current is that of the second before; the viscous coefficient is
    that at 20 °C times `fallen`.
    """
    random = np.random.default_rng(seed)
    draws = random.standard_normal(3)
    motor = NOMINAL["motor_constant"] * (1.0 + 0.05 * draws[0])
    viscous = NOMINAL["viscous"] * np.exp(0.3 * draws[1])
    coulomb = NOMINAL["coulomb"] * np.exp(0.1 * draws[2])
    keep = np.exp(-1.0 / 1200.0)
    shocks = noise * coulomb * np.sqrt(1.0 - keep**2) * random.standard_normal(DURATION)
    friction = np.full(DURATION, coulomb)
    for k in range(1, DURATION):
        friction[k] = coulomb + keep * (friction[k - 1] - coulomb) + shocks[k]
    change = torque / NOMINAL["inertia"]
    speed = 200.0 + np.concatenate([[0.0], np.cumsum(change)[:-1]])
    current = (torque + friction + viscous * fallen * (speed + 0.5 * change)) / motor
    current[1:] = (1.0 - mixed) * current[1:] + mixed * current[:-1]
    noisy = random.standard_normal((2, DURATION))
    speed = np.round(speed / (0.4 * RPM) + 0.2 * noisy[0]) * 0.4 * RPM
    current = np.round(current / 1e-3 + 0.5 * noisy[1]) * 1e-3
    truth = SimpleNamespace(motor_constant=motor, viscous=viscous, mean=friction.mean())
    time = np.arange(0.0, DURATION, period)
    return Samples(time, speed[::period, None], current[::period, None]), truth


def test_noise_of_the_current_does_not_hide_its_lag():
    # sines of five minutes: a lag looks like viscous friction
    time = np.arange(DURATION)
    torque = 30.0 * NOMINAL["inertia"] * 2.0 * np.pi / 313.0 * np.sin(2.0 * np.pi * time / 313.0)
    found = [
        scores(turned(torque, seed, mixed=seed / 11.0), SHEET, float(DURATION))[:, 0]
        for seed in range(12)
    ]
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(0.0, abs=1.3)


@pytest.mark.parametrize("period", [1, 5, 10])
def test_steps_of_the_current_between_samples_bias_nothing(period):
    # slews at constant acceleration for 40 s, coasting for 200 s, and back
    phase = np.arange(DURATION) % 3002
    pulse = 1.0 * (phase % 1501 < 40) - ((phase % 1501 >= 240) & (phase % 1501 < 280))
    torque = 0.75 * NOMINAL["inertia"] * pulse * np.where(phase < 1501, 1.0, -1.0)
    found = [
        scores(turned(torque, seed, period=period, mixed=seed / 11.0), SHEET, float(DURATION))
        for seed in range(12)
    ]
    assert np.sqrt(np.mean(np.square(found), axis=(0, 2))) == pytest.approx(0.0, abs=1.4)


def drawn(drive):
    """Blocks of 60 samples, 1 s apart, of one wheel."""
    time = np.arange(drive.size, dtype=float)
    return blocks_of(Samples(time, 0.0 * drive[:, None], drive[:, None]), 60.0, 0.0)[0]


def test_a_step_between_samples_tells_the_variance_of_the_mean():
    random = np.random.default_rng(3)
    count = 4000
    at = random.uniform(5.0, 55.0, count)  # of a block of a step of height 1
    drive = (np.arange(60) >= at[:, None]).astype(float)
    drive = np.column_stack([drive, np.ones((count, 59)), 0.5 * np.ones(count)]).ravel()
    blocks = drawn(drive)
    steps = blocks.part(np.arange(len(blocks)) % 2 == 0)
    error = steps.drive[:, 0] - (60.0 - at[: len(steps)]) / 60.0
    found = steps.drive_noise[:, 0] ** 2 / (4.0 * steps.count)
    assert np.median(found) == pytest.approx(np.var(error), rel=0.05)
    # a block with other errors of 1e-3 A: their variance is the unit
    other = replace(
        steps, drive_noise=np.concatenate([np.zeros((count, 1)), steps.drive_noise[:1]])
    )
    other = replace(other, count=np.full(count + 1, 60), step=np.full((count + 1, 1), np.inf))
    ratio = step_variance(other.part(slice(0, count + 1)), 0, 1e-3)
    assert ratio[-1] == pytest.approx(1.0 + found[0] / 1e-6)
    assert ratio[0] == 1.0


@pytest.mark.parametrize("noise", [0.1, 3.0])
def test_the_noise_of_the_lag_has_the_variance_of_the_samples(noise):
    # in steps of 1 A, with little noise the rounding counts
    random = np.random.default_rng(4)
    slow = 300.0 * np.sin(np.arange(600000) / 977.0)
    drive = np.round(slow + noise * random.standard_normal(slow.size))
    blocks = drawn(drive)
    total = np.hypot(noise, 1.0 / 12.0**0.5)
    assert sample_noise(blocks, 0) == pytest.approx(total, rel=0.1)
    made = lag_noise(blocks, 0)
    true = np.diff((drive - slow)[::60])[: made.size] / 60.0
    assert np.mean(made**2) == pytest.approx(np.mean(true**2), rel=0.15)
    # neighbours share a sample
    assert np.mean(made[1:] * made[:-1]) == pytest.approx(np.mean(true[1:] * true[:-1]), rel=0.15)


def test_noise_that_is_larger_than_the_change_of_the_drive_leaves_no_information():
    products = np.zeros((14, 14))
    products[5 + LAG, LAG] = 1.0
    products[11, 12] = 3.0
    assert _moments(products, 5).mixed[LAG, LAG] == 0.0
    products[11, 12] = 0.25
    assert _moments(products, 5).mixed[LAG, LAG] == 0.75
