"""Steady attitude error under an external torque, and the estimate that removes it."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import AttitudeRegulator, MomentumRecovery
from gyrostat.control.attitude.external_torque import ExternalTorqueMemory
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft, SpacecraftMeasurement
from gyrostat.wheel import WheelArray

PERIOD, COUNT = 0.25, 1200
INERTIA, ROTOR = np.array([0.06, 0.12, 0.14]), 2e-5
TORQUE = np.array([3e-7, -2e-7, 1e-7])
CRAFT = Spacecraft(np.diag(INERTIA), WheelArray(np.eye(3), ROTOR, 1e-3, 1e-2))
TARGET = jnp.array([1.0, 0.0, 0.0, 0.0])
LAW = MomentumRecovery.plan(CRAFT, [True] * 3, total_momentum=np.zeros(3), target=TARGET)


def final_error(law):
    """Rotation vector after `COUNT` samples; laws that differ by numbers share a program."""
    attitude = _last_attitude(jax.tree.map(np.asarray, law))
    return Rotation.from_quat(np.array(attitude), scalar_first=True).as_rotvec()


@eqx.filter_jit
def _last_attitude(law):
    """Of a body with wheels without friction."""

    def step(carry, _):
        memory, attitude, rate, momenta = carry
        speed = momenta / ROTOR - rate
        seen = SpacecraftMeasurement(attitude, rate, speed, jnp.ones(3, bool))
        memory, command = law(memory, seen)
        # the gyroscopic torque is neglected: the body hardly turns
        after = rate + PERIOD * (TORQUE - command.torque) / INERTIA
        turned = rotations.from_rotation_vector(0.5 * PERIOD * (rate + after))
        attitude = rotations.product(attitude, turned)
        return (memory, attitude, after, momenta + PERIOD * command.torque), ()

    begin = (law.start(PERIOD), TARGET, jnp.zeros(3), jnp.zeros(3))
    return jax.lax.scan(step, begin, length=COUNT)[0][1]


def test_the_steady_error_is_removed():
    loop = LAW.law
    expected = TORQUE / (INERTIA * loop.wheels.gain * loop.turn_gain)
    np.testing.assert_allclose(final_error(LAW), expected, rtol=1e-3)
    for time, size in ((np.inf, 1.0), (20.0, 1e-4)):
        error = final_error(dataclasses.replace(LAW, torque_time=time))
        assert np.linalg.norm(error) == pytest.approx(
            size * np.linalg.norm(expected), rel=1e-3, abs=1e-4 * np.linalg.norm(expected)
        )


def test_the_steady_error_of_a_regulator_is_removed():
    law = AttitudeRegulator(CRAFT, TARGET, 1e-4, 1e-3, 1.0).linear()
    # the attitude term sqrt(q_s / r) times a quarter of the angle
    expected = 4.0 * TORQUE / np.sqrt(1e-4)
    np.testing.assert_allclose(final_error(law), expected, rtol=1e-3)
    error = final_error(dataclasses.replace(law, torque_time=20.0))
    assert np.linalg.norm(error) < 1e-3 * np.linalg.norm(expected)


def test_the_torques_of_a_regulator_keep_their_direction_at_the_limit():
    law = AttitudeRegulator(CRAFT, TARGET, 1.0, 1.0, 1.0).linear()
    free = AttitudeRegulator(
        Spacecraft(CRAFT.inertia, WheelArray(np.eye(3), ROTOR)), TARGET, 1.0, 1.0, 1.0
    ).linear()
    turned = rotations.from_rotation_vector(jnp.array([0.1, -0.3, 0.05]))
    seen = SpacecraftMeasurement(turned, jnp.zeros(3), jnp.zeros(3), jnp.ones(3, bool))
    torque, wanted = (np.asarray(each((), seen)[1].torque) for each in (law, free))
    assert np.max(np.abs(torque)) == pytest.approx(1e-3)
    np.testing.assert_allclose(torque / wanted, 1e-3 / np.max(np.abs(wanted)), rtol=1e-12)


def test_after_a_missing_sample_the_estimate_goes_on_unchanged():
    memory = ExternalTorqueMemory.start(PERIOD)
    for k in range(200):
        memory = memory.updated(TARGET, PERIOD * k * TORQUE, 5.0)
    np.testing.assert_allclose(memory.torque, TORQUE * (1.0 - (5.0 / 5.25) ** 199), rtol=1e-9)
    after = memory.missed().updated(TARGET, PERIOD * 210 * TORQUE, 5.0)
    np.testing.assert_array_equal(after.torque, memory.torque)
    after = after.updated(TARGET, PERIOD * 211 * TORQUE, 5.0)
    np.testing.assert_allclose(after.torque, TORQUE * (1.0 - (5.0 / 5.25) ** 200), rtol=1e-9)
