"""Sensors of speed: noise, counted pulses, low pass and delay."""

from collections import namedtuple

import equinox as eqx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, kstest

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.wheel import Delayed, LowPass, PulseTachometer, Tachometer, WheelTachometer

PERIOD = 0.1
TURN = 2.0 * np.pi
State = namedtuple("State", ["speed", "wheel_angle"])


@eqx.filter_jit
def measured(sensor, speed, angle, seed):
    """Measurements of a history; compiled once for each kind of sensor and length."""

    def tick(memory, now):
        return sensor(memory, State(*now[:2]), now[2])

    keys = jax.random.split(jax.random.key(seed), len(speed))
    memory = sensor.start(State(speed[0], angle[0]), PERIOD)
    return jax.lax.scan(tick, memory, (speed, angle, keys))[1]


def samples(sensor, speed, angle=None, seed=0):
    """Measurements of a history by a sensor, whose numbers are arguments of the program."""
    speed = np.asarray(speed, float)
    if angle is None:
        angle = (PERIOD * np.arange(len(speed)) * speed.T).T
    numbers = (int, float)
    sensor = jax.tree.map(lambda x: np.asarray(x) if isinstance(x, numbers) else x, sensor)
    return np.asarray(measured(sensor, speed, np.asarray(angle, float), np.asarray(seed)))


def test_noise_has_its_standard_deviation_is_normal_and_white():
    count, sigma = 4000, 0.7
    noise = (samples(Tachometer(sigma), np.full(count, 5.0)) - 5.0) / sigma
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], count)
    assert low < np.sum(noise**2) < high
    assert abs(np.mean(noise)) < 4.0 / np.sqrt(count)
    assert abs(np.mean(noise[1:] * noise[:-1])) < 4.0 / np.sqrt(count)
    assert kstest(noise, "norm").pvalue > 1e-3


def test_equal_seeds_give_equal_samples_and_others_do_not():
    speed = np.linspace(-1.0, 1.0, 50)
    first = samples(Tachometer(0.1), speed, seed=3)
    np.testing.assert_array_equal(first, samples(Tachometer(0.1), speed, seed=3))
    assert np.all(first != samples(Tachometer(0.1), speed, seed=4))
    np.testing.assert_array_equal(samples(Tachometer(), speed), speed)


@pytest.mark.parametrize("gate", [1, 3])
def test_pulses_are_those_whose_edges_lie_in_the_gate(gate):
    """Count the edges k 2π/N between two angles one by one, either way round."""
    pulses = 24
    time = PERIOD * np.arange(120)
    angle = 0.013 + 9.0 * np.sin(0.7 * time) + 0.4 * time
    speed = 6.3 * np.cos(0.7 * time) + 0.4
    found = samples(PulseTachometer(pulses, gate), speed, angle)
    quantum = TURN / (pulses * gate * PERIOD)
    counts = found / quantum
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
    edges = TURN / pulses * np.arange(-4000, 4001)
    for k in range(gate, len(time)):
        low, high = sorted((angle[k - gate], angle[k]))
        passed = np.sum((edges > low) & (edges <= high))
        assert round(counts[k]) == np.sign(angle[k] - angle[k - gate]) * passed
    assert np.min(counts) <= -2
    assert np.max(counts) >= 3
    # no count is more than one pulse from the mean speed over the gate
    mean = (angle[gate:] - angle[:-gate]) / (gate * PERIOD)
    assert np.all(np.abs(found[gate:] - mean) < quantum)


@settings(max_examples=20)
@given(st.floats(-200.0, 200.0), st.integers(1, 500), st.integers(1, 3))
def test_a_steady_wheel_is_counted_within_one_pulse_from_the_first_sample(speed, pulses, gate):
    found = samples(PulseTachometer(pulses, gate), np.full(8, speed))
    assert np.all(np.abs(found - speed) <= TURN / (pulses * gate * PERIOD) * (1.0 + 1e-9))


def test_a_resting_wheel_gives_no_pulses():
    assert np.all(samples(PulseTachometer(24), np.zeros(9), np.full(9, -0.3)) == 0.0)


def test_the_low_pass_is_exact_for_its_samples():
    """Against the same filter as a loop; a step then settles by exp(-t/tau)."""
    value = np.concatenate([np.full(5, 2.0), np.full(60, 3.0)])
    filtered = samples(LowPass(Tachometer(), 0.35), value)
    np.testing.assert_allclose(filtered[:5], 2.0, rtol=1e-14)
    since = PERIOD * np.arange(1, 61)
    np.testing.assert_allclose(filtered[5:], 3.0 - np.exp(-since / 0.35), rtol=1e-13)


def test_the_low_pass_calms_noise_as_an_autoregression_does():
    sigma, tau, count = 0.5, 0.4, 20000
    noise = samples(LowPass(Tachometer(sigma), tau), np.zeros(count))[200:]
    decay = np.exp(-PERIOD / tau)
    variance = sigma**2 * (1.0 - decay) / (1.0 + decay)
    # correlated samples count for less: (1 - a²)/(1 + a²) of their number
    spread = np.sqrt(2.0 / (len(noise) * (1.0 - decay**2) / (1.0 + decay**2)))
    assert abs(np.mean(noise**2) / variance - 1.0) < 4.0 * spread
    assert abs(np.mean(noise[1:] * noise[:-1]) / variance - decay) < 4.0 * spread


class Dice:
    """A sensor of whole numbers: no program can round them otherwise than another."""

    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, jax.random.bits(key)


@pytest.mark.parametrize("periods", [1, 7])
def test_a_delay_moves_the_samples_and_the_first_stands_for_those_before(periods):
    speed = np.sin(np.arange(40.0))
    late, now = samples(Delayed(Dice(), periods), speed), samples(Dice(), speed)
    assert len(np.unique(now)) == len(now)
    np.testing.assert_array_equal(late[periods:], now[:-periods])
    np.testing.assert_array_equal(late[:periods], now[0])


SEVERAL = np.array([5.0, -0.3, 0.0, 120.0])


def of_several(sensor, count=40):
    """Measurements of wheels that turn evenly."""
    return samples(sensor, np.tile(SEVERAL, (count, 1)), seed=1)


def test_several_wheels_are_measured_as_each_alone():
    pulses = of_several(PulseTachometer(24, 3))
    for k, speed in enumerate(SEVERAL):
        alone = samples(PulseTachometer(24, 3), np.full(40, speed))
        np.testing.assert_array_equal(pulses[:, k], alone)
    filtered = of_several(LowPass(PulseTachometer(24), 0.3))
    alone = samples(LowPass(PulseTachometer(24), 0.3), np.full(40, SEVERAL[0]))
    np.testing.assert_allclose(filtered[:, 0], alone, rtol=1e-14)


def test_a_wheel_tachometer_is_made_of_the_simple_ones():
    """Each of pulses, noise and lag, alone and together; none of them is the speed itself."""
    np.testing.assert_array_equal(of_several(WheelTachometer()), np.tile(SEVERAL, (40, 1)))
    for pulses, lag in ((24.0, 0.0), (0.0, 0.3), (24.0, 0.3)):
        simple = PulseTachometer(pulses) if pulses else Tachometer()
        simple = LowPass(simple, lag) if lag else simple
        found = of_several(WheelTachometer(0.0, pulses, lag))
        np.testing.assert_allclose(found, of_several(simple), rtol=1e-14)
    noisy = of_several(WheelTachometer(0.2), 2000) - SEVERAL
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], noisy.size)
    assert low < np.sum((noisy / 0.2) ** 2) < high


@pytest.mark.parametrize("values", [(-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, np.nan)])
def test_a_wheel_tachometer_of_senseless_numbers_is_refused(values):
    with pytest.raises(InputError, match="tachometer"):
        WheelTachometer(*values).check()
