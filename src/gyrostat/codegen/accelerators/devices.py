"""Choice of the device of an engine."""

from gyrostat.codegen.accelerators.device import Device
from gyrostat.core.engines import ACCELERATED
from gyrostat.core.errors import InputError


def device(engine: str) -> Device:
    """Device of an engine.

    Args:
        engine: One of `ACCELERATED`.

    Raises:
        InputError: There is no driver, no device or no double precision.
    """
    if engine == "opencl":
        from gyrostat.codegen.accelerators.opencl import opencl

        return opencl()
    if engine == "cuda":
        from gyrostat.codegen.accelerators.cuda import cuda

        return cuda()
    raise InputError(f"engine: found {engine!r}, expected one of {', '.join(ACCELERATED)}")
