"""Commands with additional signals that are recorded but not sent to actuators."""

from collections import namedtuple
from functools import cache
from typing import Any

from gyrostat.core.checked import declared_units


def recorded_with(prefix: str, command: Any, signals: Any) -> Any:
    """Command with additional fields.

    Args:
        prefix: Prefix of the name of the new type.
        command: Command, a named tuple.
        signals: Additional fields, a named tuple.
    """
    return _joined(prefix, type(command), type(signals))(*command, *signals)


@cache
def _joined(prefix: str, command: Any, signals: Any) -> Any:
    fields = (*command._fields, *signals._fields)
    made: Any = namedtuple(f"{prefix}{command.__name__}", fields)
    made.UNITS = declared_units(command) | declared_units(signals)
    count = len(command._fields)
    made.__reduce__ = lambda own: (
        recorded_with,
        (prefix, command(*own[:count]), signals(*own[count:])),
    )
    return made
