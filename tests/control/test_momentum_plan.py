"""Momentum plan: entries over time, and the times in which the actuator works."""

import numpy as np
import pytest

from gyrostat.control import MomentumPlan, MomentumUnloading
from gyrostat.core import rotations
from gyrostat.core.jax64 import jnp

PLAN = MomentumPlan([10.0, 20.0], [4.0, 0.0], [[1e-3, 0.0, 0.0], [0.0, 0.0, 0.0]], [2e-3, -1e-3])
TURNED = rotations.from_rotation_vector(jnp.array([0.0, 0.0, np.pi / 2]))


@pytest.mark.parametrize(
    ("time", "level"),
    [(0.0, 2e-3), (10.0, 2e-3), (19.9, 2e-3), (20.0 - 1e-12, -1e-3), (99.0, -1e-3)],
)
def test_an_entry_holds_until_the_next_and_the_first_before_too(time, level):
    assert PLAN.level(time) == level


@pytest.mark.parametrize(
    ("time", "acts"), [(9.9, False), (10.0, True), (13.9, True), (14.0, False)]
)
def test_the_actuator_works_only_in_its_time_and_towards_inertial_momentum(time, acts):
    law = MomentumUnloading(1.0, 0.5)
    momentum = jnp.array([2e-3, 0.0, 0.0])
    # the inertial x axis is -y of the body
    expected = -0.5 * np.array([2e-3, 1e-3, 0.0]) if acts else np.zeros(3)
    torque = PLAN.torque(law, time, TURNED, momentum)
    np.testing.assert_allclose(torque, expected, atol=1e-18)
