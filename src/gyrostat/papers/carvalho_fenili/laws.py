"""The paper's two laws: linear quadratic regulator and state-dependent Riccati equation.

Neither is notified of a failure: they continue to command all three torques.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.control import EulerCube, StateDependentRiccati, lqr, uncontrollable
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.papers.carvalho_fenili.setup import CASES, INERTIA, INPUT_WEIGHT, STATE_WEIGHT
from gyrostat.papers.carvalho_fenili.torque_driven import EulerState

FEW, MANY = 5, 12
"""Doubling steps of the Riccati solver. The first value suffices far from the singularity; the
second down to sin(theta) = 0.005, where the closed loop is stiffest."""
SOLVED = 1e-13
"""Relative residual of a solution that further doubling steps do not improve."""
LARGEST_RESIDUAL = 1e-8
"""Largest relative residual of a solution that is used."""

Law = Callable[[EulerState], Vector3]


def regulated(state: EulerState) -> Float[Array, "6"]:
    """State x of (14) with theta - pi/2 in place of theta.

    This is exact, because the columns of theta, phi and psi in A(x) are zero. With theta itself the
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


FACTORISATION = EulerCube(INERTIA)
"""Eqs. (17) and (18) with their misprints corrected, as a function of `regulated`."""


def linearised() -> tuple[np.ndarray, np.ndarray]:
    """A, (6, 6), and B, (6, 3), of (16) at the state (15), with B(2,4) corrected to 0."""
    dynamics, torques = FACTORISATION(jnp.zeros(6))
    return np.asarray(dynamics), np.asarray(torques)


@cache  # each call would compile the design again
def gain() -> np.ndarray:
    """Gain of the linear quadratic regulator, (3, 6), N·m/rad and N·m·s/rad: M = -K x."""
    return np.asarray(lqr(*linearised(), STATE_WEIGHT, INPUT_WEIGHT).gain)


def rank(case: str) -> int:
    """Controllability rank of the linearised plant without the failed torques."""
    dynamics, torques = linearised()
    return uncontrollable(dynamics, np.delete(torques, list(CASES[case]), axis=1)).rank


class LinearQuadratic(eqx.Module):
    """M = -K x.

    Attributes:
        gain: Gain K, (3, 6).
    """

    gain: Float[Array, "3 6"]

    def __call__(self, state: EulerState) -> Vector3:
        """Commanded torque, N·m."""
        return -self.gain @ regulated(state)


def _solve(states: Array, state: Array, input: Array, doublings: int) -> tuple[Array, Array]:
    design = StateDependentRiccati(FACTORISATION, state, input, doublings=doublings)
    solution = jax.vmap(design.solve)(states)
    return solution.gain, solution.residual


@jax.custom_batching.custom_vmap
def _solved(states: Array, state_weight: Array, input_weight: Array) -> tuple[Array, Array]:
    """Gains and residuals at (runs, 6) states; all take more doubling steps if one needs them."""
    solution = _solve(states, state_weight, input_weight, FEW)
    # comparisons with NaN are false
    enough = jnp.all(solution[1] <= SOLVED)
    return jax.lax.cond(
        enough, lambda: solution, lambda: _solve(states, state_weight, input_weight, MANY)
    )


@_solved.def_vmap
def _(size: int, batched: Any, states: Array, state_weight: Array, input_weight: Array) -> Any:
    # one condition for all runs: with one for each, a batch would always evaluate both branches
    del batched
    solution = _solved(states.reshape(-1, 6), state_weight, input_weight)
    return tuple(part.reshape(size, -1, *part.shape[1:]) for part in solution), (True, True)


class StateDependent(eqx.Module):
    """M = -R^-1 B(x)' P(x) x of (11) and (12).

    Attributes:
        state_weight: Weight Q, (6, 6), the same for all runs of a batch.
        input_weight: Weight R, (3, 3), the same for all runs of a batch.
    """

    state_weight: Float[Array, "6 6"]
    input_weight: Float[Array, "3 3"]

    def __call__(self, state: EulerState) -> Vector3:
        """Commanded torque, N·m; NaN if the Riccati equation has no solution."""
        regulated_state = regulated(state)
        solution = _solved(regulated_state[None], self.state_weight, self.input_weight)
        gain, residual = (part[0] for part in solution)
        # near the singularity the solver's other verdict asks for more doublings than P needs
        return jnp.where(residual <= LARGEST_RESIDUAL, -gain @ regulated_state, jnp.nan)


def laws() -> dict[str, LinearQuadratic | StateDependent]:
    """Both laws with the weights of the paper."""
    weights = jnp.asarray(STATE_WEIGHT), jnp.asarray(INPUT_WEIGHT)
    return {"lqr": LinearQuadratic(jnp.asarray(gain())), "sdre": StateDependent(*weights)}
