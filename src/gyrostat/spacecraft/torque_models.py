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


class CommandedTorque(eqx.Module):
    """Torque of an actuator at a constant command, as an environment torque.

    Attributes:
        name: Name of the actuator.
        actuator: Actuator.
        value: Its command.
    """

    name: str = eqx.field(static=True)
    actuator: Actuator
    value: Any

    def __repr__(self) -> str:
        return with_values(self)

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """See `TorqueModel`."""
        del spacecraft
        torque = self.actuator(self.value, attitude, time)
        return body_torque(torque, f"actuator {self.name}")


def commanded_torques(
    actuators: Mapping[str, Actuator], command: Any
) -> tuple[CommandedTorque, ...]:
    """Torques of actuators, each driven by the field of the command that has its name.

    Args:
        actuators: Name -> actuator.
        command: Command, a named tuple.

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
        CommandedTorque(name, actuator, getattr(command, name))
        for name, actuator in sorted(actuators.items())
    )


def under_command(plant: Any, command: Any) -> Any:
    """Gyrostat with the torques of its actuators at a command as external torques.

    Args:
        plant: `gyrostat.spacecraft.Gyrostat`.
        command: Command, a named tuple.

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
        given = plant.external_torque + jnp.clip(command.external_torque, -limit, limit)
        plant = eqx.tree_at(lambda each: each.external_torque, plant, given)
    if plant.actuators:
        commanded = commanded_torques(plant.actuators, command)
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
            shown = f"the class {model.__name__}" if isinstance(model, type) else repr(model)
            raise InputError(
                f"environment: found {shown}, expected torque models, called with (spacecraft, "
                "attitude, time)"
            )
    return models
