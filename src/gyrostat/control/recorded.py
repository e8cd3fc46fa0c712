"""Commands with signals beside them that are recorded and do not go to actuators."""

from collections import namedtuple
from functools import cache
from typing import Any

from gyrostat.core.checked import declared_units


def recorded_with(prefix: str, command: Any, signals: Any) -> Any:
    """A command with further fields.

    Args:
        prefix: Of the name of its type.
        command: Named tuple.
        signals: Named tuple of the further fields.
    """
    return _joined(prefix, type(command), type(signals))(*command, *signals)


@cache
def _joined(prefix: str, command: Any, signals: Any) -> Any:
    fields = (*command._fields, *signals._fields)
    made: Any = namedtuple(f"{prefix}{command.__name__}", fields)
    made.UNITS = declared_units(command) | declared_units(signals)
    return made
