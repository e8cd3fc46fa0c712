"""Two wheels and a paddle: conservation of momentum, the closed form of a turn, stops, fallback."""

import dataclasses

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import PaddleRecovery
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import from_rotation_vector, to_body
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import (
    AddedSensors,
    Gyrostat,
    PaddleAngle,
    PaddleGyrostat,
    Spacecraft,
    SpacecraftSensor,
    WheelTorqueCommand,
)
from gyrostat.wheel import WheelArray

PADDLE, LIMIT = 0.6, np.deg2rad(150.0)
INERTIA = np.array([[12.0, 0.3, -0.2], [0.3, 11.0, 0.4], [-0.2, 0.4, 13.0]])
AXES = np.array([[1.0, 0.0, 0.1], [0.0, 1.0, -0.2], [0.0, 0.0, np.sqrt(0.95)]])
WHEELS = WheelArray(
    AXES, np.array([0.01, 0.01, PADDLE]), np.full(3, 0.3), np.array([6.0, 6.0, 0.1 * PADDLE])
)
CRAFT = Spacecraft(INERTIA, WHEELS)
PLANT = PaddleGyrostat(Gyrostat(CRAFT), np.array([np.inf, np.inf, LIMIT]))
SENSOR = AddedSensors(SpacecraftSensor(PLANT), {"paddle_angle": PaddleAngle(2)})
HOME = np.array([1.0, 0.0, 0.0, 0.0])
LAW = PaddleRecovery.plan(CRAFT, paddle=2, angle_limit=LIMIT, target=HOME)
TURNS = np.deg2rad([[0.0, 0.0, 4.0], [2.0, -1.0, -3.0], [5.0, 30.0, -20.0]])


@pytest.fixture(scope="module")
def flights():
    starts = [PLANT.start(attitude=from_rotation_vector(jnp.asarray(turn))) for turn in TURNS]
    return simulate(
        PLANT,
        LAW,
        SENSOR,
        start=stack(starts),
        duration=80.0,
        control_period=0.1,
        runs=len(TURNS),
        engine="native",
    )


@eqx.filter_jit
def step(plant, state, command, duration):
    return plant(state, command, jnp.asarray(0.0), duration)


def angles(flights):
    return 2.0 * np.arcsin(np.linalg.norm(flights.attitude.values[..., 1:], axis=-1))


def test_it_comes_to_rest_on_target(flights):
    assert np.all(flights.status == 0)
    assert np.all(angles(flights)[:, -50:] < np.deg2rad(0.01))
    assert np.all(np.abs(flights.rate[:, -50:]) < 1e-4)


def test_the_paddle_ends_where_momentum_says(flights):
    """A diag(I) W = -J w along the way: one turn about a fixed axis, J with all that is locked."""
    locked = INERTIA + AXES * np.asarray(WHEELS.inertia) @ AXES.T
    expected = np.linalg.solve(AXES, (locked @ TURNS.T))[2] / PADDLE
    ends = flights.wheel_angle.values[:2, -1, 2]
    # the friction-free paddle in use follows the closed form to the size of the wheels' last error
    assert np.allclose(ends, expected[:2], rtol=2e-3)
    assert np.allclose(flights.paddle_end.values[:, 0], expected, rtol=1e-9)
    assert np.all(flights.by_paddle.values[:2] == 1.0)
    assert np.all(flights.momentum == 0.0)


def test_beyond_the_range_the_wheels_sweep_and_the_paddle_removes_the_rest(flights):
    used = flights.by_paddle.values[2]
    assert np.abs(flights.paddle_end.values[2, 0]) > LIMIT
    assert used[0] == 0.0
    assert used[-1] == 1.0
    begun = np.argmax(used)
    assert np.all(used[begun:] == 1.0)
    # held through the sweep, which turns the body at up to 0.5 rad/s
    assert np.max(np.abs(flights.wheel_angle.values[2, :begun, 2])) < 0.5


def test_a_principal_axis_turns_by_the_share_of_the_paddle():
    """-I / (I + J) times the angle of the paddle, from rest to rest under opposite torques."""
    own = dataclasses.replace(WHEELS, axes=np.eye(3))
    plant = PaddleGyrostat(
        Gyrostat(Spacecraft(np.diag([12.0, 11.0, 13.0]), own)), np.array([np.inf, np.inf, LIMIT])
    )
    state = plant.start()
    for torque in (0.01, -0.01):
        command = WheelTorqueCommand(jnp.array([0.0, 0.0, torque]))
        state, fine = step(plant, state, command, jnp.asarray(5.0))
        assert fine
    turned = 2.0 * np.arcsin(state.attitude[3])
    moved = 0.01 * 5.0**2 * (1.0 / PADDLE + 1.0 / 13.0)
    assert state.wheel_angle[2] == pytest.approx(moved, rel=1e-9)
    assert turned == pytest.approx(-moved * PADDLE / (PADDLE + 13.0), rel=1e-9)
    assert np.allclose(state.wheel_speed, 0.0, atol=1e-12)


def test_a_stop_gives_the_momentum_of_the_paddle_to_the_body():
    start = PLANT.start(
        rate=(0.01, -0.02, 0.03),
        wheel_speed=(5.0, -4.0, 0.09),
        wheel_angle=(0.0, 0.0, LIMIT - 0.01),
    )
    none = WheelTorqueCommand(jnp.zeros(3))
    state, _ = step(PLANT, start, none, jnp.asarray(0.5))
    assert state.wheel_angle[2] == LIMIT
    assert state.wheel_speed[2] == 0.0
    assert np.array_equal(state.momentum, start.momentum)
    locked = INERTIA + AXES * np.asarray(WHEELS.inertia) @ AXES.T
    held = AXES @ (np.asarray(WHEELS.inertia) * np.asarray(state.wheel_speed))
    body = np.asarray(to_body(state.attitude, start.momentum))
    assert np.allclose(PLANT.rate(state), np.linalg.solve(locked, body - held), rtol=1e-12)
    # away from the stop it moves freely
    back = state._replace(wheel_speed=jnp.array([5.0, -4.0, -0.05]))
    assert step(PLANT, back, none, jnp.asarray(0.5))[0].wheel_angle[2] < LIMIT


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PaddleRecovery.plan(CRAFT, paddle=3, angle_limit=1.0, target=HOME), "found 3 of"),
        (lambda: dataclasses.replace(LAW, angle_limit=0.0).check(), "paddle angle limit: found 0"),
        (lambda: dataclasses.replace(LAW, share=1.5).check(), "paddle share"),
        (lambda: LAW.check_period(0.6), "paddle holding gain: found 2.0 1/s at a control"),
        (lambda: PaddleGyrostat(Gyrostat(CRAFT), np.ones(2)).check(), "angle limit: found shape"),
        (lambda: PLANT.check_state(PLANT.start(wheel_angle=3.0)), "wheel_angle: found"),
        (
            lambda: simulate(
                PLANT,
                LAW,
                SpacecraftSensor(PLANT),
                start=PLANT.start(),
                duration=1.0,
                control_period=0.1,
            ),
            "expected the field paddle_angle too",
        ),
    ],
)
def test_bad_input_is_refused(make, words):
    with pytest.raises(InputError, match=words):
        make()
