"""Momentum plan: entries over time, and the times in which the actuator works."""

import numpy as np
import pytest

from gyrostat.control import MomentumPlan, MomentumUnloading
from gyrostat.core import rotations
from gyrostat.core.jax64 import jnp

NOTHING = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
PLAN = MomentumPlan(
    [10.0, 20.0], [4.0, 0.0], [[1e-3, 0.0, 0.0], NOTHING[0]], [2e-3, -1e-3], NOTHING, NOTHING
)
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
    torque = PLAN.unload(law, time, TURNED, momentum)
    np.testing.assert_allclose(torque, expected, atol=1e-18)


@pytest.mark.parametrize("drift", [2e-6, 9e-6])
def test_feed_forward_reaches_the_momentum_against_a_drift_above_the_limit(drift):
    """A body at rest whose momentum is the integral of drift and actuator."""
    limit, time, start = 3e-6, 200.0, np.array([1e-3, 2e-3, 0.0])
    external = np.array([drift, -drift, 0.0])
    change = 0.9 * limit * np.array([1.0, -1.0, 0.5])
    end = start + time * (external + change)
    plan = MomentumPlan([0.0], [time], [end], [0.0], [external + change], [change])
    law, identity = MomentumUnloading([limit] * 3, 0.02), jnp.array([1.0, 0.0, 0.0, 0.0])
    # a known error at the start is removed by the torque that the plan leaves
    momentum = start + np.array([1e-5, 0.0, 0.0])
    for step in range(50):
        torque = np.asarray(plan.unload(law, 4.0 * step, identity, jnp.asarray(momentum)))
        assert np.all(np.abs(torque) <= limit)
        momentum = momentum + 4.0 * (external + torque)
    # the error decays as (1 - k T)^n of the sampled loop
    np.testing.assert_allclose(momentum - end, [1e-5 * 0.92**50, 0.0, 0.0], atol=1e-15)
