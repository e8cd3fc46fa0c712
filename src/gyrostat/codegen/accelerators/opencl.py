"""Devices of OpenCL, by pyopencl."""

import warnings
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from gyrostat.codegen.accelerators.device import Usage, Words
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
        self.by_value = 0
        self._kernels: dict[str, OpenCLKernel] = {}

    def kernel(self, text: str, name: str) -> "OpenCLKernel":
        """See `Device`."""
        if text not in self._kernels:
            try:
                program = self.cl.Program(self.context, text)
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # those of the compiler
                    program.build(_OPTIONS)
            except self.cl.Error as error:
                lines = [line for line in str(error).splitlines() if "error" in line.lower()]
                raise InputError(
                    f"--engine opencl: found {lines[0]!r} from {self.device.name}, expected it to "
                    "compile"
                ) from None
            self._kernels[text] = OpenCLKernel(self, program, name)
        return self._kernels[text]

    def queue(self) -> "OpenCLQueue":
        """See `Device`."""
        return OpenCLQueue(self)


class OpenCLKernel:
    """See `gyrostat.codegen.accelerators.device.Kernel`."""

    def __init__(self, device: OpenCL, program: Any, name: str):
        self._device, self._program, self._name = device, program, name

    def function(self) -> Any:
        """Kernel with arguments of its own."""
        return self._device.cl.Kernel(self._program, self._name)

    @property
    def usage(self) -> Usage:
        """See `Kernel`; OpenCL tells neither registers nor occupancy."""
        kind = self._device.cl.kernel_work_group_info.PRIVATE_MEM_SIZE
        private = self.function().get_work_group_info(kind, self._device.device)
        return Usage(None, int(private) or None, self._device.group, None)


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

    def launch(self, kernel: OpenCLKernel, runs: int, arguments: Sequence[Any]) -> None:
        """See `Queue`."""
        function = kernel.function()
        values = [self._argument(each) for each in arguments]  # until the kernel is enqueued
        function.set_args(*values)
        group = self._device.group
        size = -(-runs // group) * group
        self._cl.enqueue_nd_range_kernel(self._queue, function, (size,), (group,))

    def _argument(self, value: Any) -> Any:
        if isinstance(value, int):
            return np.int64(value)
        if isinstance(value, np.ndarray):
            memory = self.memory(value.size)
            self.write(memory, 0, value)
            return memory
        return value
