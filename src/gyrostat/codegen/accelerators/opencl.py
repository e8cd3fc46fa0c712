"""Devices of OpenCL, by pyopencl."""

import warnings
from functools import lru_cache
from typing import Any

import numpy as np

from gyrostat.codegen.accelerators.device import Usage, Words
from gyrostat.codegen.accelerators.source import source
from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing

GROUP = 64
"""Work items of a work group; 1 on a processor, whose compiler takes long to join them."""
_OPTIONS = "-cl-std=CL1.2"


@lru_cache
def opencl() -> "OpenCL":
    """Device with double precision, rather a GPU than a processor.

    Raises:
        InputError: There is no pyopencl, no driver or no such device.
    """
    try:
        import pyopencl as cl  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise missing("--engine opencl", "pyopencl", "opencl") from None
    try:
        devices = [each for platform in cl.get_platforms() for each in platform.get_devices()]
    except cl.Error:
        devices = []
    exact = [each for each in devices if "cl_khr_fp64" in each.extensions]
    if not exact:
        found = ", ".join(each.name for each in devices) or "none"
        raise InputError(
            f"--engine opencl: found devices {found}, expected one with double precision "
            "(cl_khr_fp64) and its driver"
        )
    order = (cl.device_type.GPU, cl.device_type.ACCELERATOR)
    return OpenCL(cl, min(exact, key=lambda each: not any(each.type & kind for kind in order)))


class OpenCL:
    """See `gyrostat.codegen.accelerators.device.Device`."""

    def __init__(self, cl: Any, device: Any):
        self.cl, self.device = cl, device
        self.context = cl.Context([device])
        self.group = 1 if device.type & cl.device_type.CPU else GROUP
        names = (device.platform.name, device.name, device.version, device.driver_version, _OPTIONS)
        self.name = ", ".join(map(str, names))
        self._kernels: dict[tuple[str, bool], OpenCLKernel] = {}

    def kernel(self, module: str, shared: int, *, records: bool) -> "OpenCLKernel":
        """See `Device`; the words that runs share are in global memory."""
        del shared
        if (module, records) not in self._kernels:
            definitions = {"RECORDS": int(records), "WORK_GROUP": self.group}
            try:
                program = self.cl.Program(self.context, source(module, definitions))
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # those of the compiler
                    program.build(_OPTIONS)
            except self.cl.Error as error:
                lines = [line for line in str(error).splitlines() if "error" in line.lower()]
                raise InputError(
                    f"--engine opencl: found {lines[0]!r} from {self.device.name}, expected it to "
                    "compile"
                ) from None
            self._kernels[module, records] = OpenCLKernel(self, program)
        return self._kernels[module, records]

    def queue(self) -> "OpenCLQueue":
        """See `Device`."""
        return OpenCLQueue(self)


class OpenCLKernel:
    """See `gyrostat.codegen.accelerators.device.Kernel`."""

    def __init__(self, device: OpenCL, program: Any):
        self.device, self.program = device, program

    @property
    def usage(self) -> Usage:
        """See `Kernel`; OpenCL tells neither registers nor occupancy."""
        kind = self.device.cl.kernel_work_group_info.PRIVATE_MEM_SIZE
        kernel = self.device.cl.Kernel(self.program, "fly_all")
        private = kernel.get_work_group_info(kind, self.device.device)
        return Usage(None, int(private) or None, self.device.group, None)


class OpenCLQueue:
    """See `gyrostat.codegen.accelerators.device.Queue`."""

    def __init__(self, device: OpenCL):
        self._device, self._cl = device, device.cl
        self._queue = device.cl.CommandQueue(device.context)

    def memory(self, words: int) -> Any:
        """See `Queue`."""
        flags = self._cl.mem_flags.READ_WRITE
        return self._cl.Buffer(self._device.context, flags, 8 * max(words, 1))

    def write(self, memory: Any, first: int, words: Words) -> None:
        """See `Queue`."""
        if words.size:
            self._cl.enqueue_copy(self._queue, memory, words, dst_offset=8 * first)

    def read(self, memory: Any, first: int, words: Words) -> None:
        """See `Queue`."""
        if words.size:
            self._cl.enqueue_copy(self._queue, words, memory, src_offset=8 * first)

    def copy(self, source: Any, first: int, target: Any, start: int, words: int) -> None:
        """See `Queue`."""
        places = {"src_offset": 8 * first, "dst_offset": 8 * start, "byte_count": 8 * words}
        self._cl.enqueue_copy(self._queue, target, source, **places)

    def launch(
        self, kernel: OpenCLKernel, shared: Words, memories: list[Any], numbers: list[int]
    ) -> None:
        """See `Queue`."""
        memory = self.memory(shared.size)
        self.write(memory, 0, shared)
        function = self._cl.Kernel(kernel.program, "fly_all")
        function.set_args(memory, *memories, *map(np.int64, numbers))
        group = self._device.group
        size = -(-numbers[0] // group) * group
        self._cl.enqueue_nd_range_kernel(self._queue, function, (size,), (group,))
