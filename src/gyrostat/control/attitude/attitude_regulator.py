"""State feedback of attitude and rate, LQR or SDRE, on any number of wheels."""

from dataclasses import replace
from typing import Annotated, Any, Self

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.allocation.working_wheels import SPAN
from gyrostat.control.design.factorisations import MRPBody
from gyrostat.control.design.lqr import FeedbackCommand
from gyrostat.control.design.riccati import RiccatiSolution, riccati
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.checked import Checked, Rule, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import check_unit
from gyrostat.spacecraft import Spacecraft

_solved = jax.jit(riccati)
"""Compiled as a whole also where a linear law is designed outside of any other compiled code."""


class AttitudeRegulator(Checked):
    """u = -R^-1 B' P x of the Riccati equation, shared among the wheels by the pseudo-inverse.

    x = (sigma, w) of `MRPBody`, Q = diag(q_s, q_s, q_s, q_w, q_w, q_w), R = r 1. A and B are those
    at the state and with the wheels' momentum, and the equation is solved at each sample (SDRE;
    Carvalho and Fenili, eqs. (11), (12)); with `linear`, those at rest at the target with wheels at
    rest, once (LQR). It knows nothing of lost wheels, drag or external torques.

    The target is taken to be at rest. Behind one that turns at a constant rate W about a principal
    axis of inertia J the body stays by 4 atan(W sqrt((q_w + J sqrt(q_s r) / 2) / q_s)) rad: there
    the torque of the attitude, sqrt(q_s / r) tan(angle / 4), makes up for that of the rate,
    sqrt((q_w + J sqrt(q_s r) / 2) / r) W. This is the linear law without momentum in the wheels.

    Attributes:
        spacecraft: as the controller knows it.
        target: (4,) quaternion, scalar first.
        attitude_weight: q_s, of the modified Rodrigues parameters, a quarter of a small angle.
        rate_weight: q_w, s²/rad².
        torque_weight: r, 1/(N·m)².
        gain: (3, 6) of the linear law, N·m and N·m·s/rad; None: the law depends on the state.
    """

    spacecraft: Spacecraft
    target: Annotated[Quaternion, Rule("of unit length", check_unit)]
    attitude_weight: Annotated[Scalar, positive("attitude weight")] = 16.0
    rate_weight: Annotated[Scalar, positive("rate weight", "s²/rad²")] = 16.0
    torque_weight: Annotated[Scalar, positive("torque weight", "1/(N·m)²")] = 1.0
    gain: Float[Array, "3 6"] | None = None

    def linear(self) -> Self:
        """The linear law of the same weights."""
        solution = self._solve(jnp.zeros(6), 0.0)
        # what has no solution shall not fly: a NaN ends the run
        return replace(self, gain=jnp.where(solution.valid, solution.gain, jnp.nan))

    def check_own(self) -> None:
        """Validate the wheel axes.

        Raises:
            InputError: They do not span space.
        """
        axes = np.asarray(self.spacecraft.wheels.axes, dtype=float)
        if np.min(np.linalg.matrix_rank(axes, tol=SPAN)) < 3:
            raise InputError(
                "attitude regulator: found wheels that do not span space, expected them to"
            )

    def start(self, period: Scalar) -> tuple[()]:
        """Nothing to remember."""
        return ()

    def _solve(self, state: Float[Array, "6"], momentum: Any) -> RiccatiSolution:
        dynamics, input = MRPBody(jnp.asarray(self.spacecraft.inertia))(state, momentum)
        each = jnp.ones(3)
        weight = jnp.concatenate([self.attitude_weight * each, self.rate_weight * each])
        return _solved(dynamics, input, jnp.diag(weight), jnp.diag(self.torque_weight * each))

    def __call__(self, memory: tuple[()], measurement: Any) -> tuple[tuple[()], FeedbackCommand]:
        """Command the wheels.

        Args:
            memory: none.
            measurement: has `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed` (wheels,)
                relative to the body, rad/s.
        """
        wheels, rate = self.spacecraft.wheels, measurement.rate
        axes = jnp.asarray(wheels.axes)
        body = MRPBody(jnp.asarray(self.spacecraft.inertia))
        state = body.state(measurement.attitude, rate, self.target)
        if self.gain is None:
            momentum = axes @ (wheels.inertia * (measurement.wheel_speed + axes.T @ rate))
            _, gain, residual, valid = self._solve(state, momentum)
        else:
            gain, residual, valid = self.gain, jnp.zeros(()), jnp.array(True)
        torque = jnp.sum(jnp.asarray(gain) * state, axis=1)
        # what the wheels take the body loses: A m = K x, by the least sum of squares
        share = axes.T @ inverse_definite(axes @ axes.T)
        return memory, FeedbackCommand(share @ torque, residual, valid)
