"""Devices of CUDA, by the functions of its driver."""

import ctypes
import hashlib
from functools import lru_cache
from typing import Any

from gyrostat.codegen.accelerators.device import Usage, Words
from gyrostat.codegen.accelerators.driver import Attribute, call, compiled, compiler_version, driver
from gyrostat.codegen.accelerators.source import source
from gyrostat.core.cache import private_cache

GROUP = 128
"""Work items of a work group."""
LARGEST_ARGUMENT = 4000 // 8 - 8
"""Largest number of words that all runs share, as an argument of the kernel; more are in memory."""


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
        self._options = (f"-arch={architecture}", "-fmad=false", "-std=c++17")
        names = (text.value.decode(), f"driver {version.value}", f"NVRTC {compiler_version()}")
        self.name = ", ".join([*names, *self._options])
        self._kernels: dict[tuple[str, bool], CudaKernel] = {}

    def attribute(self, number: int) -> int:
        """Attribute of the device."""
        value = ctypes.c_int()
        call("cuDeviceGetAttribute", ctypes.byref(value), ctypes.c_int(number), self._device)
        return value.value

    def enter(self) -> None:
        """Use the device in this thread."""
        call("cuCtxSetCurrent", self._context)

    def kernel(self, module: str, shared: int, *, records: bool) -> "CudaKernel":
        """See `Device`; the machine code is stored in the cache."""
        if (module, records) not in self._kernels:
            definitions = {"RECORDS": int(records), "WORK_GROUP": GROUP}
            is_argument = 0 < shared <= LARGEST_ARGUMENT
            if is_argument:
                definitions["SHARED_WORDS"] = shared
            content = self._compiled(source(module, definitions))
            self._kernels[module, records] = CudaKernel(self, content, is_argument=is_argument)
        return self._kernels[module, records]

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
        is_argument: Whether the words that runs share are an argument of the kernel.
    """

    def __init__(self, device: Cuda, content: bytes, *, is_argument: bool):
        device.enter()
        self._device, self._module, self.function = device, ctypes.c_void_p(), ctypes.c_void_p()
        self.is_argument = is_argument
        call("cuModuleLoadData", ctypes.byref(self._module), content)
        name = b"fly_all"
        call("cuModuleGetFunction", ctypes.byref(self.function), self._module, name)

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
            *(ctypes.byref(groups), self.function, ctypes.c_int(GROUP), ctypes.c_size_t(0)),
        )
        occupancy = groups.value * GROUP / self._device.attribute(Attribute.THREADS)
        registers = self._attribute(Attribute.REGISTERS)
        return Usage(registers, self._attribute(Attribute.PRIVATE_BYTES), GROUP, occupancy)


class _Memory:
    """Memory of a device, freed with this object.

    Attributes:
        address: Address on the device.
    """

    def __init__(self, device: Cuda, words: int):
        self._device, self.address = device, ctypes.c_uint64()
        call("cuMemAlloc_v2", ctypes.byref(self.address), ctypes.c_size_t(8 * max(words, 1)))

    def __del__(self) -> None:
        if self.address.value:
            self._device.enter()
            driver().cuMemFree_v2(self.address)

    def at(self, word: int) -> ctypes.c_uint64:
        """Address of a word."""
        return ctypes.c_uint64(self.address.value + 8 * word)


class CudaQueue:
    """See `gyrostat.codegen.accelerators.device.Queue`."""

    def __init__(self, device: Cuda):
        device.enter()
        self._device, self._stream = device, ctypes.c_void_p()
        # 1: does not wait for the default stream
        call("cuStreamCreate", ctypes.byref(self._stream), ctypes.c_uint(1))

    def __del__(self) -> None:
        if self._stream.value:
            self._device.enter()
            driver().cuStreamDestroy_v2(self._stream)

    def memory(self, words: int) -> _Memory:
        """See `Queue`."""
        return _Memory(self._device, words)

    def write(self, memory: _Memory, first: int, words: Words) -> None:
        """See `Queue`."""
        arguments = (memory.at(first), ctypes.c_void_p(words.ctypes.data))
        call("cuMemcpyHtoDAsync_v2", *arguments, ctypes.c_size_t(words.nbytes), self._stream)
        self._wait()  # the array may end now

    def read(self, memory: _Memory, first: int, words: Words) -> None:
        """See `Queue`."""
        arguments = (ctypes.c_void_p(words.ctypes.data), memory.at(first))
        call("cuMemcpyDtoHAsync_v2", *arguments, ctypes.c_size_t(words.nbytes), self._stream)
        self._wait()

    def _wait(self) -> None:
        call("cuStreamSynchronize", self._stream)

    def copy(self, source: _Memory, first: int, target: _Memory, start: int, words: int) -> None:
        """See `Queue`."""
        places = (target.at(start), source.at(first), ctypes.c_size_t(8 * words))
        call("cuMemcpyDtoDAsync_v2", *places, self._stream)

    def launch(
        self, kernel: CudaKernel, shared: Words, memories: list[Any], numbers: list[int]
    ) -> None:
        """See `Queue`."""
        held: list[Any] = [memory.address for memory in memories]
        held += [ctypes.c_int64(number) for number in numbers]
        memory = None
        if kernel.is_argument:
            held.insert(0, (ctypes.c_uint64 * shared.size)(*shared.tolist()))
        else:
            memory = self.memory(shared.size)
            self.write(memory, 0, shared)
            held.insert(0, memory.address)
        pointers = (ctypes.c_void_p * len(held))(*map(ctypes.addressof, held))
        groups = ctypes.c_uint(-(-numbers[0] // GROUP))
        one, none = ctypes.c_uint(1), ctypes.c_uint(0)
        shape = (groups, one, one, ctypes.c_uint(GROUP), one, one)
        call("cuLaunchKernel", kernel.function, *shape, none, self._stream, pointers, None)
        if memory is not None:
            self._wait()
