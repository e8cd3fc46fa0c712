"""Whirl modes of a wheel: gyroscopic splitting, and the energy balance."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from gyrostat.spacecraft.wheel_modes import (
    rocking_gain,
    rocking_matrix,
    translation_gain,
    whirl_frequencies,
)

NATURAL, DAMPING, RATIO = 500.0, 0.02, 1.8
SPEEDS = [0.0, 60.0, 314.0, 628.0]


@pytest.mark.parametrize("speed", SPEEDS)
def test_the_gyroscopic_term_does_no_work(speed):
    """Energy q'^2/2 + n^2 q^2/2 is constant without damping, whatever the speed."""
    matrix = rocking_matrix(speed, NATURAL, 0.0, RATIO)
    energy = np.diag([NATURAL**2, NATURAL**2, 1.0, 1.0])
    balance = energy @ matrix
    np.testing.assert_allclose(balance + balance.T, 0.0, atol=1e-9 * NATURAL**3)
    state = np.array([1e-3, -2e-3, 0.7, 0.1])
    step = expm(matrix * 1e-3)
    start = state @ energy @ state
    for _ in range(1000):
        state = step @ state
    assert state @ energy @ state == pytest.approx(start, rel=1e-9)


@pytest.mark.parametrize("speed", SPEEDS)
def test_damping_takes_exactly_the_energy_that_the_motion_loses(speed):
    matrix = rocking_matrix(speed, NATURAL, DAMPING, RATIO)
    energy = np.diag([NATURAL**2, NATURAL**2, 1.0, 1.0])

    def motion(_, x):
        rate = x[2:4]
        return [*(matrix @ x[:4]), 2.0 * DAMPING * NATURAL * (rate @ rate)]

    start = np.array([1e-3, -2e-3, 0.7, 0.1, 0.0])
    end = solve_ivp(motion, (0.0, 0.05), start, rtol=1e-11, atol=1e-15).y[:, -1]
    lost = 0.5 * (start[:4] @ energy @ start[:4] - end[:4] @ energy @ end[:4])
    assert end[4] == pytest.approx(lost, rel=1e-8)
    assert lost > 0.0


@pytest.mark.parametrize("speed", SPEEDS)
def test_whirl_frequencies_are_the_eigenvalues_of_the_equation_of_motion(speed):
    eigenvalues = np.linalg.eigvals(rocking_matrix(speed, NATURAL, 0.0, RATIO))
    forward, backward = whirl_frequencies(speed, NATURAL, RATIO)
    expected = np.sort([-forward, -backward, backward, forward])
    np.testing.assert_allclose(np.sort(eigenvalues.imag), expected, rtol=1e-7)
    assert forward * backward == pytest.approx(NATURAL**2)
    assert forward - backward == pytest.approx(RATIO * speed)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("speed", SPEEDS)
def test_the_gain_is_the_transmitted_torque_of_the_equation_of_motion(speed, sense):
    """A torque exp(iwt) in real coordinates, solved as a linear system of the state matrix."""
    matrix = rocking_matrix(speed, NATURAL, DAMPING, RATIO)
    for frequency in (40.0, 300.0, 499.0, 900.0):
        w = sense * frequency
        # real part of (u, v) = q exp(iwt) with q = 1: u = cos, v = sin
        torque = np.array([0.0, 0.0, 1.0, -1j])
        x = np.linalg.solve(1j * w * np.eye(4) - matrix, torque)
        transmitted = NATURAL**2 * x[0] + 2.0 * DAMPING * NATURAL * x[2]
        gain = rocking_gain(w, speed, NATURAL, DAMPING, RATIO)
        assert complex(*gain) == pytest.approx(transmitted, rel=1e-10)
        rate = x[2:4]
        supplied = 0.5 * (np.conj(rate) @ torque[2:]).real
        dissipated = DAMPING * NATURAL * np.sum(np.abs(rate) ** 2)
        assert supplied == pytest.approx(dissipated, rel=1e-10)


def test_without_a_gyroscopic_term_a_tilt_is_transmitted_as_a_displacement():
    w = np.linspace(1.0, 2000.0, 50)
    rocking = rocking_gain(w, 300.0, NATURAL, DAMPING, 0.0)
    np.testing.assert_allclose(rocking, translation_gain(w, NATURAL, DAMPING), rtol=1e-14)
