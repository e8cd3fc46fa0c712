"""Gyrostat: a body with reaction wheels, rigid or with flexible appendages."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, size, three
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import check_unit, normalised, to_body, to_inertial
from gyrostat.core.traced_once import method_traced_once
from gyrostat.core.validation import check_parts
from gyrostat.spacecraft.failures import WheelFailures
from gyrostat.spacecraft.flexible.coupling import ModalCoupling, with_names
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.friction_steps import FrictionSteps
from gyrostat.spacecraft.gyrostat_state import (
    GyrostatRecord,
    GyrostatState,
    WheelTorqueCommand,
    check_sizes,
    too_fast,
)
from gyrostat.spacecraft.interpolated_torque import advanced_with_interpolated_torque
from gyrostat.spacecraft.pieces import pieces
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.torque_models import (
    AnyActuator,
    TorqueModel,
    advanced_actuators,
    body_torque,
    check_actuators,
    start_actuators,
    torque_models,
    under_command,
)
from gyrostat.spacecraft.wheel_friction import advanced, check_deflection, started_deflection
from gyrostat.spacecraft.wheels_on_body import WheelsOnBody
from gyrostat.wheel.array import listed, zeros


class Gyrostat(Checked):
    """Body with reaction wheels: dH/dt = R T, dh_i/dt = m_i - F_i.

    H = R (J w + sum a_i h_i) is the total momentum in inertial axes and h_i = J_i (W_i + a_i w) the
    axial momentum of rotor i. J is the inertia of the spacecraft without that of the rotors about
    their axes a_i, w the body rate, W_i the speed of wheel i relative to the body, m_i its motor
    torque, F_i its friction, T the external torque in body axes. The state contains H, and w is
    computed from it, so that without external torque H is conserved to the last bit. P. C. Hughes,
    "Spacecraft Attitude Dynamics", section 3.4. The times at which wheels stick, break away and
    cross zero speed are resolved (`gyrostat.wheel.step_coupled_wheels`). The momentum of flexible
    appendages (`FlexibleModes`) is a further part of H.

    Attributes:
        spacecraft: Body and wheels.
        failures: Wheel failures; None for none.
        external_torque: Constant external torque in body axes, (3,), N·m.
        torque_history: External torque in body axes, (attitude quaternion, time in s) -> (3,), N·m;
            added to the constant. It must be smooth and slow compared with the control period.
        environment: Further external torques, see `TorqueModel`; smooth and slow likewise. They
            are interpolated in every integration step (`InterpolatedTorque`).
        external_torque_limit: Limit of the commanded `external_torque` along each body axis, given
            by an ideal actuator such as magnetorquers, (3,), N·m; None: there is no such actuator,
            and its command is ignored.
        friction_steps: Step changes of wheel friction; None for none.
        actuators: Further actuators, see `Actuator` and `ActuatorWithState`, each driven by the
            field of the command that has its name; none by default.
        modes: Modes of flexible appendages and propellant; None for a rigid body. The inertia of
            the spacecraft includes them undeformed.
    """

    spacecraft: Spacecraft
    failures: WheelFailures | None = None
    external_torque: Annotated[Vector3, three("external torque", "N·m")] = zeros()
    torque_history: Callable[[Quaternion, Scalar], Vector3] | None = eqx.field(
        static=True, default=None
    )
    environment: tuple[TorqueModel, ...] = eqx.field(converter=torque_models, default=())
    external_torque_limit: Annotated[Vector3 | None, size("external torque limit", "N·m")] = (
        eqx.field(converter=listed, default=None)
    )
    friction_steps: FrictionSteps | None = None
    actuators: Mapping[str, AnyActuator] = eqx.field(default_factory=dict)
    modes: FlexibleModes | None = None

    def torque(self, attitude: Quaternion, time: Scalar) -> Vector3:
        """External torque in body axes, (3,), N·m, at a time, s."""
        return self.exact_torque(attitude, time) + self.slow_torque(attitude, time)

    def exact_torque(self, attitude: Quaternion, time: Scalar) -> Vector3:
        """Part of the external torque that is integrated without interpolation, (3,), N·m."""
        torque = jnp.asarray(self.external_torque)
        if self.torque_history is not None:
            torque = torque + self.torque_history(attitude, time)
        return torque

    def slow_torque(self, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque of the environment and of the actuators, body axes, (3,), N·m."""
        torque = jnp.zeros(3)
        for item in self.environment:
            part = item(self.spacecraft, attitude, time)
            torque = torque + body_torque(part, f"environment torque {type(item).__name__}")
        return torque

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: An external torque limit that is not (3,), failures or friction steps of
                another number of wheels, or modes with more inertia than the body.
        """
        if self.external_torque_limit is not None:
            shape = np.shape(self.external_torque_limit)
            if shape[-1:] != (3,):
                raise InputError(f"external torque limit: found shape {shape}, expected (3,)")
        if self.failures is not None:
            failure_count, count = np.shape(self.failures.time)[-1], self.spacecraft.wheels.count
            if failure_count != count:
                raise InputError(f"wheel failures: found {failure_count} wheels, expected {count}")
        if self.friction_steps is not None:
            self.friction_steps.check_wheels(self.spacecraft.wheels)
        check_parts(*self.actuators.values())
        if self.modes is not None:
            self.modes.check_inertia(self.spacecraft.inertia)

    def start(
        self,
        *,
        attitude: Any = (1.0, 0.0, 0.0, 0.0),
        rate: Any = (0.0, 0.0, 0.0),
        wheel_speed: Any = 0.0,
        modal_coordinate: Any = None,
        modal_rate: Any = None,
        deflection: Any = None,
    ) -> GyrostatState:
        """Create a state from attitude, rate, wheel speeds and the motion of the modes.

        Args:
            attitude: Attitude quaternion, (4,), scalar first; it is normalised.
            rate: Body rate in body axes, (3,), rad/s.
            wheel_speed: Wheel speeds relative to the body, (wheels,), or one value for all, rad/s.
            modal_coordinate: Modal coordinates, (modes,), or one value for all, √kg·m; None for 0.
            modal_rate: Modal rates, (modes,), or one value for all, √kg·m/s; None for 0.
            deflection: Deflections of the bristles, likewise, rad; None for those of steady slip.
        """
        wheels = self.spacecraft.wheels
        quaternion = normalised(jnp.asarray(attitude, dtype=float))
        speed = jnp.broadcast_to(jnp.asarray(wheel_speed, dtype=float), (wheels.count,))
        rotors = jnp.asarray(wheels.axes) @ (wheels.inertia * speed)
        momentum = self.spacecraft.inertia_locked() @ jnp.asarray(rate, dtype=float) + rotors
        modal = None
        if self.modes is not None:
            modal, of_modes = self.modes.start(modal_coordinate, modal_rate, jnp.asarray(rate))
            momentum = momentum + of_modes
        elif modal_coordinate is not None or modal_rate is not None:
            raise InputError("modal_coordinate: found one, expected none without modes")
        momentum = to_inertial(quaternion, momentum)
        bent = started_deflection(wheels.friction, speed, deflection)
        actuators = start_actuators(self.actuators)
        return GyrostatState(
            quaternion, momentum, speed, **with_names(modal), deflection=bent, actuators=actuators
        )

    def check_state(self, state: GyrostatState) -> None:
        """Validate a state.

        Args:
            state: One state, or several with a leading axis of runs.

        Raises:
            InputError: A shape is wrong, the quaternion is not of unit length, a wheel is above its
                momentum limit, or the state of an actuator is missing.
        """
        wheels = self.spacecraft.wheels
        check_sizes(state, wheels.count, 0 if self.modes is None else self.modes.count)
        check_deflection(wheels.friction, state)
        check_actuators(self.actuators, state.actuators)
        check_unit(state.attitude)
        wheels.check_speed(state.wheel_speed)

    def rate(self, state: Any) -> Vector3:
        """Body rate in body axes, (3,), rad/s.

        Args:
            state: Any state with `attitude`, `momentum` and `wheel_speed` as in `GyrostatState`.
        """
        wheels = self.spacecraft.wheels
        rotors = jnp.asarray(wheels.axes) @ (wheels.inertia * state.wheel_speed)
        rigid, coupling = self.without_modes()
        inverse = inverse_definite(rigid.inertia_locked())
        if coupling is not None:
            rotors = rotors + coupling.body_part(state.modal_momentum)
        return inverse @ (to_body(state.attitude, state.momentum) - rotors)

    def without_modes(self) -> tuple[Spacecraft, ModalCoupling | None]:
        """Spacecraft without the inertia of the modes, and their coupling with it."""
        if self.modes is None:
            return self.spacecraft, None
        coupling = self.modes.coupling()
        inertia = self.spacecraft.inertia - coupling.inertia
        return replace(self.spacecraft, inertia=inertia), coupling

    def __call__(
        self, state: GyrostatState, command: Any, time: Scalar, duration: Scalar
    ) -> tuple[GyrostatState, Bool[Array, ""]]:
        """Integrate over an interval of constant command.

        Args:
            state: State at the start.
            command: Command with the motor torques `torque`, (wheels,), N·m; if there is an
                actuator for it, `external_torque`, (3,), N·m; and the fields that drive
                `actuators`.
            time: Time at the start, s.
            duration: Length of the interval, s.

        Returns:
            The state at the end, and whether the interval was resolved. A failure or a friction
            step inside the interval acts from its exact time.
        """
        states = state.actuators
        craft = under_command(self, command, states, time)
        state = state._replace(actuators=None)
        after, resolved = craft._advance(state, command.torque, time, duration)
        states = advanced_actuators(self.actuators, states, command, duration)
        return after._replace(actuators=states), resolved

    @method_traced_once
    def _advance(self, state, torque, time, duration):
        torque = self.spacecraft.wheels.within_torque_limit(torque)
        friction, steps = self.spacecraft.wheels.friction, self.friction_steps
        changes = [part for part in (self.failures, steps) if part is not None]
        if not changes:
            none = jnp.zeros(torque.shape)
            torque = self._within_momentum_limit(state, torque, duration)
            return self._carry(state, torque, friction, none > 0.0, none, time, duration)
        failures = self.failures or WheelFailures.none(len(torque))
        times = jnp.concatenate([jnp.asarray(part.time) for part in changes])

        def part(carried, piece):
            state, fine = carried
            start, length = piece
            failed = failures.failed(time + start)
            motor = failures.motor_torque(torque, failed)
            drag = jnp.where(failed, failures.added_viscous, 0.0)
            seized = failed & failures.seized
            # the momentum of a seized rotor is transferred to the body instantly
            state = state._replace(wheel_speed=jnp.where(seized, 0.0, state.wheel_speed))
            motor = self._within_momentum_limit(state, motor, length)
            rubs = friction if steps is None else steps.at(time + start, friction)
            state, resolved = self._carry(state, motor, rubs, seized, drag, time + start, length)
            return (state, fine & resolved), None

        return jax.lax.scan(part, (state, jnp.array(True)), pieces(times, time, duration))[0]

    def _within_momentum_limit(self, state, torque, duration):
        wheels = self.spacecraft.wheels
        return wheels.within_momentum_limit(torque, wheels.inertia * state.wheel_speed, duration)

    def _carry(self, state, torque, friction, seized, drag, time, duration):
        contacts = WheelsOnBody.of(
            self, friction, torque=torque, seized=seized, added_viscous=drag, started=time
        )
        advance = advanced_with_interpolated_torque if self.environment else advanced
        return advance(contacts, state, duration)

    def diverged(self, state: GyrostatState) -> Bool[Array, ""]:
        """Whether the body turns faster than `FASTEST`."""
        return too_fast(self.rate(state))

    def record(self, state: GyrostatState, command: WheelTorqueCommand) -> GyrostatRecord:
        """Rate and wheel momentum at the start of a control period."""
        wheels = self.spacecraft.wheels
        return GyrostatRecord(
            rate=self.rate(state),
            wheel_momentum=wheels.inertia * state.wheel_speed,
            saturated=jnp.abs(command.torque) > wheels.torque_limit,
            modal_rate=self.modes and self._modal_rate(self.modes, state),
        )

    def _modal_rate(self, modes, state):
        return modes.coupling().rate(state.modal_momentum, self.rate(state))

    def kinetic_energy(self, state: Any) -> Scalar:
        """Kinetic energy of body, rotors and modes, J."""
        wheels = self.spacecraft.wheels
        rate = self.rate(state)
        rotor = state.wheel_speed + jnp.asarray(wheels.axes).T @ rate
        body = rate @ jnp.asarray(self.spacecraft.inertia) @ rate
        rigid = 0.5 * (body + jnp.sum(wheels.inertia * rotor**2))
        if self.modes is None:
            return rigid
        with_body = state.modal_momentum + jnp.asarray(self.modes.participation) @ rate
        return rigid + 0.5 * self._modal_rate(self.modes, state) @ with_body
