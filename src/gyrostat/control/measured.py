"""Fields of a measurement that come from further sensors."""

from typing import Any

from gyrostat.core.errors import InputError


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
            f"{controller}: found a measurement of {fields}, expected the field {name} too, from a "
            f"further sensor of this name"
        )
    return getattr(measurement, name)
