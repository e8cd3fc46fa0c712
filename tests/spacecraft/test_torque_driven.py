"""The paper's plant against a quaternion integrated apart, closed forms and Euler's law."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import EulerAngles
from gyrostat.papers.carvalho_fenili.torque_driven import (
    BodyTorqueCommand,
    EulerSensor,
    EulerState,
    TorqueDrivenBody,
)
from gyrostat.simulation import Status, simulate

INERTIA = 12.0
BODY = TorqueDrivenBody(INERTIA)
ANGLES = EulerAngles(phi=0.7, theta=0.8, psi=0.6)
RATES = EulerAngles(phi=0.04, theta=0.05, psi=-0.03)
TORQUE = np.array([0.05, -0.02, 0.03])


class Constant:
    """Commands one torque."""

    def __init__(self, torque):
        self.torque = torque

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        return memory, BodyTorqueCommand(jnp.asarray(self.torque, float))


def flown(torque, duration, period, plant=BODY, angles=ANGLES, rates=RATES):
    return simulate(
        plant,
        Constant(torque),
        EulerSensor(),
        start=plant.start(angles, rates),
        duration=duration,
        control_period=period,
    )


def turn(phi, theta, psi):
    """R = R_z(phi) R_x(theta) R_z(psi)."""
    return Rotation.from_euler("ZXZ", [phi, theta, psi])


def first_rate():
    """Body rate at the start, by the sum of the three turns' own axes."""
    last = Rotation.from_euler("Z", 0.6).inv()
    middle = (Rotation.from_euler("X", 0.8) * Rotation.from_euler("Z", 0.6)).inv()
    return last.apply([0.05, 0.0, 0.0]) + middle.apply([0.0, 0.0, 0.04]) + [0.0, 0.0, -0.03]


def test_without_torque_the_body_turns_about_one_axis_for_ever():
    run = flown(np.zeros(3), 20.0, 0.01)
    rate = first_rate()
    np.testing.assert_allclose(run.body_rate, np.tile(rate, (2001, 1)), rtol=0.0, atol=1e-12)
    end = run.isel(time=-1)
    expected = turn(0.7, 0.8, 0.6) * Rotation.from_rotvec(20.0 * rate)
    apart = expected.inv() * turn(float(end.phi), float(end.theta), float(end.psi))
    assert apart.magnitude() < 1e-11


def test_a_torque_moves_it_as_it_moves_a_quaternion():
    def slope(time, state):
        q, w = state[:4], state[4:]
        vector = 0.5 * (q[0] * w + np.cross(q[1:], w))
        return np.concatenate([[-0.5 * q[1:] @ w], vector, TORQUE / INERTIA])

    start = turn(0.7, 0.8, 0.6).as_quat(scalar_first=True)
    exact = solve_ivp(
        slope, (0.0, 15.0), [*start, *first_rate()], "DOP853", rtol=1e-12, atol=1e-13
    ).y[:, -1]
    end = flown(TORQUE, 15.0, 0.01).isel(time=-1)
    expected = Rotation.from_quat(exact[:4], scalar_first=True)
    apart = expected.inv() * turn(float(end.phi), float(end.theta), float(end.psi))
    assert apart.magnitude() < 1e-9
    np.testing.assert_allclose(end.body_rate, exact[4:], rtol=0.0, atol=1e-10)


def test_the_step_is_of_fourth_order():
    start = BODY.start(ANGLES, EulerAngles(phi=0.4, theta=0.3, psi=-0.5))

    def spring(state):
        return -jnp.stack([state.theta - 1.0, 3.0 * state.phi_rate, state.psi])

    def end(count):
        def step(state, k):
            return BODY.carry(state, spring, k * 4.0 / count, 4.0 / count)[0], None

        return np.stack(jax.jit(lambda: jax.lax.scan(step, start, jnp.arange(count))[0])())

    exact = end(4096)
    coarse, fine = (np.max(np.abs(end(count) - exact)) for count in (16, 32))
    assert np.log2(coarse / fine) == pytest.approx(4.0, abs=0.4)


@given(
    st.floats(0.1, 3.0),
    st.lists(st.floats(-3.0, 3.0), min_size=5, max_size=5),
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
)
def test_the_body_rate_changes_by_the_torque_alone(theta, others, torque):
    state = EulerState(theta, *others)
    bend = BODY.accelerations(state, jnp.asarray(torque))
    slope = EulerState(*others[2:], bend.theta, bend.phi, bend.psi)
    fields = [jax.tree.map(jnp.asarray, x) for x in (state, slope)]
    _, change = jax.jvp(EulerState.body_rate, *([x] for x in fields))
    size = 1.0 + float(max(abs(np.asarray(slope))))
    np.testing.assert_allclose(change, np.asarray(torque) / INERTIA, rtol=0.0, atol=1e-12 * size)


def test_the_rate_about_a_failed_axis_stays_what_it_was():
    failing = TorqueDrivenBody(INERTIA, np.array([5.0, np.inf, 5.0]))
    rate = flown(TORQUE, 10.0, 0.01, failing).body_rate.values
    moved = first_rate() + np.array([5.0, 10.0, 5.0]) * TORQUE / INERTIA
    np.testing.assert_allclose(rate[-1], moved, rtol=0.0, atol=1e-10)
    np.testing.assert_allclose(rate[500:, [0, 2]], np.tile(moved[[0, 2]], (501, 1)), atol=1e-11)


def test_a_run_into_the_singularity_ends_with_its_time():
    towards = EulerAngles(phi=0.0, theta=-0.1, psi=0.0)
    run = flown(np.zeros(3), 20.0, 0.01, angles=EulerAngles(0.0, 1.0, 0.0), rates=towards)
    # theta = 1 - 0.1 t; its sine is 0.005 at 9.95 s
    assert float(run.valid_until) == pytest.approx(9.94, abs=0.011)
    assert int(run.status) in (Status.DIVERGED, Status.UNRESOLVED)
    assert np.isnan(run.theta.values[1000:]).all()


def test_a_step_too_long_for_a_passage_close_by_is_not_resolved():
    # the pole passed at about 0.018 rad with 2 rad/s
    rate = EulerAngles(phi=0.0, theta=-2.0, psi=0.0)
    angles = EulerAngles(0.0, 1.0, 0.0)
    off = BODY.start(angles, rate)._replace(phi_rate=0.05)
    coarse, fine = (
        simulate(
            BODY,
            Constant(np.zeros(3)),
            EulerSensor(),
            start=off,
            duration=1.0,
            control_period=0.1,
            step=step,
        )
        for step in (0.05, 1e-4)
    )
    assert int(coarse.status) == Status.UNRESOLVED
    assert int(fine.status) == Status.COMPLETE


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (TorqueDrivenBody(0.0), "body inertia: found 0, expected a finite value above 0 kg·m²"),
        (TorqueDrivenBody(np.nan), "body inertia: found nan"),
        (TorqueDrivenBody(1.0, np.array([1.0, -2.0, 3.0])), "failure time: found -2 s, expected 0"),
        (TorqueDrivenBody(1.0, np.array([1.0, np.nan, 3.0])), "failure time: found nan s"),
        (TorqueDrivenBody(1.0, np.zeros(2)), r"failure time: found shape \(2,\)"),
    ],
)
def test_what_is_no_such_body_is_refused(body, message):
    with pytest.raises(InputError, match=message):
        body.check()


@pytest.mark.parametrize("theta", [0.0, np.pi, 0.004, -1.0, np.nan])
def test_a_start_at_the_singularity_is_refused(theta):
    with pytest.raises(InputError, match="theta: found"):
        BODY.start(EulerAngles(phi=0.0, theta=theta, psi=0.0), RATES)


def test_rates_and_attitude_are_those_of_rotations():
    state = BODY.start(ANGLES, RATES)
    np.testing.assert_allclose(state.body_rate(), first_rate(), atol=1e-15)
    matrix = rotations.rotation_matrix(rotations.from_euler(ANGLES))
    np.testing.assert_allclose(matrix, turn(0.7, 0.8, 0.6).as_matrix(), atol=1e-15)
