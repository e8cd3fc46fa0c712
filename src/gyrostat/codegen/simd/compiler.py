"""The user's C compiler and a cache of compiled libraries."""

import ctypes
import hashlib
import os
import platform
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

# One program treats all lanes alike, so a product and a sum may be one instruction; but nothing is
# taken for finite, and no sum is put in another order.
FLAGS = (
    *("-std=gnu11", "-O2", "-march=native", "-fPIC", "-shared"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math", "-Wno-psabi"),
)
FAST = ("-ffast-math",)
"""More flags, for a benchmark: NaN and infinity are then taken for impossible. Before GCC 13 the
whole process takes subnormal numbers for 0 once such a library is loaded."""


def compiler() -> tuple[str, ...] | None:
    """Words of a command that starts with the C compiler.

    What `CC` names, which may have flags, or cc, gcc or clang; None where there is none.
    """
    named = os.environ.get("CC", "")
    wanted = [(named,), named.split()] if named.split() else [("cc",), ("gcc",), ("clang",)]
    for program, *flags in wanted:
        found = shutil.which(program)
        if found:
            return (found, *flags)
    return None


def required() -> tuple[str, ...]:
    """See `compiler`.

    Raises:
        InputError: there is none.
    """
    found = compiler()
    if found is None:
        raise InputError("C compiler: found none (CC, cc, gcc, clang), expected one for lanes")
    return found


def compiler_version() -> str:
    """First line of what the compiler says of itself, and its flags; "none" without one.

    Raises:
        InputError: it does not run.
    """
    found = compiler()
    return "none" if found is None else _version(found)


@lru_cache
def _version(command: tuple[str, ...]) -> str:
    said = next(iter(_run([*command, "--version"]).splitlines()), "")
    return " ".join([said, *command[1:]])


def instructions() -> str:
    """The vector instructions that code is compiled for."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return platform.machine()
    words = re.search(r"^(?:flags|Features)\s*:(.*)$", text, re.MULTILINE)
    known = sorted(
        w for w in (words[1].split() if words else ()) if re.match("avx|fma|sve|asimd", w)
    )
    return " ".join([platform.machine(), *known])


def header() -> str:
    """Text of the header that lanes need."""
    return files("gyrostat.codegen.simd").joinpath("lanes.h").read_text(encoding="utf-8")


def library(text: str, more: tuple[str, ...] = ()) -> ctypes.CDLL:
    """Compile and load a C module, once in a process.

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


_loaded: dict[str, ctypes.CDLL] = {}


def compiled(text: str, more: tuple[str, ...] = ()) -> bytes:
    """Content of the shared library of a C module: from the cache, or compiled and kept there.

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
    """Run a command that ends, with all that it has started, when this process ends.

    Args:
        command: Program and arguments.
        folder: Where it runs, and has its temporary files; None for here and the usual place.
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
            os.close(write)  # ends the group
            write = -1
            process.wait()
            raise
    finally:
        for handle in (read, write):
            if handle >= 0:
                os.close(handle)
    return CompletedProcess(command, process.returncode, output, error)


# A compiler starts others, which the death of a parent would not reach. A process group of its own
# is killed when the pipe closes whose other end this process alone holds.
_GUARD = (
    'exec 3<&0 </dev/null; (read _ <&3; kill -9 0) >/dev/null 2>&1 & "$@" 3<&-; code=$?; '
    "kill $!; exit $code"
)


def _cache() -> Cache:
    found = private_cache()
    if found is None:
        raise InputError("C compiler: found no private folder, expected one (see GYROSTAT_CACHE)")
    return found


def _entry(text: str, more: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
    """Name of a module's entry in the cache, and the compiler's command without the files."""
    found = required()
    parts = (header(), text, compiler_version(), *FLAGS, *more, instructions())
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    return f"lanes-{digest}", (*found, *FLAGS, *more)


def _compile(cache: Cache, text: str, command: tuple[str, ...]) -> bytes:
    try:
        with cache.workplace() as place:
            (place / "program.c").write_text(text, encoding="utf-8")
            (place / "lanes.h").write_text(header(), encoding="utf-8")
            files = ("-o", "made.so", "program.c", "-lm")
            try:
                _run([*command, *files, "-fopenmp"], place)
            except InputError:  # not every compiler has it; then there is one thread
                _run([*command, *files], place)
            return (place / "made.so").read_bytes()
    except OSError as error:
        raise InputError(
            f"C compiler: found {error}, expected {command[0]} to make a library"
        ) from None


def _load(content: bytes, compiler: str) -> ctypes.CDLL:
    """Load a library from a file written just now, so that it is what was verified.

    The file goes at once; the loaded library stays. The folder of the cache may forbid execution.
    """
    reason: OSError | str = "no private folder"
    for find in (private_cache, temporary_cache):
        cache = find()
        if cache is None:
            continue
        try:
            with cache.workplace() as place:
                (place / "made.so").write_bytes(content)
                return ctypes.CDLL(str(place / "made.so"))
        except OSError as error:
            reason = error
    raise InputError(
        f"C compiler: found {reason}, expected {compiler} to make a library that can be loaded"
    )


def _run(command: Sequence[str], folder: Path | None = None) -> str:
    try:
        done = run_compiler(command, folder)
    except OSError as error:
        raise InputError(f"C compiler: found {error}, expected one that runs") from None
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        said = next((line for line in lines if "error" in line), lines[0])
        raise InputError(f"C compiler: found {said!r} from {command[0]}, expected it to compile")
    return done.stdout
