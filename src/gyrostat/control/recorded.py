"""Commands with additional signals that are recorded but not sent to actuators."""

from typing import Any

from gyrostat.core.checked import declared_units
from gyrostat.core.named_tuples import with_fields


def recorded_with(prefix: str, command: Any, signals: Any) -> Any:
    """Command with additional fields.

    Args:
        prefix: Prefix of the name of the new type.
        command: Command, a named tuple.
        signals: Additional fields, a named tuple.
    """
    return with_fields(prefix, command, signals._asdict(), declared_units(type(signals)))
