"""Noise of the samples of a current, and steps between them, bias nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gyrostat.monitoring.blocks import Samples, blocks_of
from gyrostat.monitoring.differences import calm_noise
from gyrostat.monitoring.drive_samples import (
    lag_noise,
    resolution,
    sample_noise,
    step_variance,
    stepping,
)
from gyrostat.monitoring.estimate import moments_of
from gyrostat.monitoring.moments import LAG
from tests.monitoring.closed_loop import NOMINAL
from tests.monitoring.test_instruments import scores

DURATION = 43200
RPM = np.pi / 30.0
SHEET = {"motor_constant": 0.05 * 0.027, "viscous": 0.3 * 5e-6}


def turned(torque, seed, *, period=1, noise=0.005, mixed=0.0, fallen=1.0, step=1e-3, dither=0.5):
    """Telemetry of a wheel with an acceleration torque at each second, in N·m, and friction noise.

    `mixed` of a sample of the current is that of the second before; the viscous coefficient is
    that at 20 °C times `fallen`. Currents are rounded to a step in A, with noise of a share of it.
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
    current = np.round(current / step + dither * noisy[1]) * step
    truth = SimpleNamespace(motor_constant=motor, viscous=viscous, mean=friction.mean())
    time = np.arange(0.0, DURATION, period)
    return Samples(time, speed[::period, None], current[::period, None]), truth


def smooth_slews():
    """Torque of slews like sines, with pauses, at each second, N·m."""
    phase = np.arange(DURATION) % 3000
    pulse = np.where(phase < 400, np.sin(2.0 * np.pi * phase / 400.0), 0.0)
    return 6e-4 * (pulse - np.roll(pulse, 1500))


def short_slews():
    """Torque of 20 s of acceleration, one way and the other, each 15 minutes, N·m."""
    phase, way = np.arange(DURATION) % 900, np.arange(DURATION) // 900 % 2
    return 1.5 * NOMINAL["inertia"] * np.where(way == 0, 1.0, -1.0) * (phase < 20)


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


def steps_in(blocks):
    return stepping(blocks, 0, resolution(blocks, 0))


def noise_in(blocks):
    return sample_noise(blocks, 0, resolution(blocks, 0))


def told(blocks):
    """Blocks, place of their wheel, their steps and the noise of their samples."""
    return blocks, 0, steps_in(blocks), noise_in(blocks)


def test_a_step_between_samples_tells_the_variance_of_the_mean():
    random = np.random.default_rng(3)
    count = 4000
    at = random.uniform(5.0, 55.0, count)  # of a block of a step of height 1
    drive = (np.arange(60) >= at[:, None]).astype(float)
    drive = np.column_stack([drive, np.ones((count, 59)), 0.5 * np.ones(count)]).ravel()
    drive += 1e-6 * random.standard_normal(drive.size)
    blocks = drawn(drive)
    steps = blocks.part(np.arange(len(blocks)) % 2 == 0)
    error = steps.drive[:, 0] - (60.0 - at[: len(steps)]) / 60.0
    height = steps.drive_steps[:, 0]
    np.testing.assert_allclose(height, 1.0, atol=1e-3)
    assert np.mean((height / 60.0) ** 2) / 12.0 == pytest.approx(np.var(error), rel=0.05)
    # the balance of a block has other errors of 1e-3 A
    expected = 1.0 + 1e6 / (12.0 * 60.0**2)
    np.testing.assert_allclose(step_variance(*told(steps), 1e-3), expected, rtol=0.06)
    assert steps_in(steps).all()
    back = replace(steps, drive_change=0.0 * steps.drive_change)
    np.testing.assert_allclose(step_variance(*told(back), 1e-3), 2.0 * expected - 1.0, rtol=0.06)


def test_noise_has_no_steps_and_steps_hardly_make_noise():
    random = np.random.default_rng(7)
    noise = np.repeat([1.0, 40.0, 1.0], 60000) * random.standard_normal(180000)
    assert not steps_in(drawn(noise)).any()
    noise[3030:3060] += 100.0  # a step up at 3030, down at 3060, in the next block
    assert np.flatnonzero(steps_in(drawn(noise))).tolist() == [50]
    calm = drawn(random.standard_normal(60000))
    pulses = drawn(random.standard_normal(60000) + 200.0 * (np.arange(60000) % 97 == 0))
    assert noise_in(calm) == pytest.approx(1.0, rel=0.05)
    assert noise_in(pulses) == pytest.approx(1.0, rel=0.25)


def test_the_resolution_divides_all_steps_of_a_current():
    # before slews of one size the current is the same: it never changes by one step
    levels = 0.07 + 0.01 * np.tile([0, 8, 0, -9], 300)
    drive = np.repeat(levels, 60)[30:]
    assert resolution(drawn(drive), 0) == pytest.approx(0.01, rel=1e-6)
    tiny = 1e-9 * np.random.default_rng(1).standard_normal(drive.size)
    assert resolution(drawn(drive + tiny), 0) == pytest.approx(0.01, rel=1e-5)
    assert resolution(drawn(np.ones(600)), 0) == 0.0


@pytest.mark.parametrize("glitch", [-999.0, 1e12, 3.4e38, 0.37e-2])
def test_one_odd_sample_does_not_decide_on_the_resolution(glitch):
    levels = 0.07 + 0.01 * np.tile([0, 8, 0, -9], 300)
    drive = np.repeat(levels, 60)[30:]
    drive[20011] = glitch if abs(glitch) > 1.0 else drive[20011] + glitch
    single = drive.astype(np.float32).astype(float)
    assert resolution(drawn(single), 0) == pytest.approx(0.01, rel=1e-4)


@pytest.mark.parametrize("digits", [4, 6])
@pytest.mark.parametrize("noise", [0.0, 0.4])
def test_printed_counts_have_the_resolution_of_the_converter(digits, noise):
    """A converter of 12 bits and ±10 A: 4.883 mA, of which a table has some decimals."""
    random = np.random.default_rng(3)
    pattern = np.tile([12, 31, 12, -25, 40, 12, 13, -9, 7, 22, 48, 3], 100)
    levels = np.repeat(pattern, 60)[30:]
    counts = np.round(levels + noise * random.standard_normal(levels.size))
    printed = np.round(4.883e-3 * counts, digits)
    assert resolution(drawn(printed), 0) == pytest.approx(4.883e-3, rel=0.03)


def test_a_current_without_steps_has_no_coarse_resolution():
    random = np.random.default_rng(4)
    noise = random.standard_normal(36000)
    blocks = drawn(noise)
    assert resolution(blocks, 0) <= np.quantile(blocks.step, 0.5)


def test_a_few_noisy_minutes_have_no_steps():
    random = np.random.default_rng(9)
    noise = random.standard_normal(30000)
    noise[6000:6300] *= 40.0
    # the block before them ends at their first sample
    assert np.flatnonzero(steps_in(drawn(noise))).tolist() in ([], [99])


def test_a_step_with_a_sample_on_its_way_is_one():
    random = np.random.default_rng(10)
    drive = random.standard_normal(60000)
    for at in range(900, 60000, 907):
        drive[at] += 30.0
        drive[at + 1 :] += 60.0
    blocks = drawn(drive)
    expected = np.unique((np.arange(900, 60000, 907) - 1) // 60)
    found = np.flatnonzero(steps_in(blocks))
    # on its way at the edge of a block, it may be in either
    assert np.min(np.abs(found[:, None] - expected), axis=0).max() <= 1
    np.testing.assert_allclose(blocks.drive_steps[found, 0], 30.0, atol=8.0)


def test_slow_motion_is_no_noise():
    slow = drawn(np.sin(2.0 * np.pi * np.arange(60000) / 20.0))
    assert slow.drive_noise.max() < 2e-3
    assert not steps_in(slow).any()


@pytest.mark.parametrize("count", [4, 6, 12, 60, 600])
def test_a_quarter_of_the_blocks_shows_the_noise(count):
    random = np.random.default_rng(count)
    values = random.standard_normal((3000 * count + 2, 1))
    first = np.arange(3000) * count
    found = calm_noise(np.diff(values, n=2, axis=0), first, first + count)
    assert np.mean(found) == pytest.approx(1.0, rel=0.8 / count)
    blocks = SimpleNamespace(
        drive_noise=found, count=np.full(3000, count), step=np.full((3000, 1), np.inf)
    )
    assert noise_in(blocks) == pytest.approx(1.0, rel=0.08)


@pytest.mark.parametrize("noise", [0.1, 3.0])
def test_the_noise_of_the_lag_has_the_variance_of_the_samples(noise):
    # in steps of 1 A, with little noise the rounding counts
    random = np.random.default_rng(4)
    slow = 300.0 * np.sin(np.arange(600000) / 977.0)
    drive = np.round(slow + noise * random.standard_normal(slow.size))
    blocks = drawn(drive)
    total = np.hypot(noise, 1.0 / 12.0**0.5)
    assert noise_in(blocks) == pytest.approx(total, rel=0.1)
    made = lag_noise(blocks, noise_in(blocks))
    true = np.diff((drive - slow)[::60])[: made.size] / 60.0
    assert np.mean(made**2) == pytest.approx(np.mean(true**2), rel=0.15)
    # neighbours share a sample
    assert np.mean(made[1:] * made[:-1]) == pytest.approx(np.mean(true[1:] * true[:-1]), rel=0.15)


def test_noise_that_is_larger_than_the_change_of_the_drive_leaves_no_information():
    products = np.zeros((16, 16))
    products[6 + LAG, LAG] = 1.0
    products[13, 14] = 3.0
    assert moments_of(products, 6).mixed[LAG, LAG] == 0.0
    products[13, 14] = 0.25
    assert moments_of(products, 6).mixed[LAG, LAG] == 0.75


def test_blocks_next_to_missing_values_have_no_noise_of_their_own():
    random = np.random.default_rng(8)
    drive = random.standard_normal(6000)
    drive[601:661] = np.nan
    blocks = drawn(drive)
    present = blocks.part(np.isfinite(blocks.drive[:, 0]))
    assert np.isnan(present.drive_noise).any()
    assert np.isfinite(lag_noise(present, noise_in(present))).all()
    assert np.isfinite(step_variance(*told(present), 1.0)).all()


def test_a_current_later_than_half_a_period_is_told():
    found = []
    for seed in range(12):
        samples, truth = turned(smooth_slews(), seed)
        late = replace(samples, drive=np.roll(samples.drive, 3, axis=0))
        found.append(scores((late, truth), SHEET, float(DURATION))[:, 0])
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(0.0, abs=1.5)


def test_a_rough_bearing_with_chatter_loses_no_weight():
    """Friction is larger while the current is noisy; that noise has no steps."""
    rough = np.arange(DURATION) % 5700 < 2000
    more = 0.1 * NOMINAL["coulomb"]
    found = []
    for seed in range(8):
        samples, truth = turned(smooth_slews(), seed)
        noise = 0.02 * np.random.default_rng(seed).standard_normal(DURATION)
        drive = samples.drive + np.where(rough, more / truth.motor_constant + noise, 0.0)[:, None]
        truth.mean += more * np.mean(rough)
        samples = replace(samples, drive=np.round(drive, 3))
        found.append(scores((samples, truth), SHEET, float(DURATION))[:, 0])
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(0.0, abs=1.5)


@pytest.mark.parametrize("late", [1, 9])
def test_steps_at_one_phase_of_the_telemetry_are_no_lag_of_other_minutes(late):
    phase = (np.arange(DURATION) - late) % 700
    torque = 2.6e-4 * np.where(phase < 350, 1.0, -1.0)
    found = [
        scores(turned(torque, seed, period=10), SHEET, float(DURATION))[:, 0] for seed in range(8)
    ]
    assert np.sqrt(np.mean(np.square(found), axis=0)) == pytest.approx(0.0, abs=2.0)


@pytest.mark.parametrize("late", [-1, 0, 1, 2])
def test_slews_at_full_minutes_bias_nothing(late):
    # the step stood at the edge of a block, where a correction of the integral took it for smooth:
    # a second after a full minute, the motor constant was 2.8 sigma off by rms
    flights = [turned(np.roll(short_slews(), late), seed) for seed in range(500, 512)]
    values = np.array([scores(each, SHEET, float(DURATION))[:, 0] for each in flights])
    assert np.sqrt(np.mean(values**2, axis=0)) == pytest.approx(0.0, abs=1.6)
