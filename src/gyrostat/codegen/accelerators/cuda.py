"""Devices of CUDA, by the functions of its driver."""

import ctypes
import hashlib
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from gyrostat.codegen.accelerators.device import Usage, Words
from gyrostat.codegen.accelerators.driver import Attribute, call, compiled, compiler_version, driver
from gyrostat.core.cache import private_cache

GROUP = 256
"""Work items of a work group: with 255 registers each, all that a processor holds. They execute the
same instructions at about the same time."""
BY_VALUE = 480
"""Words of an argument: of the 4096 bytes of all arguments, less those of the others."""


@lru_cache
def cuda() -> "Cuda":
    """First device of the driver; the variable CUDA_VISIBLE_DEVICES chooses another one.

    Raises:
        InputError: There is no driver, no device or no compiler.
    """
    return Cuda()


class Cuda:
    """See `gyrostat.codegen.accelerators.device.Device`."""

    def __init__(self) -> None:
        driver()
        self._device, self._context = ctypes.c_int(), ctypes.c_void_p()
        call("cuDeviceGet", ctypes.byref(self._device), ctypes.c_int(0))
        call("cuDevicePrimaryCtxRetain", ctypes.byref(self._context), self._device)
        text, version = ctypes.create_string_buffer(256), ctypes.c_int()
        call("cuDeviceGetName", text, ctypes.c_int(256), self._device)
        call("cuDriverGetVersion", ctypes.byref(version))
        architecture = f"sm_{self.attribute(Attribute.MAJOR)}{self.attribute(Attribute.MINOR)}"
        pool, threshold = ctypes.c_void_p(), ctypes.c_uint64(2**64 - 1)
        call("cuDeviceGetDefaultMemPool", ctypes.byref(pool), self._device)
        # memory that is freed stays with this process
        call("cuMemPoolSetAttribute", pool, Attribute.THRESHOLD, ctypes.byref(threshold))
        self._options = (f"-arch={architecture}", "-fmad=false", "-std=c++17")
        names = (text.value.decode(), f"driver {version.value}", f"NVRTC {compiler_version()}")
        self.name = ", ".join([*names, *self._options])
        self.group, self.by_value = GROUP, BY_VALUE
        self._kernels: dict[str, CudaKernel] = {}

    def attribute(self, number: int) -> int:
        """Attribute of the device."""
        value = ctypes.c_int()
        call("cuDeviceGetAttribute", ctypes.byref(value), ctypes.c_int(number), self._device)
        return value.value

    def enter(self) -> None:
        """Use the device in this thread."""
        call("cuCtxSetCurrent", self._context)

    def kernel(self, text: str, name: str) -> "CudaKernel":
        """See `Device`; the machine code is stored in the cache."""
        if text not in self._kernels:
            self._kernels[text] = CudaKernel(self, self._compiled(text), name)
        return self._kernels[text]

    def _compiled(self, text: str) -> bytes:
        digest = hashlib.sha256("\0".join((text, self.name)).encode()).hexdigest()
        cache = private_cache()
        content = None if cache is None else cache.read(f"kernel-{digest}")
        if content is None:
            content = compiled(text, self._options)
            if cache is not None:
                cache.write(f"kernel-{digest}", content)
        return content

    def queue(self) -> "CudaQueue":
        """See `Device`."""
        return CudaQueue(self)


class CudaKernel:
    """See `gyrostat.codegen.accelerators.device.Kernel`.

    Attributes:
        function: Handle of the driver.
    """

    def __init__(self, device: Cuda, content: bytes, name: str):
        device.enter()
        self._device, self._module, self.function = device, ctypes.c_void_p(), ctypes.c_void_p()
        call("cuModuleLoadData", ctypes.byref(self._module), content)
        call("cuModuleGetFunction", ctypes.byref(self.function), self._module, name.encode())

    def _attribute(self, number: int) -> int:
        value = ctypes.c_int()
        call("cuFuncGetAttribute", ctypes.byref(value), ctypes.c_int(number), self.function)
        return value.value

    @property
    def usage(self) -> Usage:
        """See `Kernel`."""
        self._device.enter()
        groups = ctypes.c_int()
        call(
            "cuOccupancyMaxActiveBlocksPerMultiprocessor",
            *(ctypes.byref(groups), self.function),
            *(ctypes.c_int(self._device.group), ctypes.c_size_t(0)),
        )
        group = self._device.group
        occupancy = groups.value * group / self._device.attribute(Attribute.THREADS)
        registers = self._attribute(Attribute.REGISTERS)
        return Usage(registers, self._attribute(Attribute.PRIVATE_BYTES), group, occupancy)


class _Memory:
    """Memory of a queue, freed with this object after the operations of the queue so far.

    Attributes:
        address: Address on the device.
    """

    def __init__(self, queue: "CudaQueue", words: int):
        self._queue, self.address = queue, ctypes.c_uint64()
        size = ctypes.c_size_t(8 * max(words, 1))
        call("cuMemAllocAsync", ctypes.byref(self.address), size, queue.stream)

    def __del__(self) -> None:
        if self.address.value:
            self._queue.enter()
            driver().cuMemFreeAsync(self.address, self._queue.stream)

    def at(self, word: int) -> ctypes.c_uint64:
        """Address of a word."""
        return ctypes.c_uint64(self.address.value + 8 * word)


class CudaQueue:
    """See `gyrostat.codegen.accelerators.device.Queue`.

    Attributes:
        stream: Handle of the driver.
    """

    def __init__(self, device: Cuda):
        device.enter()
        self._device, self.stream, self.enter = device, ctypes.c_void_p(), device.enter
        # 1: does not wait for the default stream
        call("cuStreamCreate", ctypes.byref(self.stream), ctypes.c_uint(1))

    def __del__(self) -> None:
        if self.stream.value:
            self._device.enter()
            driver().cuStreamDestroy_v2(self.stream)

    def memory(self, words: int) -> _Memory:
        """See `Queue`."""
        return _Memory(self, words)

    def write(self, memory: _Memory, first: int, words: Words) -> None:
        """See `Queue`."""
        arguments = (memory.at(first), ctypes.c_void_p(words.ctypes.data))
        call("cuMemcpyHtoDAsync_v2", *arguments, ctypes.c_size_t(words.nbytes), self.stream)
        self._wait()  # the array may end now

    def read(self, memory: _Memory, first: int, words: Words) -> None:
        """See `Queue`."""
        arguments = (ctypes.c_void_p(words.ctypes.data), memory.at(first))
        call("cuMemcpyDtoHAsync_v2", *arguments, ctypes.c_size_t(words.nbytes), self.stream)
        self._wait()

    def _wait(self) -> None:
        call("cuStreamSynchronize", self.stream)

    def copy(self, source: _Memory, first: int, target: _Memory, start: int, words: int) -> None:
        """See `Queue`."""
        places = (target.at(start), source.at(first), ctypes.c_size_t(8 * words))
        call("cuMemcpyDtoDAsync_v2", *places, self.stream)

    def launch(self, kernel: CudaKernel, runs: int, arguments: Sequence[Any]) -> None:
        """See `Queue`."""
        held = [
            self._uploaded(each) if isinstance(each, np.ndarray) else each for each in arguments
        ]
        values = [_value(each) for each in held]
        pointers = (ctypes.c_void_p * len(values))(*map(ctypes.addressof, values))
        group = self._device.group
        one, none = ctypes.c_uint(1), ctypes.c_uint(0)
        shape = (ctypes.c_uint(-(-runs // group)), one, one, ctypes.c_uint(group), one, one)
        call("cuLaunchKernel", kernel.function, *shape, none, self.stream, pointers, None)

    def _uploaded(self, words: Words) -> Any:
        """Words in memory, unless they are few enough for an argument by value."""
        if 0 < words.size <= self._device.by_value:
            return words
        memory = self.memory(words.size)
        self.write(memory, 0, words)
        return memory


def _value(argument: Any) -> Any:
    """Argument of a kernel as a value of C."""
    if isinstance(argument, int):
        return ctypes.c_int64(argument)
    if isinstance(argument, np.ndarray):
        return (ctypes.c_uint64 * argument.size)(*argument.tolist())
    return argument.address
