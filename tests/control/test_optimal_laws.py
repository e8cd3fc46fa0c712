"""LQR and SDRE as laws, and what cannot be stabilised in words."""

from typing import NamedTuple

import equinox as eqx
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrostat.control import (
    EulerCube,
    LinearQuadratic,
    MRPBody,
    QuaternionBody,
    StateDependentRiccati,
    lqr,
    uncontrollable,
)
from gyrostat.control.design.factorisations import ERROR_STATES, EULER_STATES, HALVES
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import run, stack

WEIGHT = np.diag([50.0, 50.0, 10.0, 10.0, 10.0, 10.0])
EFFORT = np.diag([50.0, 100.0, 100.0])


def compiled(factorisation):
    """Factorisation as one program: a law evaluated by operations would compile each of them."""
    program = eqx.filter_jit(factorisation)
    return lambda *arguments: program(*arguments)


CUBE = compiled(EulerCube(12.0))
AT_REST = tuple(np.asarray(part) for part in CUBE(np.zeros(6)))
INERTIA = np.array([[9.0, 0.5, -1.0], [0.5, 12.0, 0.7], [-1.0, 0.7, 15.0]])


def without(*failed):
    dynamics, inputs = AT_REST
    return dynamics, np.delete(inputs, failed, axis=1)


@pytest.mark.parametrize(
    ("failed", "rank", "names"),
    [
        ((), 6, ()),
        ((0,), 4, ("rotation about body x",)),
        ((1,), 4, ("rotation about body y",)),
        ((2,), 4, ("rotation about body z",)),
        ((0, 2), 2, ("rotation about body x", "rotation about body z")),
        ((0, 1, 2), 0, tuple(f"rotation about body {axis}" for axis in "xyz")),
    ],
)
def test_what_failed_torques_leave(failed, rank, names):
    found = uncontrollable(*without(*failed), EULER_STATES)
    assert found.rank == rank
    assert found.names == names
    assert found.directions.shape == (6, 6 - rank)
    np.testing.assert_allclose(found.rates, 0.0, atol=1e-12)


@given(st.integers(0, 2**32 - 1), st.integers(0, 4))
@settings(max_examples=50)
def test_hidden_motions_are_found(seed, hidden):
    """A pair in any coordinates, of whose unreached modes one decays and the others do not."""
    random = np.random.default_rng(seed)
    rates = np.array([-0.5, 0.0, 0.3, 1.0])[:hidden]
    dynamics = random.normal(size=(6, 6))
    dynamics[6 - hidden :] = 0.0
    dynamics[6 - hidden :, 6 - hidden :] = np.diag(rates)
    inputs = random.normal(size=(6, 2))
    inputs[6 - hidden :] = 0.0
    frame = scipy.linalg.qr(random.normal(size=(6, 6)))[0]
    found = uncontrollable(frame @ dynamics @ frame.T, frame @ inputs)
    assert found.rank == 6 - hidden
    np.testing.assert_allclose(np.sort(found.rates.real), rates[1:], atol=1e-7)
    w = found.directions
    np.testing.assert_allclose(w.T @ frame @ inputs, 0.0, atol=1e-9)
    np.testing.assert_allclose(w.T @ w, np.eye(w.shape[1]), atol=1e-12)


def test_lqr_gains_of_the_paper():
    """Three double integrators: gains by hand."""
    gain = np.asarray(lqr(*AT_REST, WEIGHT, EFFORT, states=EULER_STATES).gain)
    expected = np.zeros((3, 6))
    for axis, (q, r) in enumerate([(50.0, 50.0), (10.0, 100.0), (10.0, 100.0)]):
        stiffness = np.sqrt(q / r)
        expected[axis, 2 * axis] = stiffness
        expected[axis, 2 * axis + 1] = np.sqrt(q / r + 24.0 * stiffness)
    np.testing.assert_allclose(gain, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((*AT_REST, WEIGHT[:5, :5], EFFORT), r"state weight Q: found shape \(5, 5\), expected"),
        ((*AT_REST, -WEIGHT, EFFORT), "state weight Q: found the eigenvalue -50, expected none"),
        ((*AT_REST, WEIGHT + np.eye(6, k=1), EFFORT), "Q: found a matrix that is not symmetric"),
        ((*AT_REST, WEIGHT * np.nan, EFFORT), "Q: found a value that is not finite"),
        ((*AT_REST, WEIGHT, np.diag([1.0, 0.0, 1.0])), "input weight R: found the eigenvalue 0"),
        ((AT_REST[0][:5], AT_REST[1], WEIGHT, EFFORT), r"A and B: found shapes \(5, 6\)"),
        ((*without(1), WEIGHT, EFFORT[:2, :2]), "no input controls: rotation about body y "),
        ((*without(0, 1, 2), WEIGHT, np.zeros((0, 0))), "no input controls: rotation about body x"),
        ((-np.eye(6), np.zeros((6, 0)), WEIGHT, np.zeros((0, 0))), r"R: found shape \(0, 0\)"),
        ((*AT_REST, np.diag([1.0, 1, 0, 1, 1, 1]), EFFORT), "no cost in Q on: .*body y"),
    ],
)
def test_refusals(arguments, message):
    with pytest.raises(InputError, match=message):
        lqr(*arguments, states=EULER_STATES)


def test_a_motion_spread_over_many_states_is_named():
    """A drift in equal shares of 16 states: none of them has a large one."""
    shares = np.full(16, 0.25)
    rest = scipy.linalg.null_space(shares[None])
    found = uncontrollable(-rest @ rest.T, rest)
    np.testing.assert_allclose(np.abs(found.directions[:, 0]), shares)
    assert len(found.names) == 16


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ((50.0, EFFORT), r"state weight Q: found shape \(\), expected a square matrix"),
        ((WEIGHT, -EFFORT), "input weight R: found the eigenvalue"),
        ((np.stack([WEIGHT, -WEIGHT]), EFFORT), "state weight Q: found the eigenvalue"),
    ],
)
def test_weights_of_a_state_dependent_law(weights, message):
    with pytest.raises(InputError, match=message):
        StateDependentRiccati(EulerCube(12.0), *weights).check()


def test_weights_that_do_not_fit_the_factorisation():
    law = StateDependentRiccati(EulerCube(12.0), WEIGHT[:5, :5], EFFORT)
    law.check()
    with pytest.raises(InputError, match=r"Q: found shape \(5, 5\), expected \(6, 6\)"):
        law.command(np.zeros(6))


def test_a_batch_of_laws_is_none_to_refuse():
    """Weights that differ from run to run."""
    laws = [StateDependentRiccati(EulerCube(12.0), k * WEIGHT, EFFORT) for k in (1.0, 2.0, 3.0)]
    stack(laws).check()
    stack([LinearQuadratic(k * np.ones((3, 6))) for k in (1.0, 2.0)]).check()


@pytest.mark.parametrize("gain", [3.0, np.ones(6), np.full((3, 6), np.nan)])
def test_a_gain_that_is_none(gain):
    with pytest.raises(InputError, match="gain: found shape"):
        LinearQuadratic(gain).check()


def test_weights_in_mixed_units_are_no_refusal():
    weight = np.diag([1e9, 1e9, 1e-9, 1e-9, 1.0, 1.0])
    assert lqr(*AT_REST, weight, EFFORT).valid
    half = np.ones((1, 6))
    assert lqr(*AT_REST, half.T @ half + np.diag([0, 0, 1e-3, 0, 1e-3, 0]), EFFORT).valid


class _Seen(NamedTuple):
    state: object


class _Sensor:
    def start(self, state, period):
        return ()

    def __call__(self, memory, state, key):
        return memory, _Seen(state)


class _Plant:
    """A factorised plant, stepped by RK4."""

    def __init__(self, factorisation):
        self.factorisation = factorisation

    def __call__(self, state, command, time, duration):
        def rate(x):
            dynamics, inputs = self.factorisation(x)
            return dynamics @ x + inputs @ command.torque

        a = rate(state)
        b = rate(state + 0.5 * duration * a)
        c = rate(state + 0.5 * duration * b)
        d = rate(state + duration * c)
        return state + duration / 6.0 * (a + 2.0 * b + 2.0 * c + d), jnp.array(True)

    def diverged(self, state):
        return jnp.array(False)

    def record(self, state, command):
        return ()


@pytest.mark.parametrize(
    "factorisation",
    [EulerCube(12.0), EulerCube(12.0, HALVES), MRPBody(INERTIA), QuaternionBody(INERTIA, 0.5)],
    ids=["Euler as printed", "Euler in halves", "MRP", "quaternion"],
)
def test_laws_bring_the_body_to_rest(factorisation):
    start = np.array([-0.7, 0.04, 0.5, 0.04, 0.4, 0.04])
    if not isinstance(factorisation, EulerCube):
        start = np.array([0.3, -0.4, 0.5, 0.04, 0.04, -0.04])
    law = StateDependentRiccati(factorisation, WEIGHT, EFFORT, doublings=9)
    law.check()
    plant, key = _Plant(factorisation), jax.random.key(0)
    fly = jax.jit(lambda x: run(plant, law, _Sensor(), x, key, 0.5, count=400))
    found = fly(start)
    assert np.all(found.command.valid)
    assert np.max(found.command.residual) < 1e-13
    assert np.linalg.norm(found.state[-1]) < 1e-4 * np.linalg.norm(start)
    # near the target the linear law is the same law
    dynamics, inputs = eqx.filter_jit(factorisation)(np.zeros(6))
    regulator = LinearQuadratic(lqr(dynamics, inputs, WEIGHT, EFFORT, states=ERROR_STATES).gain)
    near = 1e-5 * start
    _, linear = regulator((), _Seen(near))
    first = fly(near).command.torque[0]
    np.testing.assert_allclose(first, linear.torque, rtol=1e-4, atol=1e-9)


def test_the_law_is_that_of_scipy():
    state = np.array([-0.7, 0.04, 0.5, 0.14, 0.4, -0.24])
    dynamics, inputs = CUBE(state)
    cost = scipy.linalg.solve_continuous_are(dynamics, inputs, WEIGHT, EFFORT)
    law = StateDependentRiccati(CUBE, WEIGHT, EFFORT)
    expected = -np.linalg.solve(EFFORT, np.asarray(inputs).T @ cost @ state)
    _, command = law(law.start(0.1), _Seen(state))
    np.testing.assert_allclose(command.torque, expected, rtol=1e-10)


def test_momentum_of_wheels_reaches_the_law():
    """A pitching momentum couples the axes, and the law knows it."""
    law = StateDependentRiccati(compiled(MRPBody(INERTIA)), np.eye(6), np.eye(3))
    state = np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.01])
    still = law.command(state).torque
    wheels = law.command(state, np.array([0.0, 3.0, 0.0])).torque
    assert np.linalg.norm(wheels - still) > 0.01 * np.linalg.norm(still)


def test_an_impossible_turn_is_said():
    """Half a turn away in quaternion coordinates: one direction is out of reach."""
    law = StateDependentRiccati(compiled(QuaternionBody(INERTIA)), np.eye(6), np.eye(3))
    assert not law.command(np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])).valid
    euler = StateDependentRiccati(CUBE, WEIGHT, EFFORT)
    lost = StateDependentRiccati(
        lambda x: (CUBE(x)[0], CUBE(x)[1] * np.array([1.0, 0.0, 1.0])),
        WEIGHT,
        EFFORT,
    )
    assert euler.command(np.zeros(6)).valid
    assert not lost.command(np.zeros(6)).valid


def test_the_law_refuses_weights():
    with pytest.raises(InputError, match="input weight R"):
        StateDependentRiccati(EulerCube(12.0), WEIGHT, 0.0 * EFFORT).check()
    with pytest.raises(InputError, match="inertia"):
        StateDependentRiccati(EulerCube(-1.0), WEIGHT, EFFORT).check()
