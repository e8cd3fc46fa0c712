"""Fields of a measurement that come from further sensors or from a friction compensator."""

from typing import Any

from gyrostat.core.arrays import PerWheel
from gyrostat.core.errors import InputError
from gyrostat.core.named_tuples import with_fields


def measured(measurement: Any, name: str, controller: str) -> Any:
    """Field of a measurement.

    Args:
        measurement: Measurement.
        name: Name of the field.
        controller: Name of the controller, for the message.

    Raises:
        InputError: The measurement has no such field.
    """
    if not hasattr(measurement, name):
        fields = ", ".join(getattr(measurement, "_fields", ())) or "no fields"
        raise InputError(
            f"{controller}: found a measurement of {fields}, expected the field {name} too, from "
            f"an added sensor of this name"
        )
    return getattr(measurement, name)


def with_wheel_friction(measurement: Any, friction: PerWheel) -> Any:
    """Add the compensated friction to the measurement that the wrapped controller gets.

    Args:
        measurement: Measurement.
        friction: Friction torque that the compensator compensates, (wheels,), N·m. The field
            `wheel_friction` is the sum over all compensators around the controller.
    """
    if hasattr(measurement, "wheel_friction"):
        return measurement._replace(wheel_friction=measurement.wheel_friction + friction)
    unit = {"wheel_friction": "N·m"}
    return with_fields("Compensated", measurement, {"wheel_friction": friction}, unit)
