"""Rigid body on 3-1-3 angles with external torques: Carvalho and Fenili's plant, corrected.

C. A. de Carvalho Junior, A. Fenili, "Nonlinear attitude control of artificial satellites
considering failure in momentum wheels", eq. (5). The torques are external: no wheels absorb the
momentum that they give the body.
"""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import EulerAngles, rate_of_euler

LEAST_SINE = 0.005
"""Sine of theta below which the angles are too close to their singularity for control."""
LARGEST_SLIP = 1e-5
"""Largest error of the body rate in a resolved step, rad/s."""

_REACH = np.array([0.0, 0.5, 0.5, 1.0])
_WEIGHT = np.array([1.0, 2.0, 2.0, 1.0]) / 6.0


class EulerState(NamedTuple):
    """Attitude and motion on 3-1-3 angles, never reduced by whole turns.

    Attributes:
        theta: Second angle, about x, rad.
        phi: First angle, about z, rad.
        psi: Third angle, about z, rad.
        theta_rate: Rate of theta, rad/s.
        phi_rate: Rate of phi, rad/s.
        psi_rate: Rate of psi, rad/s.
    """

    theta: Annotated[Scalar, "rad"]
    phi: Annotated[Scalar, "rad"]
    psi: Annotated[Scalar, "rad"]
    theta_rate: Annotated[Scalar, "rad/s"]
    phi_rate: Annotated[Scalar, "rad/s"]
    psi_rate: Annotated[Scalar, "rad/s"]

    def body_rate(self) -> Vector3:
        """Angular velocity of the body relative to inertial space, body axes, rad/s."""
        angles = EulerAngles(phi=self.phi, theta=self.theta, psi=self.psi)
        return rate_of_euler(angles, EulerAngles(self.phi_rate, self.theta_rate, self.psi_rate))


class BodyTorqueCommand(NamedTuple):
    """Torques about the body axes, constant in a control period.

    Attributes:
        torque: M_x, M_y, M_z, (3,), N·m.
    """

    torque: Annotated[Vector3, "N·m"]


class BodyRateRecord(NamedTuple):
    """Recorded signals in addition to the state.

    Attributes:
        body_rate: Body rate in body axes, (3,), rad/s.
    """

    body_rate: Annotated[Vector3, "rad/s"]


class TorqueDrivenBody(Checked):
    """I dw/dt = M for a body with equal principal inertias, on 3-1-3 angles.

    Equation (5) of the paper, corrected:

        theta'' = (M_x cos psi - M_y sin psi) / I - phi' psi' sin theta
        phi''   = ((M_x sin psi + M_y cos psi) / I + (psi' - phi' cos theta) theta') / sin theta
        psi''   = M_z / I - phi'' cos theta + phi' theta' sin theta

    Attributes:
        inertia: I about every axis, as of a cube or a ball, kg·m².
        failure_time: Time from which the torque about each body axis is zero, (3,), s; inf if it
            never fails. A torque acts to the end of a step that begins before this time.
    """

    inertia: Annotated[Scalar, positive("body inertia", "kg·m²")]
    failure_time: Float[Array, "3"] | np.ndarray = eqx.field(
        default_factory=lambda: np.full(3, np.inf)
    )

    def check_own(self) -> None:
        """Validate the failure times.

        Raises:
            InputError: There are not three times, or one is before the start.
        """
        times = np.asarray(self.failure_time, float)
        if times.shape[-1:] != (3,):
            raise InputError(
                f"failure time: found shape {times.shape}, expected (3,), one per axis"
            )
        if not np.all(times >= 0.0):
            invalid = times[~(times >= 0.0)].flat[0]
            raise InputError(
                f"failure time: found {invalid:g} s, expected 0 s or later, or inf for none: a "
                "failure before the start is a torque that fails at 0 s"
            )

    def start(self, angles: EulerAngles, rates: EulerAngles) -> EulerState:
        """State of one body.

        Args:
            angles: Angles, rad.
            rates: Rates of the angles, rad/s.

        Raises:
            InputError: sin(theta) is below `LEAST_SINE`, where phi and psi are not unique.
        """
        if not np.sin(np.asarray(angles.theta, float)) >= LEAST_SINE:
            raise InputError(
                f"theta: found {float(angles.theta):g} rad, expected an angle whose sine is "
                f"{LEAST_SINE:g} or more: 3-1-3 angles are singular at 0 and pi"
            )
        values = (angles.theta, angles.phi, angles.psi, rates.theta, rates.phi, rates.psi)
        return EulerState(*(jnp.asarray(value, float) for value in values))

    def working(self, time: Scalar) -> Float[Array, "3"]:
        """1 for each axis whose torque acts in a step that begins at `time`, s, otherwise 0."""
        # a multiple of a step is not exactly the time that it represents
        return jnp.where(jnp.asarray(self.failure_time) > time + 1e-9, 1.0, 0.0)

    def accelerations(self, state: EulerState, torque: Vector3) -> EulerAngles:
        """Second derivatives of the angles, rad/s², by the corrected eq. (5).

        Args:
            state: State.
            torque: Torque in body axes, (3,), N·m.
        """
        sine, cosine = jnp.sin(state.theta), jnp.cos(state.theta)
        x, y, z = torque / self.inertia
        across, along = jnp.sin(state.psi), jnp.cos(state.psi)
        theta = x * along - y * across - state.phi_rate * state.psi_rate * sine
        turn = (state.psi_rate - state.phi_rate * cosine) * state.theta_rate
        # a step beyond the singularity is not resolved; this only keeps numbers finite there
        phi = (x * across + y * along + turn) / jnp.where(jnp.abs(sine) > 1e-9, sine, 1e-9)
        psi = z - phi * cosine + state.phi_rate * state.theta_rate * sine
        return EulerAngles(phi=phi, theta=theta, psi=psi)

    def carry(
        self,
        state: EulerState,
        law: Callable[[EulerState], Vector3],
        time: Scalar,
        duration: Scalar,
    ) -> tuple[EulerState, Bool[Array, ""], Scalar]:
        """Advance by one classical Runge-Kutta step of order 4; the law is evaluated at each stage.

        Args:
            state: State at the start of the step.
            law: Function from state to commanded torque, (3,), N·m; failed torques do not act.
            time: Start of the step, s.
            duration: Duration of the step, s.

        Returns:
            State at the end; whether all stages stayed away from the singularity by `LEAST_SINE`;
            and the slip: deviation of the body rate, rad/s, from the impulse of the torques at the
            stages, which is the error of the step in the body rate.
        """
        begin = jnp.stack([jnp.asarray(value, float) for value in state])
        working = self.working(time)

        def stage(carried, coefficients):
            slope, total, impulse, clear = carried
            reach, weight = coefficients
            at = begin + reach * duration * slope
            stage_state = EulerState(*at)
            torque = working * law(stage_state)
            bend = self.accelerations(stage_state, torque)
            slope = jnp.concatenate([at[3:], jnp.stack([bend.theta, bend.phi, bend.psi])])
            clear = clear & (jnp.sin(stage_state.theta) >= LEAST_SINE)
            return (slope, total + weight * slope, impulse + weight * torque, clear), None

        # a scan compiles the law once
        zero = (jnp.zeros(6), jnp.zeros(6), jnp.zeros(3), jnp.array(True))
        (_, total, impulse, clear), _ = jax.lax.scan(stage, zero, (_REACH, _WEIGHT))
        after = EulerState(*(begin + duration * total))
        slip = after.body_rate() - EulerState(*begin).body_rate()
        slip = slip - duration * impulse / self.inertia
        return after, clear, jnp.max(jnp.abs(slip))

    def __call__(
        self, state: EulerState, command: BodyTorqueCommand, time: Scalar, duration: Scalar
    ) -> tuple[EulerState, Bool[Array, ""]]:
        """Advance by an interval of constant torque.

        Returns:
            State at the end, and whether the step was resolved: away from the singularity, with a
            slip within `LARGEST_SLIP`; see `carry`.
        """
        torque = jnp.asarray(command.torque)
        after, clear, slip = self.carry(state, lambda _: torque, time, duration)
        return after, clear & (slip <= LARGEST_SLIP)

    def diverged(self, state: EulerState) -> Bool[Array, ""]:
        """Whether the angles have reached their singularity, sin(theta) < `LEAST_SINE`."""
        return ~(jnp.sin(state.theta) >= LEAST_SINE)

    def record(self, state: EulerState, command: Any) -> BodyRateRecord:
        """Body rate."""
        return BodyRateRecord(state.body_rate())


class EulerMeasurement(NamedTuple):
    """Angles and their rates, without error.

    Attributes:
        angles: theta, phi, psi, (3,), rad.
        rates: Rates of the angles, (3,), rad/s.
    """

    angles: Annotated[Vector3, "rad"]
    rates: Annotated[Vector3, "rad/s"]


class EulerSensor(eqx.Module):
    """Error-free sensor of angles and rates, as the paper's laws assume."""

    def start(self, state: Any, period: Scalar) -> tuple[()]:
        """The sensor has no memory."""
        return ()

    def __call__(
        self, memory: tuple[()], state: EulerState, key: PRNGKeyArray
    ) -> tuple[tuple[()], EulerMeasurement]:
        """Read the state."""
        return memory, EulerMeasurement(jnp.stack(state[:3]), jnp.stack(state[3:]))
