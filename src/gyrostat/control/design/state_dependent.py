"""Control by the state-dependent Riccati equation (SDRE)."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.design.lqr import FeedbackCommand, check_weight
from gyrostat.control.design.riccati import DOUBLINGS, RiccatiSolution, riccati
from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp

Factorisation = Callable[..., tuple[Float[Array, "n n"], Float[Array, "n m"]]]
"""(x, ...) -> A, B with x' = A x + B u exactly."""


def _state(measurement: Any) -> tuple[Any, ...]:
    return (measurement.state,)


class StateDependentRiccati(Checked):
    """u = -R^-1 B(x)' P(x) x, where P(x) solves the Riccati equation of A(x), B(x), Q, R.

    T. Cimen, "State-Dependent Riccati Equation (SDRE) Control: A Survey", IFAC World Congress 2008;
    Carvalho and Fenili, eqs. (11), (12). One equation is solved at each call. A factorisation is
    not unique, and another one is another law.

    Attributes:
        factorisation: (x, ...) -> A, B.
        state_weight: Q, (n, n), symmetric, positive semidefinite.
        input_weight: R, (m, m), symmetric, positive definite.
        reading: measurement -> arguments of the factorisation, the state x first: deviations from
            what is wanted. The default takes a measurement's `state`.
        doublings: fixed count for the Riccati equation.
    """

    factorisation: Factorisation
    state_weight: Float[Array, "n n"]
    input_weight: Float[Array, "m m"]
    reading: Callable[[Any], tuple[Any, ...]] = eqx.field(static=True, default=_state)
    doublings: int = eqx.field(static=True, default=DOUBLINGS)

    def check_own(self) -> None:
        """Validate the weights.

        Raises:
            InputError: See `check_weight`.
        """
        for name, weight, definite in (
            ("state weight Q", self.state_weight, False),
            ("input weight R", self.input_weight, True),
        ):
            every = np.asarray(weight, dtype=float)
            if every.ndim < 2:
                raise InputError(f"{name}: found shape {every.shape}, expected a square matrix")
            # axes before the last two are those of runs
            for matrix in every.reshape(-1, *every.shape[-2:]):
                check_weight(name, matrix, every.shape[-1], definite=definite)

    def solve(self, *arguments: Any) -> RiccatiSolution:
        """The Riccati equation at a state, with what else the factorisation takes."""
        dynamics, input = self.factorisation(*arguments)
        states, inputs = jnp.shape(input)
        for name, weight, size in (
            ("state weight Q", self.state_weight, states),
            ("input weight R", self.input_weight, inputs),
        ):
            if np.shape(weight) != (size, size):
                raise InputError(
                    f"{name}: found shape {np.shape(weight)}, expected ({size}, {size})"
                )
        return riccati(
            dynamics, input, self.state_weight, self.input_weight, doublings=self.doublings
        )

    def command(self, *arguments: Any) -> FeedbackCommand:
        """Inputs at a state, with what else the factorisation takes; see `valid` in it."""
        solution = self.solve(*arguments)
        torque = -jnp.sum(solution.gain * arguments[0], axis=1)
        return FeedbackCommand(torque, solution.residual, solution.valid)

    def start(self, period: Scalar) -> tuple[()]:
        """Nothing to remember."""
        return ()

    def __call__(self, memory: tuple[()], measurement: Any) -> tuple[tuple[()], FeedbackCommand]:
        """Command the inputs."""
        return memory, self.command(*self.reading(measurement))
