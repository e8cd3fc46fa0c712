"""Rate loop of the estimating compensator: momentum of a friction jump, limits, missing samples."""

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import AttitudePID, EstimatingCompensator
from gyrostat.control.friction.estimating_compensator import SLOWER
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import TableMeasurement
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import ViscousCoulomb

PERIOD, INERTIA, ROTOR, MOTOR, COULOMB, SIGMA = 0.1, 0.495, 1.5e-3, 0.0228, 9e-4, 0.1
BANDWIDTH = 6.0
JUMP = 2e-4


def compensator(limit=np.inf, delay=1, law=None):
    """Compensator with an exact model that does not adapt; by default its law demands nothing."""
    law = AttitudePID(0.0, 0.0, 0.0) if law is None else law
    wheel = Wheel(ROTOR, MOTOR, ViscousCoulomb(0.0, COULOMB))
    options = {"bandwidth": BANDWIDTH, "current_limit": limit, "delay": delay}
    made = EstimatingCompensator.tune(law, wheel, INERTIA, SIGMA, PERIOD, **options)
    return eqx.tree_at(lambda own: own.learning_rate, made, 0.0)


@pytest.fixture(scope="module")
def flown():
    """Rate of the table and torque of the rate loop; the friction jumps at sample 100."""

    @jax.jit
    def call(limit):
        control = compensator(limit)

        def tick(carry, k):
            memory, rate, speed, sent = carry
            memory, command = control(memory, TableMeasurement(0.0, rate, speed))
            net = MOTOR * sent - COULOMB - jnp.where(k < 100.0, 0.0, JUMP)
            after = rate - PERIOD * net / INERTIA
            speed = speed + PERIOD * net / ROTOR - (after - rate)
            returned = MOTOR * command.attitude_current - memory.rate.torque
            return (memory, after, speed, command.current), (after, returned)

        start = (control.start(PERIOD), 0.0, 300.0, COULOMB / MOTOR)
        return jax.lax.scan(tick, start, jnp.arange(300.0))[1]

    return lambda limit: [np.asarray(x) for x in call(limit)]


def test_the_table_gives_the_momentum_of_a_friction_jump_back(flown):
    """An observer alone leaves the integral of its error: two of its time constants of the jump."""
    left = 2.0 * JUMP / (BANDWIDTH * INERTIA)
    rate, _ = flown(np.inf)
    assert np.max(np.abs(rate)) > 0.3 * left
    # ten seconds are twenty time constants of the rate loop
    assert np.max(np.abs(rate[200:])) < 1e-6 * left


def test_the_rate_loop_does_not_wind_up_while_the_current_is_limited(flown):
    """The motor gives less than the friction: the table turns, and nothing is to be returned."""
    rate, returned = flown(0.9 * COULOMB / MOTOR)
    assert np.all(np.diff(rate[10:]) > 0.0)
    # the table accelerates steadily, and the undisturbed rate follows with the loop's bandwidth
    assert np.max(np.abs(returned[250:])) < 1e-6 * COULOMB
    assert rate[-1] * INERTIA * BANDWIDTH / SLOWER > 3.0 * COULOMB


def test_a_missed_sample_leaves_the_momentum_to_return_as_it_was():
    """The held command turns the table and the undisturbed rate alike."""
    control = compensator(delay=0)

    @jax.jit
    def sampled_and_missed(seen):
        memory, command = control(control.start(PERIOD), seen)
        return memory, control.predicted(memory, None, command)

    memory, later = sampled_and_missed(TableMeasurement(0.0, 1e-4, 30.0))
    before = memory.rate.rate - memory.undisturbed
    assert abs(before) > 1e-6
    assert abs(later.rate.rate - memory.rate.rate) > 1e-6
    np.testing.assert_allclose(later.rate.rate - later.undisturbed, before, rtol=1e-9)


def test_a_large_demand_does_not_turn_the_compensation_of_a_fast_wheel_round():
    """The sign of 5 rad/s is certain with 0.1 rad/s of noise."""
    control = compensator(law=AttitudePID(0.0571, 0.0, 0.3126))
    _, command = control(control.start(PERIOD), TableMeasurement(-0.5, 0.0, 5.0))
    assert command.attitude_current * MOTOR < -20.0 * COULOMB
    np.testing.assert_allclose(command.friction_current * MOTOR, COULOMB, rtol=1e-12)
