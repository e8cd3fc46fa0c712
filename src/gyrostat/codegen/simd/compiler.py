"""C compiler of the machine, and a cache of compiled libraries."""

import ctypes
import hashlib
import os
import re
import shutil
import subprocess
from collections.abc import Sequence
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from subprocess import CompletedProcess

from gyrostat.core.cache import Cache, private_cache, temporary_cache
from gyrostat.core.errors import InputError
from gyrostat.core.instructions import compiler_flags, instructions

# All lanes run the same instructions, so that a product and a sum may be fused into one. Values may
# be infinite or NaN, and sums are not reordered.
_FLAGS = (
    *("-std=gnu11", "-O2", "-fPIC", "-shared"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-Wno-psabi"),
)
# GCC searches for common expressions (few, after `simplify`) and allocates registers loop by loop
# in times that grow faster than a function. Without, a program compiles in two thirds of the time
# and is as fast.
_GCC = ("-fno-gcse", "-fira-region=one")
FAST = ("-ffast-math",)
"""Further flags for a benchmark: the compiler may then assume that NaN and infinity do not occur.
With GCC before 13, loading such a library makes the whole process treat subnormal numbers as 0."""


def compiler() -> tuple[str, ...] | None:
    """Command line that starts with the C compiler; None if there is none.

    The compiler is the one named by `CC`, which may include flags, otherwise cc, gcc or clang. In
    the native engine, flags of `CC` replace those of `compiler_options`.
    """
    setting = os.environ.get("CC", "")
    commands = [(setting,), setting.split()] if setting.split() else [("cc",), ("gcc",), ("clang",)]
    for program, *flags in commands:
        path = shutil.which(program)
        if path:
            return (path, *flags)
    return None


def require_compiler() -> tuple[str, ...]:
    """Command line of the compiler; see `compiler`.

    Raises:
        InputError: There is no compiler.
    """
    command = compiler()
    if command is None:
        raise InputError(
            "C compiler: found none (CC, cc, gcc, clang), expected one for the native engine"
        )
    return command


def compiler_version() -> str:
    """First line of the compiler's version text, and its flags; "none" without a compiler.

    Raises:
        InputError: The compiler does not run.
    """
    command = compiler()
    if command is None:
        return "none"
    return " ".join([next(iter(_version(command).splitlines()), ""), *command[1:]])


def compiler_options() -> tuple[str, ...]:
    """Flags of the native engine for this compiler; those for its processor come after them.

    Raises:
        InputError: The compiler does not run.
    """
    command = compiler()
    # a compiler that is like GCC need not know GCC's optimisations
    is_gcc = command is not None and "Free Software Foundation" in _version(command)
    return (*_FLAGS, *(_GCC if is_gcc else ()))


@lru_cache
def _version(command: tuple[str, ...]) -> str:
    """Text about the compiler's version."""
    return output_of([*command, "--version"])


def header(name: str = "lanes.h") -> str:
    """Text of a header file of this folder, with the files of this folder that it includes."""
    text = files("gyrostat.codegen.simd").joinpath(name).read_text(encoding="utf-8")
    return re.sub(r'^#include "(.*)"\n', lambda line: header(line[1]), text, flags=re.MULTILINE)


def library(text: str, more: tuple[str, ...] = ()) -> ctypes.CDLL:
    """Compile and load a C module, once per process.

    Args:
        text: Source of the module.
        more: Additional flags.

    Raises:
        InputError: There is no compiler, it fails, or the library cannot be loaded.
    """
    name, command = _entry(text, more)
    if name not in _loaded:
        _loaded[name] = _load(compiled(text, more), command[0])
    return _loaded[name]


def stored_library(name: str) -> ctypes.CDLL | None:
    """Load a library that was compiled before, once per process.

    Args:
        name: Its name; see `library_name`.

    Returns:
        The library; None if the cache does not have it.

    Raises:
        InputError: The library cannot be loaded.
    """
    if name not in _loaded:
        content = _cache().read(name)
        if content is None:
            return None
        _loaded[name] = _load(content, require_compiler()[0])
    return _loaded[name]


def delivered_library(content: bytes) -> ctypes.CDLL:
    """Load a library that another machine has compiled, once per process.

    Args:
        content: Shared library.

    Raises:
        InputError: It cannot be loaded.
    """
    name = f"delivered-{hashlib.sha256(content).hexdigest()}"
    if name not in _loaded:
        _loaded[name] = _load(content, "the delivered program")
    return _loaded[name]


def library_name(text: str, more: tuple[str, ...] = ()) -> str:
    """Name of the library of a C module in the cache.

    Args:
        text: Source of the module.
        more: Additional flags.

    Raises:
        InputError: There is no compiler.
    """
    return _entry(text, more)[0]


_loaded: dict[str, ctypes.CDLL] = {}


def compiled(text: str, more: tuple[str, ...] = ()) -> bytes:
    """Shared library of a C module, as bytes: from the cache, or compiled and added to it.

    Args:
        text: Source of the module.
        more: Additional flags.

    Raises:
        InputError: There is no compiler, or it fails.
    """
    name, command = _entry(text, more)
    cache = _cache()
    content = cache.read(name)
    if content is None:
        content = _compile(cache, text, command)
        cache.write(name, content)
    return content


def run_compiler(command: Sequence[str], folder: Path | None = None) -> CompletedProcess[str]:
    """Run a command that is ended, with its child processes, when this process ends.

    Args:
        command: Program and arguments.
        folder: Working folder, also for temporary files; None for the current and default ones.
    """
    environment = {**os.environ, **({"TMPDIR": str(folder)} if folder else {})}
    read, write = os.pipe()
    try:
        process = subprocess.Popen(
            ["/bin/sh", "-c", _GUARD, "sh", *command],
            stdin=read,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            cwd=folder,
            env=environment,
            process_group=0,
        )
        os.close(read)
        read = -1
        try:
            output, error = process.communicate()
        except BaseException:
            os.close(write)  # ends the process group
            write = -1
            process.wait()
            raise
    finally:
        for handle in (read, write):
            if handle >= 0:
                os.close(handle)
    return CompletedProcess(command, process.returncode, output, error)


# A compiler starts child processes, which survive the death of their parent. They are therefore put
# in a process group. Only this process holds the write end of a pipe; when it closes, the group is
# killed.
_GUARD = (
    'exec 3<&0 </dev/null; (read _ <&3; kill -9 0) >/dev/null 2>&1 & "$@" 3<&-; code=$?; '
    "kill $!; exit $code"
)


def _cache() -> Cache:
    cache = private_cache()
    if cache is None:
        raise InputError("C compiler: found no private folder, expected one (see GYROSTAT_CACHE)")
    return cache


def _entry(text: str, flags: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
    """Name of a module's entry in the cache, and the compiler's command without the files."""
    base = require_compiler()
    # the last of contradicting flags counts
    words = [*base, "-"]
    count = next(k for k, word in enumerate(words) if word.startswith("-"))
    command = (*base[:count], *compiler_options(), *compiler_flags(), *flags, *base[count:])
    parts = (header(), text, compiler_version(), *command[1:], instructions())
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    return f"lanes-{digest}", command


def _compile(cache: Cache, text: str, command: tuple[str, ...]) -> bytes:
    try:
        with cache.workplace() as folder:
            (folder / "program.c").write_text(text, encoding="utf-8")
            (folder / "lanes.h").write_text(header(), encoding="utf-8")
            files = ("-o", "made.so", "program.c", "-lm")
            try:
                output_of([*command, *files, "-fopenmp"], folder)
            except InputError:  # without support in the compiler, one thread is used
                output_of([*command, *files], folder)
            return (folder / "made.so").read_bytes()
    except OSError as error:
        raise InputError(
            f"C compiler: found {error}, expected {command[0]} to make a library"
        ) from None


def _load(content: bytes, origin: str) -> ctypes.CDLL:
    """Load a library from a file just written, so that exactly the verified bytes are loaded.

    The file is deleted at once; the library stays loaded. The cache folder may forbid execution.
    """
    reason: OSError | str = "no private folder"
    for find in (private_cache, temporary_cache):
        cache = find()
        if cache is None:
            continue
        try:
            with cache.workplace() as folder:
                (folder / "made.so").write_bytes(content)
                return ctypes.CDLL(str(folder / "made.so"))
        except OSError as error:
            reason = error
    raise InputError(
        f"C compiler: found {reason}, expected {origin} to be a library that can be loaded"
    )


def output_of(command: Sequence[str], folder: Path | None = None) -> str:
    """Output of a compiler; raises `InputError` if it does not run, or fails."""
    try:
        process = run_compiler(command, folder)
    except OSError as error:
        raise InputError(f"C compiler: found {error}, expected one that runs") from None
    if process.returncode != 0:
        lines = process.stderr.strip().splitlines() or [f"exit code {process.returncode}"]
        message = next((line for line in lines if "error" in line), lines[0])
        raise InputError(f"C compiler: found {message!r} from {command[0]}, expected it to compile")
    return process.stdout
