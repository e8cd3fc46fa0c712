"""Measured position against the orbit, and its effect on pointing at the ground."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax
from gyrostat.spacecraft import PositionSensor
from tests.spacecraft import orbit_samples


def test_the_position_has_bias_and_noise_which_turn_the_line_of_sight():
    orbit, bias = orbit_samples.noon(1000.0), np.array([100.0, -50.0, 20.0])
    sensor = PositionSensor(orbit, 10.0, bias)
    sensor.check()
    keys = jax.random.split(jax.random.key(2), 2000)
    seen = np.asarray(jax.jit(jax.vmap(lambda key: sensor(None, 300.0, key)))(keys))
    there, ground = jax.jit(lambda t: (orbit.position(t), orbit.ground(0.3, 0.1, 0.0, t)))(300.0)
    off = seen - np.asarray(there)
    np.testing.assert_allclose(off.mean(0), bias, atol=4.0 * 10.0 / np.sqrt(2000.0))
    np.testing.assert_allclose(off.std(0), 10.0, rtol=0.08)
    sight = np.asarray(ground) - np.asarray(there)
    distance = np.linalg.norm(sight)
    across = bias - sight * (sight @ bias) / distance**2
    wrong = sight - bias
    angle = np.arccos(wrong @ sight / distance / np.linalg.norm(wrong))
    assert angle == pytest.approx(np.linalg.norm(across) / distance, rel=1e-3)
