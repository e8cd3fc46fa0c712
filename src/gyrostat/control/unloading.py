"""What momentum unloading by rods and by thrusters has in common."""

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
    torque: Vector3,
    share: Scalar,
    *,
    name: str,
    adds: bool,
) -> Any:
    """Command with that of the actuator, and with its torque compensated by the wheels.

    Args:
        wheels: Wheels as the controller knows them.
        command: Command of the controller.
        actuator: Command of the actuator, a named tuple of one field.
        torque: Expected torque of the actuator, body axes, (3,), N·m.
        share: Share of this torque that is added to the wheel torques.
        name: Name of the actuator, for the message.
        adds: Whether the controller may command the actuator itself, to which that of the unloading
            is added: laws of modes do so in modes of theirs.

    Raises:
        InputError: The controller commands this actuator itself, and must not.
    """
    common = {n: getattr(command, n) for n in actuator._fields if hasattr(command, n)}
    if common and not adds:
        raise InputError(
            f"unloading: found a controller that commands {name} itself, expected one that "
            "commands only wheels"
        )
    works = getattr(command, "works", jnp.ones(wheels.count, bool))
    compensation = spread(jnp.asarray(wheels.axes), works) @ (share * torque)
    total = wheels.within_torque_limit(command.torque + compensation)
    command = command._replace(torque=total)
    if common:
        return command._replace(**{n: each + getattr(actuator, n) for n, each in common.items()})
    return recorded_with("Unloading", command, actuator)
