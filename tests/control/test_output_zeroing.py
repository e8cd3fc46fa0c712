"""Output zeroing with two wheels: exact linearisation, the singular attitude, refusals."""

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import Integrators, ModelErrorCompensator, OutputZeroing
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import (
    GyrostatState,
    Spacecraft,
    SpacecraftMeasurement,
    SpeedDrivenSpacecraft,
)
from gyrostat.wheel import WheelArray

TOTAL = np.array([[400.0, 10.0, -5.0], [10.0, 500.0, 20.0], [-5.0, 20.0, 600.0]])
SQUARE, TILTED = np.eye(3)[:, :2], np.array([[1.0, 0.1, 0.2], [0.2, 1.0, -0.3]]).T


def spacecraft(axes=SQUARE, total=TOTAL):
    axes = axes / np.linalg.norm(axes, axis=0)
    wheels = WheelArray(axes=jnp.asarray(axes), inertia=jnp.full(axes.shape[1], 0.45))
    return Spacecraft(inertia=jnp.asarray(total - 0.45 * axes @ axes.T), wheels=wheels)


def law(axes=SQUARE, total=TOTAL, **fields):
    return OutputZeroing(spacecraft(axes, total), jnp.array([0.01, 0.02]), **fields)


def measured(body, attitude, momentum, speed):
    plant = SpeedDrivenSpacecraft(body, lambda time: momentum)
    state = GyrostatState(jnp.asarray(attitude), jnp.asarray(momentum), jnp.asarray(speed))
    return SpacecraftMeasurement(
        state.attitude, plant.rate(state), state.wheel_speed, jnp.ones(2, dtype=bool)
    )


@eqx.filter_jit
def rate_of_outputs(controller, body, measurement, momentum):
    """Rate of q1 and q2 while the command acts, by the plant's own body rate."""
    _, command = controller(controller.start(0.1), measurement)
    plant = SpeedDrivenSpacecraft(body, lambda time: momentum)
    state = GyrostatState(measurement.attitude, momentum, command.speed)
    return rotations.rate_of_quaternion(state.attitude, plant.rate(state))[1:3], command


@pytest.mark.parametrize("axes", [SQUARE, TILTED], ids=["square", "tilted"])
@pytest.mark.parametrize("momentum_measured", [False, True])
def test_outputs_are_linear_whatever_the_attitude(axes, momentum_measured):
    random = np.random.default_rng(3)
    for _ in range(10):
        attitude = random.standard_normal(4) * [1.0, 0.5, 0.5, 1.0]
        attitude /= np.linalg.norm(attitude)
        momentum = random.standard_normal(3)
        body = spacecraft(axes)
        known = np.zeros(3) if momentum_measured else momentum
        controller = law(
            axes, total_momentum=jnp.asarray(known), momentum_measured=momentum_measured
        )
        measurement = measured(body, attitude, momentum, random.standard_normal(2))
        found, command = rate_of_outputs(controller, body, measurement, jnp.asarray(momentum))
        np.testing.assert_allclose(found, -attitude[1:3] * [0.01, 0.02], atol=1e-14)
        assert not bool(command.singular)


def test_what_is_unknown_of_the_momentum_is_all_that_disturbs_the_outputs():
    attitude = np.array([0.8, 0.2, -0.4, 0.4])
    momentum = np.array([0.3, -0.1, 0.2])
    body, controller = spacecraft(), law()
    measurement = measured(body, attitude, momentum, np.zeros(2))
    found, _ = rate_of_outputs(controller, body, measurement, jnp.asarray(momentum))
    q0, q1, q2, q3 = attitude
    rows = 0.5 * np.array([[q0, -q3, q2], [q3, q0, -q1]])
    drift = rows @ np.linalg.solve(TOTAL, rotations.rotation_matrix(attitude).T @ momentum)
    np.testing.assert_allclose(found + attitude[1:3] * [0.01, 0.02], drift, atol=1e-15)


@jax.jit
def flown(attitude):
    """Attitudes, whether the law is singular there, and speeds, from an attitude on."""
    body, controller = spacecraft(), law()
    plant = SpeedDrivenSpacecraft(body, lambda time: jnp.zeros(3))
    state = GyrostatState(attitude, jnp.zeros(3), jnp.zeros(2))

    def step(carried, _):
        state, memory = carried
        memory, command = controller(
            memory, measured(body, state.attitude, jnp.zeros(3), [0.0, 0.0])
        )
        after, _ = plant(state, command, 0.0, 0.1)
        return (after, memory), (state.attitude, command.singular, command.speed)

    return jax.lax.scan(step, (state, controller.start(0.1)), None, length=6000)[1]


@pytest.mark.parametrize("axis", [(1.0, 0.0), (0.6, -0.8)])
def test_half_a_turn_is_said_and_left(axis):
    way, singular, speed = map(np.asarray, flown(np.array([0.0, *axis, 0.0])))
    assert bool(singular[0])
    assert not bool(singular[-1])
    assert np.all(np.isfinite(speed))
    # no more than the nearest attitude where the law exists would ask for
    assert np.max(np.abs(speed)) < 1.1 * np.max(np.abs(speed[0]))
    assert np.hypot(*way[-1, 1:3]) < 0.02


def test_both_quaternions_of_an_attitude_are_the_same_to_a_compensator():
    controller = ModelErrorCompensator(law(), Integrators(), 0.3 * jnp.eye(2))
    body, momentum = spacecraft(), np.array([0.3, -0.1, 0.2])
    turned = [np.array([0.8, 0.2, -0.4, 0.4]), np.array([0.82, 0.19, -0.36, 0.4])]
    turned[1] /= np.linalg.norm(turned[1])

    @jax.jit
    def last_command(*attitudes):
        memory, command = controller.start(0.1), None
        for attitude in attitudes:
            memory, command = controller(memory, measured(body, attitude, momentum, np.zeros(2)))
        return command

    commands = [last_command(turned[0], sign * turned[1]) for sign in (1.0, -1.0)]
    np.testing.assert_allclose(commands[0].speed, commands[1].speed, rtol=1e-13)
    assert np.max(np.abs(commands[0].model_error)) > 1e-3


@pytest.mark.parametrize(
    ("axes", "words"),
    [
        (np.eye(3), "found 3 wheels, expected 2"),
        (np.array([[1.0, 0.0, 0.0], [-1.0, 1e-8, 0.0]]).T, "found parallel wheels"),
        (np.eye(3)[:, 1:], "about one axis only"),
    ],
)
def test_wheels_that_cannot_point_are_refused(axes, words):
    total = np.diag([400.0, 500.0, 600.0])
    law(total=total).check()
    with pytest.raises(InputError, match=words):
        law(axes, total).check()


def test_feedback_and_momentum_that_are_none_are_refused():
    with pytest.raises(InputError, match="output zeroing feedback"):
        OutputZeroing(spacecraft(), jnp.array([0.01, -0.01])).check()
    with pytest.raises(InputError, match="momentum that is not finite"):
        law(total_momentum=np.array([0.0, np.nan, 0.0])).check()
