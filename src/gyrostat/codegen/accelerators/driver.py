"""Functions of the CUDA driver and of its run-time compiler, called without a further package."""

import ctypes
import ctypes.util
import sys
from collections.abc import Iterator, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing

_VERSIONS = ("13", "12")
"""Major versions of CUDA whose compiler is looked for."""


class Attribute:
    """Numbers of attributes: of a device, of its memory and of a function."""

    PROCESSORS = 16
    WARP = 10
    THREADS = 39
    MAJOR = 75
    MINOR = 76
    THRESHOLD = 4
    PRIVATE_BYTES = 3
    REGISTERS = 4


@lru_cache
def driver() -> ctypes.CDLL:
    """Library of the driver, initialised.

    Raises:
        InputError: There is none, or it finds no device.
    """
    name = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
    try:
        library = ctypes.CDLL(name)
    except OSError:
        raise InputError(
            f"--engine cuda: found no driver {name}, expected an NVIDIA device with its driver"
        ) from None
    count = ctypes.c_int(0)
    if library.cuInit(0) or library.cuDeviceGetCount(ctypes.byref(count)) or not count.value:
        raise InputError("--engine cuda: found no device, expected one that the driver can use")
    return library


def check(code: int, what: str) -> None:
    """Raise an error that names the operation, if the driver returned a code other than 0.

    Raises:
        InputError: The operation failed.
    """
    if code:
        text = ctypes.c_char_p()
        driver().cuGetErrorString(code, ctypes.byref(text))
        reason = (text.value or b"").decode() or f"error {code}"
        raise InputError(f"--engine cuda: found {reason!r} at {what}, expected it to succeed")


def call(name: str, *arguments: Any) -> None:
    """Call a function of the driver.

    Raises:
        InputError: See `check`.
    """
    check(getattr(driver(), name)(*arguments), name)


def _candidates() -> Iterator[str]:
    """Names and paths of the compiler's library: of the toolkit, or of an installed package."""
    for version in _VERSIONS:
        yield f"libnvrtc.so.{version}"
    for folder in map(Path, sys.path):
        for pattern in ("nvidia/*/lib/libnvrtc.so.*", "nvidia/*/bin/nvrtc64_*.dll"):
            yield from map(str, sorted(folder.glob(pattern), reverse=True))
    for version in _VERSIONS:
        yield f"/usr/local/cuda-{version}/lib64/libnvrtc.so.{version}"
    yield "/usr/local/cuda/lib64/libnvrtc.so"


@lru_cache
def _compiler() -> ctypes.CDLL:
    for name in _candidates():
        try:
            return ctypes.CDLL(name)
        except OSError:
            continue
    raise missing("--engine cuda", "compiler NVRTC", "cuda")


def compiler_version() -> str:
    """Version of the compiler.

    Raises:
        InputError: There is no compiler.
    """
    major, minor = ctypes.c_int(), ctypes.c_int()
    _compiler().nvrtcVersion(ctypes.byref(major), ctypes.byref(minor))
    return f"{major.value}.{minor.value}"


def compiled(text: str, options: Sequence[str]) -> bytes:
    """Machine code of a CUDA C++ text.

    Args:
        text: Text.
        options: Options of the compiler, with the architecture sm_NN.

    Raises:
        InputError: There is no compiler, or it refuses the text.
    """
    library = _compiler()
    program = ctypes.c_void_p()
    library.nvrtcCreateProgram(
        ctypes.byref(program), text.encode(), b"program.cu", ctypes.c_int(0), None, None
    )
    try:
        words = (ctypes.c_char_p * len(options))(*(each.encode() for each in options))
        code = library.nvrtcCompileProgram(program, ctypes.c_int(len(options)), words)
        if code:
            log = _text(library, "nvrtcGetProgramLog", program).decode(errors="replace")
            lines = [line for line in log.splitlines() if "error" in line] or [f"error {code}"]
            raise InputError(
                f"--engine cuda: found {lines[0]!r} from NVRTC, expected it to compile"
            )
        return _text(library, "nvrtcGetCUBIN", program)
    finally:
        library.nvrtcDestroyProgram(ctypes.byref(program))


def _text(library: ctypes.CDLL, name: str, program: ctypes.c_void_p) -> bytes:
    """Bytes that the compiler returns."""
    size = ctypes.c_size_t()
    getattr(library, f"{name}Size")(program, ctypes.byref(size))
    content = ctypes.create_string_buffer(size.value)
    getattr(library, name)(program, content)
    return content.raw
