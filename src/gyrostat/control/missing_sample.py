"""Memory of a controller after a control period without a sample."""

from typing import Any


def predicted(controller: Any, memory: Any, measurement: Any, command: Any) -> Any:
    """Memory of a controller one control period later, without a sample.

    Args:
        controller: Controller, with or without a method `predicted`. Without it, the memory is
            unchanged.
        memory: Memory from the last sample.
        measurement: Last accepted measurement.
        command: Safe command that is sent.
    """
    method = getattr(controller, "predicted", None)
    return memory if method is None else method(memory, measurement, command)
