"""Attitude and rate feedback by LQR or SDRE, for any number of wheels."""

from dataclasses import replace
from typing import Annotated, Any, Self

import numpy as np
from jaxtyping import Array, Float

from gyrostat.control.allocation.allocation import within_limits
from gyrostat.control.allocation.working_wheels import SPAN
from gyrostat.control.attitude.external_torque import ExternalTorqueMemory
from gyrostat.control.design.factorisations import MRPBody
from gyrostat.control.design.lqr import FeedbackCommand
from gyrostat.control.design.riccati import RiccatiSolution, riccati
from gyrostat.control.guidance.guide import AT_REST, Guide
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, Rule, limit, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import check_unit, cross_matrix
from gyrostat.spacecraft import Spacecraft

_riccati = jax.jit(riccati)
"""Compiled as a whole, also if a linear law is designed outside any other compiled code."""

RegulatorMemory = ExternalTorqueMemory | tuple[()]
"""Memory of an `AttitudeRegulator`."""


class AttitudeRegulator(Checked):
    """Riccati-based law u = -R^-1 B' P x, allocated to the wheels by the pseudo-inverse.

    The state is x = (sigma, w) of `MRPBody`, and the weights are Q = diag(q_s, q_s, q_s, q_w, q_w,
    q_w), R = r 1. By default, A and B are those at the present state and with the present wheel
    momentum, and the equation is solved at each sample (SDRE; Carvalho and Fenili, eqs. (11),
    (12)). With `linear`, they are those at rest at the target with wheels at rest, and the equation
    is solved once (LQR). Where a torque exceeds the limit of a wheel, all are scaled, so that their
    sum keeps its direction. The law has no integral that could wind up: with `torque_time`, the
    wheels take up the external torque, estimated from the change of the total momentum. The law
    does not take failed wheels and drag into account.

    With a reference (`toward`), x is the motion relative to it, and the torque of
    `gyrostat.control.guidance.Guide` is added: w' relative to the reference is then J^-1 (u - w x
    (h + J w_t)) - w_t x w with w the relative rate and w_t that of the reference, and there is no
    lag.

    Without a reference, the target is assumed to be at rest. If it turns at a constant rate W about
    a principal axis of inertia J, the body lags by 4 atan(W sqrt((q_w + J sqrt(q_s r) / 2) / q_s))
    rad. At this angle the attitude term, sqrt(q_s / r) tan(angle / 4), balances the rate term,
    sqrt((q_w + J sqrt(q_s r) / 2) / r) W. The result is for the linear law without wheel momentum.

    Attributes:
        spacecraft: Spacecraft model of the controller.
        target: Target quaternion, scalar first, (4,).
        attitude_weight: Weight q_s of the modified Rodrigues parameters, which are a quarter of a
            small angle.
        rate_weight: Weight q_w of the body rate, s²/rad².
        torque_weight: Weight r of the torque, 1/(N·m)².
        torque_time: Time constant of the estimate of the external torque, s; None or infinite: no
            estimate, and an external torque causes a constant attitude error.
        gain: Gain of the linear law, (3, 6), N·m and N·m·s/rad; None if the gain depends on the
            state.
        guide: Reference at the sample, see `toward`; None for a target at rest.
    """

    spacecraft: Spacecraft
    target: Annotated[Quaternion, Rule("of unit length", check_unit)]
    attitude_weight: Annotated[Scalar, positive("attitude weight")] = 16.0
    rate_weight: Annotated[Scalar, positive("rate weight", "s²/rad²")] = 16.0
    torque_weight: Annotated[Scalar, positive("torque weight", "1/(N·m)²")] = 1.0
    torque_time: Annotated[Scalar | None, limit("torque time", "s")] = None
    gain: Float[Array, "3 6"] | None = None
    guide: Guide | None = None

    def toward(self, guide: Guide) -> Self:
        """Law that follows a reference."""
        return replace(self, guide=guide)

    def linear(self) -> Self:
        """Linear law (LQR) with the same weights."""
        solution = self._solve(jnp.zeros(6), 0.0)
        # without a valid solution the gain is NaN, which ends the run
        return replace(self, gain=jnp.where(solution.valid, solution.gain, jnp.nan))

    def check_own(self) -> None:
        """Validate the wheel axes.

        Raises:
            InputError: The wheel axes do not span space.
        """
        axes = np.asarray(self.spacecraft.wheels.axes, dtype=float)
        if np.min(np.linalg.matrix_rank(axes, tol=SPAN)) < 3:
            raise InputError(
                "attitude regulator: found wheels that do not span space, expected them to"
            )

    def start(self, period: Scalar) -> RegulatorMemory:
        """Initial memory; empty without an estimate of the external torque."""
        return () if self.torque_time is None else ExternalTorqueMemory.start(period)

    def predicted(self, memory: RegulatorMemory, measurement: Any, command: Any) -> RegulatorMemory:
        """Memory after a period without a sample.

        Args:
            memory: Memory from the last sample.
            measurement: Unused.
            command: Unused.
        """
        return memory.missed() if isinstance(memory, ExternalTorqueMemory) else memory

    def _solve(
        self, state: Float[Array, "6"], momentum: Any, carried: Vector3 | None = None
    ) -> RiccatiSolution:
        """Riccati solution at a relative state.

        Args:
            state: State, sigma and w.
            momentum: Momentum of the wheels, and of the body at the rate `carried`, (3,), N·m·s.
            carried: Rate of the reference, body axes, (3,), rad/s; None for a target at rest.
        """
        dynamics, input = MRPBody(jnp.asarray(self.spacecraft.inertia))(state, momentum)
        if carried is not None:
            dynamics = dynamics.at[3:, 3:].add(-cross_matrix(carried))
        unit = jnp.ones(3)
        weight = jnp.concatenate([self.attitude_weight * unit, self.rate_weight * unit])
        return _riccati(dynamics, input, jnp.diag(weight), jnp.diag(self.torque_weight * unit))

    def __call__(
        self, memory: RegulatorMemory, measurement: Any
    ) -> tuple[RegulatorMemory, FeedbackCommand]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (wheels,), relative to the body, rad/s.
        """
        wheels, rate = self.spacecraft.wheels, measurement.rate
        axes = jnp.asarray(wheels.axes)
        body = MRPBody(jnp.asarray(self.spacecraft.inertia))
        state, carried, forward = body.state(measurement.attitude, rate, self.target), None, None
        wheel_momentum = axes @ (wheels.inertia * (measurement.wheel_speed + axes.T @ rate))
        momentum = wheel_momentum
        if self.guide is not None:
            inertia = jnp.asarray(self.spacecraft.inertia)
            total = inertia @ rate + momentum
            motion = self.guide.follow(measurement.attitude, rate, total, inertia)
            state = body.state(motion.turn, motion.rate, AT_REST)
            carried, forward = motion.carried, motion.torque
            momentum = momentum + inertia @ carried
        if self.gain is None:
            _, gain, residual, valid = self._solve(state, momentum, carried)
        else:
            gain, residual, valid = self.gain, jnp.zeros(()), jnp.array(True)
        torque = jnp.sum(jnp.asarray(gain) * state, axis=1)
        if forward is not None:
            torque += forward
        if isinstance(memory, ExternalTorqueMemory) and self.torque_time is not None:
            total_momentum = jnp.asarray(self.spacecraft.inertia) @ rate + wheel_momentum
            memory = memory.updated(measurement.attitude, total_momentum, self.torque_time)
            torque += memory.torque
        # wheel torques m act on the body as -A m, so that A m = K x, with least squares
        share = axes.T @ inverse_definite(axes @ axes.T)
        limits = jnp.ones(wheels.count) * wheels.torque_limit
        return memory, FeedbackCommand(within_limits(share @ torque, limits), residual, valid)
