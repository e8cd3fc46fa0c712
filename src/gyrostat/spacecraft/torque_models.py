"""External torques on a spacecraft: environment, and actuators driven by fields of the command."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Protocol

import equinox as eqx

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.show import with_values
from gyrostat.spacecraft.spacecraft import Spacecraft


class TorqueModel(Protocol):
    """Protocol of an environment torque, an item of `Gyrostat.environment`.

    The torque must be smooth and slow compared with the control period. In every integration step
    it is interpolated by a cubic function of time.
    """

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m.

        Args:
            spacecraft: Body and wheels.
            attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
            time: Time, s.
        """
        ...


class Actuator(Protocol):
    """Protocol of an actuator that exerts a torque, an entry of `Gyrostat.actuators`."""

    def __call__(self, value: Any, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m.

        Args:
            value: Command of the actuator, constant during a control period.
            attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
            time: Time, s.
        """
        ...


class ActuatorWithState(Protocol):
    """Protocol of an actuator with a state, such as a lag, an entry of `Gyrostat.actuators`.

    The state depends on time and command alone, and its motion is known in closed form.

    Attributes:
        longest_step: Longest time over which a cubic function represents the torque, s, such as
            a tenth of the time constant of a lag.
    """

    longest_step: Scalar

    def start(self) -> Any:
        """State at the start of a run, a tree of numbers."""
        ...

    def advanced(self, state: Any, value: Any, elapsed: Scalar) -> Any:
        """State after a time of constant command; two times in turn give that after their sum.

        Args:
            state: State before.
            value: Command of the actuator.
            elapsed: Time, s, 0 or more.
        """
        ...

    def __call__(self, state: Any, value: Any, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m.

        Args:
            state: State at this time.
            value: Command of the actuator, constant during a control period.
            attitude: Attitude quaternion, body with respect to inertial, (4,), scalar first.
            time: Time, s.
        """
        ...


AnyActuator = Actuator | ActuatorWithState


class CommandedTorque(eqx.Module):
    """Torque of an actuator at a constant command, as an environment torque.

    Attributes:
        name: Name of the actuator.
        actuator: Actuator.
        value: Its command.
        state: State of the actuator at the time `started`; None if it has none.
        started: Time of the state, s.
    """

    name: str = eqx.field(static=True)
    actuator: AnyActuator
    value: Any
    state: Any
    started: Scalar

    def __repr__(self) -> str:
        return with_values(self)

    @property
    def longest_step(self) -> Scalar | None:
        """See `ActuatorWithState`; None without a state."""
        actuator: Any = self.actuator
        return None if self.state is None else actuator.longest_step

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """See `TorqueModel`."""
        del spacecraft
        actuator: Any = self.actuator
        if self.state is None:
            torque = actuator(self.value, attitude, time)
        else:
            state = actuator.advanced(self.state, self.value, time - self.started)
            torque = actuator(state, self.value, attitude, time)
        return body_torque(torque, f"actuator {self.name}")


def _with_state(actuators: Mapping[str, Any]) -> dict[str, ActuatorWithState]:
    """Actuators that have a state, by name."""
    return {name: each for name, each in sorted(actuators.items()) if hasattr(each, "start")}


def start_actuators(actuators: Mapping[str, AnyActuator]) -> dict[str, Any] | None:
    """States of the actuators that have one at the start of a run: name -> state; None without."""
    return {name: each.start() for name, each in _with_state(actuators).items()} or None


def advanced_actuators(
    actuators: Mapping[str, AnyActuator], states: Any, command: Any, elapsed: Scalar
) -> dict[str, Any] | None:
    """States of the actuators after a time of constant command.

    Args:
        actuators: Name -> actuator.
        states: Name -> state; None if none has a state.
        command: Command, a named tuple.
        elapsed: Time, s.
    """
    after = {
        name: each.advanced(states[name], getattr(command, name), elapsed)
        for name, each in _with_state(actuators).items()
    }
    return after or None


def check_actuators(actuators: Mapping[str, AnyActuator], states: Any) -> None:
    """Validate that those actuators have a state that need one.

    Raises:
        InputError: A state is missing, or there is one more.
    """
    names = sorted(states or ()), [*_with_state(actuators)]
    if names[0] != names[1]:
        found, expected = (", ".join(each) or "none" for each in names)
        raise InputError(f"actuators: found the states of {found}, expected those of {expected}")


def commanded_torques(
    actuators: Mapping[str, AnyActuator], command: Any, states: Any, time: Scalar
) -> tuple[CommandedTorque, ...]:
    """Torques of actuators, each driven by the field of the command that has its name.

    Args:
        actuators: Name -> actuator.
        command: Command, a named tuple.
        states: Name -> state at `time`, of the actuators that have one; None without.
        time: Time, s.

    Raises:
        InputError: The command has no field for an actuator.
    """
    for name in actuators:
        if not hasattr(command, name):
            fields = ", ".join(getattr(command, "_fields", ())) or "no fields"
            raise InputError(
                f"actuator {name}: found a command ({type(command).__name__}) of {fields}, "
                f"expected the field {name}, which drives the actuator"
            )
    return tuple(
        CommandedTorque(name, actuator, getattr(command, name), (states or {}).get(name), time)
        for name, actuator in sorted(actuators.items())
    )


def under_command(plant: Any, command: Any, states: Any, time: Scalar) -> Any:
    """Gyrostat with the torques of its actuators at a command as external torques.

    Args:
        plant: `gyrostat.spacecraft.Gyrostat`.
        command: Command, a named tuple.
        states: Name -> state at `time`, of the actuators that have one; None without.
        time: Time, s.

    Raises:
        InputError: The command has no field for an actuator.
    """
    if plant.external_torque_limit is not None:
        if not hasattr(command, "external_torque"):
            raise InputError(
                f"{type(command).__name__}: found no external_torque, expected one: the "
                "spacecraft has an actuator for it"
            )
        limit = jnp.asarray(plant.external_torque_limit)
        external = plant.external_torque + jnp.clip(command.external_torque, -limit, limit)
        plant = eqx.tree_at(lambda each: each.external_torque, plant, external)
    if plant.actuators:
        commanded = commanded_torques(plant.actuators, command, states, time)
        plant = replace(plant, environment=(*plant.environment, *commanded))
    return plant


def body_torque(torque: Any, place: str) -> Vector3:
    """Torque as an array, (3,), N·m.

    Args:
        torque: Result of a torque model.
        place: Name of the model for the message.

    Raises:
        InputError: It is not of shape (3,).
    """
    array = jnp.asarray(torque)
    if array.shape != (3,):
        raise InputError(
            f"{place}: found a torque of shape {array.shape}, expected (3,), N·m in body axes"
        )
    return array


def torque_models(models: Any) -> Any:
    """Convert the torque models of an environment to a tuple.

    Args:
        models: Tuple or list of torque models.

    Raises:
        InputError: It is neither, or contains an item that cannot be called.
    """
    if isinstance(models, list):
        models = tuple(models)
    if not isinstance(models, tuple):
        name = type(models).__name__
        raise InputError(
            f"environment: found {name}, expected a tuple of torque models, such as ({name}(...),)"
        )
    for model in models:
        if not callable(model) or isinstance(model, type):
            text = f"the class {model.__name__}" if isinstance(model, type) else repr(model)
            raise InputError(
                f"environment: found {text}, expected torque models, called with (spacecraft, "
                "attitude, time)"
            )
    return models
