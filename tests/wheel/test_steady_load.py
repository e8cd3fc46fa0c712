"""A constant current: the step without the events of a changing load gives the same motion."""

import numpy as np
import pytest

from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import Wheel, advance
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

WHEELS = {
    "stribeck": Wheel(1.5e-3, 0.0228, Stribeck(4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)),
    "viscous": Wheel(1.5e-3, 0.0228, ViscousCoulomb(4.83e-6, 0.8795e-3)),
}


@pytest.mark.parametrize("name", WHEELS)
def test_a_constant_current_gives_the_same_motion_as_a_slope_of_zero(name):
    random = np.random.default_rng(0)
    speed = random.choice([-1.0, 1.0], 400) * 10.0 ** random.uniform(-4.0, 1.0, 400)
    speed[:100] = 0.0
    current = random.choice([0.0, 0.03, 0.0386, 0.04, 0.2, -0.05], 400)

    def moved(slope):
        return jax.jit(jax.vmap(lambda w, i: advance(WHEELS[name], w, i, slope, 0.7)))(
            speed, current
        )

    steady, resolved = moved(0.0)
    general, both = moved(jnp.asarray(0.0))
    assert np.all(resolved)
    assert np.all(both)
    assert np.allclose(steady, general, rtol=1e-11, atol=1e-13)
    assert np.array_equal(steady == 0.0, general == 0.0)
    # some wheels stay, some stop, some start and some turn the other way
    assert np.any((speed == 0.0) & (steady == 0.0))
    assert np.any((speed != 0.0) & (steady == 0.0))
    assert np.any((speed == 0.0) & (steady != 0.0))
    assert np.any(speed * steady < 0.0)
