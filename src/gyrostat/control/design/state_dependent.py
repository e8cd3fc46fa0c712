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
"""Function (x, ...) -> A, B for which x' = A x + B u exactly."""


def _state(measurement: Any) -> tuple[Any, ...]:
    return (measurement.state,)


class StateDependentRiccati(Checked):
    """State-dependent Riccati law u = -R^-1 B(x)' P(x) x.

    P(x) solves the Riccati equation of A(x), B(x), Q and R.

    T. Cimen, "State-Dependent Riccati Equation (SDRE) Control: A Survey", IFAC World Congress 2008;
    Carvalho and Fenili, eqs. (11), (12). Each call solves one Riccati equation. A factorisation is
    not unique; another factorisation gives another law.

    Attributes:
        factorisation: Function (x, ...) -> A, B.
        state_weight: Weight Q, (n, n), symmetric, positive semidefinite.
        input_weight: Weight R, (m, m), symmetric, positive definite.
        reading: Function from a measurement to the arguments of the factorisation. The first
            argument is the state x, the deviation from the target. The default takes the field
            `state` of the measurement.
        doublings: Fixed number of doublings for the Riccati equation.
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
            # axes before the last two are batch axes
            for matrix in every.reshape(-1, *every.shape[-2:]):
                check_weight(name, matrix, every.shape[-1], definite=definite)

    def solve(self, *arguments: Any) -> RiccatiSolution:
        """Solve the Riccati equation for a state and further arguments of the factorisation."""
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
        """Command for a state and further arguments of the factorisation, and its validity."""
        solution = self.solve(*arguments)
        torque = -jnp.sum(solution.gain * arguments[0], axis=1)
        return FeedbackCommand(torque, solution.residual, solution.valid)

    def start(self, period: Scalar) -> tuple[()]:
        """Initial memory; empty."""
        return ()

    def __call__(self, memory: tuple[()], measurement: Any) -> tuple[tuple[()], FeedbackCommand]:
        """Compute the command."""
        return memory, self.command(*self.reading(measurement))
