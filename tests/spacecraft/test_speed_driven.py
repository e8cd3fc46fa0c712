"""A spacecraft driven by wheel speeds, against equations written apart."""

import equinox as eqx
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import check_parts
from gyrostat.spacecraft import (
    Gyrostat,
    SinusoidalMomentum,
    Spacecraft,
    SpeedDrivenSpacecraft,
    WheelSpeedCommand,
    unit_quaternion,
)
from gyrostat.wheel import WheelArray

AXES = np.array([[1.0, 0.2, 0.0], [0.0, 0.9, 0.6]])
AXES = (AXES / np.linalg.norm(AXES, axis=1)[:, None]).T
ROTORS = np.array([0.45, 0.3])
TOTAL = np.array([[40.0, 1.0, -0.5], [1.0, 50.0, 2.0], [-0.5, 2.0, 60.0]])
AMPLITUDE, FREQUENCY, PHASE = np.array([0.5, 0.3, -0.4]), 0.01, np.array([0.3, 1.2, -2.0])
OFFSET = np.array([0.1, -0.2, 0.05])
START = np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7])


def spacecraft(**limits):
    inertia = jnp.asarray(TOTAL - (AXES * ROTORS) @ AXES.T)
    wheels = WheelArray(axes=jnp.asarray(AXES), inertia=jnp.asarray(ROTORS), **limits)
    return Spacecraft(inertia=inertia, wheels=wheels)


def plant(**limits):
    momentum = SinusoidalMomentum(
        jnp.asarray(AMPLITUDE), FREQUENCY, jnp.asarray(PHASE), jnp.asarray(OFFSET)
    )
    return SpeedDrivenSpacecraft(spacecraft(**limits), momentum)


def momentum_at(time):
    return OFFSET + AMPLITUDE * np.sin(2.0 * np.pi * FREQUENCY * time + PHASE)


def turned(q):
    """Direction cosines by Rodrigues' formula, from the vector part."""
    v = np.array([[0.0, -q[3], q[2]], [q[3], 0.0, -q[1]], [-q[2], q[1], 0.0]])
    return np.eye(3) + 2.0 * q[0] * v + 2.0 * v @ v


def rate(time, q, speed):
    """(2) of the paper."""
    return np.linalg.solve(TOTAL, turned(q).T @ momentum_at(time) - AXES @ (ROTORS * speed))


def slope(time, q, speed):
    """(4) of the paper."""
    matrix = np.array(
        [[-q[1], -q[2], -q[3]], [q[0], -q[3], q[2]], [q[3], q[0], -q[1]], [-q[2], q[1], q[0]]]
    )
    return 0.5 * matrix @ rate(time, q, speed)


@eqx.filter_jit
def carried(body, state, command, time, duration):
    state, _ = body(state, command, time, duration)
    return state, body.rate(state), body.record(state, command).rate


def flown(body, speeds, period, parts=1):
    """States, rates and the rates while the next command acts, at the ends of the periods."""
    state, rows = body.start(attitude=START), []
    for k, speed in enumerate(speeds):
        command = WheelSpeedCommand(jnp.asarray(speed))
        for part in range(parts):
            time = jnp.asarray(period * (k + part / parts))
            state, *rates = carried(body, state, command, time, jnp.asarray(period / parts))
        rows.append((state, *rates))
    return rows


SPEEDS = np.array([[0.3, -0.2], [-0.4, 0.5], [0.1, 0.6], [0.0, -0.7], [0.2, 0.2], [0.0, 0.0]])


def test_motion_is_that_of_an_adaptive_integrator():
    run = flown(plant(), SPEEDS, 4.0, parts=80)
    q = START
    for k, speed in enumerate(SPEEDS):
        span = (4.0 * k, 4.0 * (k + 1))
        found = solve_ivp(slope, span, q, args=(speed,), method="DOP853", rtol=1e-12, atol=1e-13)
        q = found.y[:, -1]
        np.testing.assert_allclose(run[k][0].attitude, q, rtol=0.0, atol=2e-10)
    assert np.linalg.norm(q - START) > 0.1


def test_the_step_is_of_fourth_order():
    ends = [np.asarray(flown(plant(), SPEEDS, 4.0, parts)[-1][0].attitude) for parts in (32, 2, 1)]
    fine, coarse = (np.linalg.norm(end - ends[0]) for end in ends[1:])
    assert coarse > 1e-9
    assert 3.5 < np.log2(coarse / fine) < 5.5


def test_body_and_wheels_have_the_momentum_that_is_given():
    for k, (state, rate, acting) in enumerate(flown(plant(), SPEEDS, 2.0)):
        body = TOTAL @ rate + AXES @ (ROTORS * SPEEDS[k])
        expected = momentum_at(2.0 * (k + 1))
        np.testing.assert_allclose(turned(state.attitude) @ body, expected, atol=1e-12)
        np.testing.assert_allclose(state.momentum, expected, atol=1e-14)
        # without a limit the wheels are at the command already
        np.testing.assert_allclose(acting, rate, atol=1e-15)


def test_the_rate_is_that_of_the_gyrostat_in_the_same_state():
    gyrostat = Gyrostat(spacecraft())
    state = gyrostat.start(attitude=START, rate=[0.01, -0.02, 0.03], wheel_speed=[3.0, -5.0])
    np.testing.assert_allclose(plant().rate(state), [0.01, -0.02, 0.03], atol=1e-15)


def test_wheels_are_as_fast_as_their_torque_and_no_faster_than_their_momentum():
    body = plant(torque_limit=jnp.full(2, 0.1), momentum_limit=jnp.array([9.0, 0.06]))
    run = flown(body, np.tile([0.3, 0.7], (9, 1)), 0.5, parts=2)
    speed = np.stack([np.asarray(state.wheel_speed) for state, *_ in run])
    gained = 0.1 * 0.5 / ROTORS
    np.testing.assert_allclose(speed[0], gained, rtol=1e-12)
    np.testing.assert_allclose(speed[-1], [0.3, 0.06 / 0.3], rtol=1e-12)
    assert np.all(np.diff(speed, axis=0) <= gained + 1e-12)
    found = solve_ivp(
        lambda time, q: slope(time, q, 0.1 * time / ROTORS), (0.0, 0.5), START, rtol=1e-11
    )
    np.testing.assert_allclose(run[0][0].attitude, found.y[:, -1], atol=1e-10)


def test_a_quaternion_must_be_of_unit_length():
    near = START * (1.0 + 5e-7)
    assert np.linalg.norm(unit_quaternion("attitude", near)) == pytest.approx(1.0, abs=1e-15)
    with pytest.raises(InputError, match=r"attitude: found a quaternion of length 1\.00001"):
        plant().start(attitude=START * (1.0 + 1e-5))
    with pytest.raises(InputError, match="four finite numbers"):
        plant().start(attitude=[1.0, 0.0, 0.0])
    with pytest.raises(InputError, match="four finite numbers"):
        unit_quaternion("attitude", [1.0, np.nan, 0.0, 0.0])


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"frequency": -1.0}, "momentum frequency"),
        ({"phase": np.zeros(2)}, "momentum phase"),
        ({"amplitude": np.array([1.0, np.inf, 0.0])}, "momentum amplitude"),
    ],
)
def test_what_is_no_momentum_is_refused(changed, words):
    fields = {"amplitude": AMPLITUDE, "frequency": FREQUENCY, "phase": PHASE} | changed
    with pytest.raises(InputError, match=words):
        check_parts(SpeedDrivenSpacecraft(spacecraft(), SinusoidalMomentum(**fields)))
