"""Memory of a controller after a period whose sample is missing."""

from typing import Any


def predicted(controller: Any, memory: Any, measurement: Any, command: Any) -> Any:
    """Memory of a controller one period later without a sample.

    Args:
        controller: With or without a method `predicted`.
        memory: From the last sample.
        measurement: Last one that was accepted.
        command: That is sent.
    """
    own = getattr(controller, "predicted", None)
    return memory if own is None else own(memory, measurement, command)
