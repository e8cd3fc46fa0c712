"""What momentum unloading by rods and by thrusters has in common."""

from collections.abc import Callable
from typing import Any

from gyrostat.control.allocation.allocation import spread
from gyrostat.control.recorded import recorded_with
from gyrostat.core.arrays import PerWheel, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.wheel import WheelArray


def excess_momentum(wheels: WheelArray, speed: PerWheel, target: Vector3) -> Vector3:
    """Momentum of the wheels above its target, body axes, (3,), N·m·s.

    Args:
        wheels: Wheels as the controller knows them.
        speed: Measured wheel speeds, (wheels,), rad/s.
        target: Target of the momentum, (3,), N·m·s.
    """
    return jnp.asarray(wheels.axes) @ (wheels.inertia * speed) - target


def acting(in_modes: Any, command: Any) -> Scalar:
    """Whether an unloading acts, 0 or 1, in the mode that is recorded with a command.

    Args:
        in_modes: Whether it acts in each mode, (modes,); None: it acts always.
        command: Command of a controller that follows a reference, with `mode`.
    """
    return 1.0 if in_modes is None else jnp.asarray(in_modes)[command.mode]


def with_unloading(
    wheels: WheelArray,
    command: Any,
    actuator: Any,
    torque: Callable[[Any], Vector3],
    share: Scalar,
    *,
    limit: Any,
    name: str,
    in_modes: Any,
) -> Any:
    """Command with that of the actuator, and with its torque compensated by the wheels.

    Laws of modes may command the actuator themselves. In modes in which the unloading acts, the sum
    is limited, and what the unloading changes of it is compensated; in the others, the command is
    that of the law.

    Args:
        wheels: Wheels as the controller knows them.
        command: Command of the controller.
        actuator: Command of the actuator, a named tuple of one field.
        torque: Expected torque of a command of the actuator, body axes, (3,), N·m.
        share: Share of this torque that is added to the wheel torques.
        limit: Largest size of the command of the actuator.
        name: Name of the actuator, for the message.
        in_modes: See `acting`; None: the controller must not command the actuator itself.

    Raises:
        InputError: The controller commands this actuator itself, and must not.
    """
    field, added = actuator._fields[0], actuator[0]
    has_law = hasattr(command, field)
    if has_law and in_modes is None:
        raise InputError(
            f"unloading: found a controller that commands {name} itself, expected one that "
            "commands only wheels"
        )
    if has_law:
        law, acts = getattr(command, field), acting(in_modes, command) > 0.0
        total = jnp.where(acts, jnp.clip(law + added, -limit, limit), law)
        added = jnp.where(acts, total - jnp.clip(law, -limit, limit), 0.0)
        command = command._replace(**{field: total})
    works = getattr(command, "works", jnp.ones(wheels.count, bool))
    compensation = spread(jnp.asarray(wheels.axes), works) @ (share * torque(added))
    command = command._replace(torque=wheels.within_torque_limit(command.torque + compensation))
    return command if has_law else recorded_with("Unloading", command, actuator)
