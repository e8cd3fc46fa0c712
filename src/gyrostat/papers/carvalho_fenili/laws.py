"""The paper's two laws: the linear quadratic regulator, and the state-dependent Riccati equation.

Both know nothing of a failure: they go on commanding all three torques.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat._jax import jnp
from gyrostat.body import BodyTorqueCommand, EulerMeasurement, EulerState
from gyrostat.body.rotations import Vector
from gyrostat.control.riccati import riccati
from gyrostat.friction import Scalar
from gyrostat.papers.carvalho_fenili.printed import (
    CASES,
    INERTIA,
    INPUT_WEIGHT,
    STATE_WEIGHT,
)

DOUBLINGS = 12
"""Of the Riccati solver: enough down to sin(theta) = 0.005, where the closed loop is stiffest."""
LARGEST_RESIDUAL = 1e-8
"""Of a solution that is flown, relative."""

Law = Callable[[EulerState], Vector]


def regulated(state: EulerState) -> Float[Array, "6"]:
    """The state x of (14) with theta - pi/2 for theta.

    The columns of theta, phi and psi in A(x) are zero, so that this is exact; with theta itself the
    law would drive the body into the singularity at theta = 0.
    """
    return jnp.stack(
        [
            state.theta - 0.5 * jnp.pi,
            state.theta_rate,
            state.phi,
            state.phi_rate,
            state.psi,
            state.psi_rate,
        ]
    )


def factorisation(state: EulerState) -> tuple[Float[Array, "6 6"], Float[Array, "6 3"]]:
    """A(x) and B(x) of (17) and (18), their misprints corrected: A x + B u is the plant's field."""
    sine, cosine = jnp.sin(state.theta), jnp.cos(state.theta)
    across, along = jnp.sin(state.psi), jnp.cos(state.psi)
    zero, one = jnp.zeros_like(sine), jnp.ones_like(sine)
    theta, psi = state.theta_rate, state.psi_rate
    dynamics = [
        [zero, one, zero, zero, zero, zero],
        [zero, zero, zero, -psi * sine, zero, zero],
        [zero, zero, zero, one, zero, zero],
        [zero, zero, zero, -theta * cosine / sine, zero, theta / sine],
        [zero, zero, zero, zero, zero, one],
        [zero, -psi * cosine / sine, zero, theta / sine, zero, zero],
    ]
    torques = [
        [zero, zero, zero],
        [along, -across, zero],
        [zero, zero, zero],
        [across / sine, along / sine, zero],
        [zero, zero, zero],
        [-across * cosine / sine, -along * cosine / sine, one],
    ]
    return jnp.array(dynamics), jnp.array(torques) / INERTIA


def linearised() -> tuple[np.ndarray, np.ndarray]:
    """A and B of (16) at (15), B(2,4) corrected to 0."""
    level = EulerState(0.5 * jnp.pi, *jnp.zeros(5))
    dynamics, torques = (np.asarray(part).copy() for part in factorisation(level))
    # of cos(pi/2) rounding is left
    torques[np.abs(torques) < 1e-15] = 0.0
    return dynamics, torques


def gain() -> np.ndarray:
    """(3, 6) gain of the linear quadratic regulator, N·m/rad and N·m·s/rad: M = -K x."""
    solution = riccati(*map(jnp.asarray, (*linearised(), STATE_WEIGHT, INPUT_WEIGHT)))
    return np.asarray(solution.gain)


def rank(case: str) -> int:
    """Controllability rank of the linearised plant without the torques that failed."""
    dynamics, torques = linearised()
    left = np.delete(torques, list(CASES[case]), axis=1)
    powers = [np.linalg.matrix_power(dynamics, k) @ left for k in range(6)]
    return int(np.linalg.matrix_rank(np.hstack(powers)))


class LinearQuadratic(eqx.Module):
    """M = -K x.

    Attributes:
        gain: K, (3, 6).
    """

    gain: Float[Array, "3 6"]

    def __call__(self, state: EulerState) -> Vector:
        """Torque that is commanded, N·m."""
        return -self.gain @ regulated(state)


class StateDependent(eqx.Module):
    """M = -R^-1 B(x)' P(x) x of (11) and (12).

    Attributes:
        state_weight: Q, (6, 6).
        input_weight: R, (3, 3).
    """

    state_weight: Float[Array, "6 6"] = eqx.field(default_factory=lambda: STATE_WEIGHT)
    input_weight: Float[Array, "3 3"] = eqx.field(default_factory=lambda: INPUT_WEIGHT)

    def __call__(self, state: EulerState) -> Vector:
        """Torque that is commanded, N·m; NaN where the equation has no solution."""
        weights = jnp.asarray(self.state_weight), jnp.asarray(self.input_weight)
        solution = riccati(*factorisation(state), *weights, doublings=DOUBLINGS)
        torque = -solution.gain @ regulated(state)
        # near the singularity the solver's other verdict asks for more doublings than P needs
        return jnp.where(solution.residual <= LARGEST_RESIDUAL, torque, jnp.nan)


class TorqueOnAngles(eqx.Module):
    """A law of the paper as a sampled controller, its torque held through the period.

    Attributes:
        law: state -> torque.
    """

    law: Any

    def start(self, period: Scalar) -> tuple[()]:
        """It has no memory."""
        return ()

    def __call__(
        self, memory: tuple[()], measurement: EulerMeasurement
    ) -> tuple[tuple[()], BodyTorqueCommand]:
        """Command."""
        state = EulerState(*measurement.angles, *measurement.rates)
        return memory, BodyTorqueCommand(self.law(state))


class Laws(NamedTuple):
    """Both.

    Attributes:
        lqr: linear.
        sdre: state-dependent.
    """

    lqr: LinearQuadratic
    sdre: StateDependent


def laws() -> Laws:
    """With the paper's weights."""
    return Laws(LinearQuadratic(jnp.asarray(gain())), StateDependent())
