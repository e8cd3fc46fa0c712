"""The gyro of a table and its sensors together."""

from collections import namedtuple

import numpy as np
from scipy.stats import chi2

from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Gyro, TableSensors, TrueTurn
from gyrostat.wheel import Delayed, Tachometer

PERIOD = 0.1
COUNT = 2000
TIME = PERIOD * np.arange(COUNT + 1)
ATTITUDE = 0.02 * np.sin(0.8 * TIME) + 0.003 * TIME
State = namedtuple("State", ["attitude", "rate", "speed"])
RATE = 0.016 * np.cos(0.8 * TIME) + 0.003


def samples(sensor, seed=0):
    def tick(memory, now):
        return sensor(memory, State(*now[:3]), now[3])

    history = tuple(jnp.asarray(x) for x in (ATTITUDE, RATE, 50.0 * TIME))
    keys = jax.random.split(jax.random.key(seed), len(TIME))
    memory = sensor.start(State(*(x[0] for x in history)), PERIOD)
    return jax.tree.map(np.asarray, jax.lax.scan(tick, memory, (*history, keys))[1])


def test_a_perfect_gyro_gives_increments_over_the_period_and_the_true_attitude():
    turn = samples(Gyro())
    np.testing.assert_allclose(turn.attitude, ATTITUDE, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(turn.rate[1:], np.diff(ATTITUDE) / PERIOD, rtol=0.0, atol=1e-14)
    # before the first sample the table is taken to have turned evenly
    np.testing.assert_allclose(turn.rate[0], RATE[0], rtol=1e-12)


def test_bias_grows_into_attitude_and_noise_into_a_random_walk():
    sigma, bias = 3e-4, 2e-5
    turn = samples(Gyro(sigma, bias))
    noise = turn.rate[1:] - np.diff(ATTITUDE) / PERIOD - bias
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], COUNT)
    assert low < np.sum((noise / sigma) ** 2) < high
    assert abs(np.mean(noise)) < 4.0 * sigma / np.sqrt(COUNT)
    # the attitude is the sum of what the rate says, nothing else
    walk = turn.attitude - turn.attitude[0] - PERIOD * np.cumsum([0.0, *turn.rate[1:]])
    np.testing.assert_allclose(walk, 0.0, atol=1e-15)
    drift = turn.attitude - ATTITUDE - bias * TIME
    assert abs(drift[-1]) < 4.0 * sigma * PERIOD * np.sqrt(COUNT)
    only = samples(Gyro(bias=bias))
    np.testing.assert_allclose(
        only.attitude - only.attitude[0], ATTITUDE - ATTITUDE[0] + bias * TIME, atol=1e-14
    )


def test_gyro_and_tachometer_draw_noise_of_their_own():
    sensors = TableSensors(Gyro(1.0), Tachometer(1.0))
    measured = samples(sensors, seed=5)
    gyro = measured.rate[1:] - np.diff(ATTITUDE) / PERIOD
    tachometer = measured.speed[1:] - 50.0 * TIME[1:]
    assert abs(np.corrcoef(gyro, tachometer)[0, 1]) < 4.0 / np.sqrt(COUNT)
    again = samples(sensors, seed=5)
    np.testing.assert_array_equal(measured.speed, again.speed)
    np.testing.assert_array_equal(measured.rate, again.rate)


def test_true_turn_reads_the_state_and_only_the_tachometer_is_late():
    measured = samples(TableSensors(TrueTurn(), Delayed(Tachometer(), 3)))
    np.testing.assert_array_equal(measured.attitude, ATTITUDE)
    np.testing.assert_array_equal(measured.rate, RATE)
    np.testing.assert_array_equal(measured.speed[3:], 50.0 * TIME[:-3])
