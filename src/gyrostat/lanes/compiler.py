"""The user's C compiler, and a cache of what it has made."""

import ctypes
import hashlib
import os
import platform
import re
import shutil
import subprocess
import tempfile
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

from gyrostat.errors import InputError

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
    return files("gyrostat.lanes").joinpath("lanes.h").read_text(encoding="utf-8")


def cache() -> Path:
    """Folder of what was compiled: `GYROSTAT_CACHE`, or gyrostat in the user's cache."""
    own = os.environ.get("GYROSTAT_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "gyrostat"


def library(text: str, more: tuple[str, ...] = ()) -> ctypes.CDLL:
    """Compile a C module, or find it compiled.

    Args:
        text: of the module.
        more: flags.

    Raises:
        InputError: there is no compiler, or it refuses, or what it made cannot be loaded.
    """
    found = required()
    parts = (header(), text, compiler_version(), *FLAGS, *more, instructions())
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    command = (*found, *FLAGS, *more)
    try:
        folder = cache()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        return _in_folder(folder, digest, text, command)
    except (OSError, RuntimeError):  # no home, or no place to keep it where it can be loaded
        pass
    try:
        with tempfile.TemporaryDirectory() as folder:
            return _in_folder(Path(folder), digest, text, command)
    except OSError as error:
        raise InputError(
            f"C compiler: found {error}, expected {found[0]} to make a library that can be loaded"
        ) from None


def _in_folder(folder: Path, digest: str, text: str, command: tuple[str, ...]) -> ctypes.CDLL:
    made = folder.absolute() / f"lanes-{digest}.so"
    if made.exists():
        try:
            return ctypes.CDLL(str(made))
        except OSError:  # it is not whole, and is made again
            pass
    with tempfile.TemporaryDirectory(dir=folder) as place:
        source = Path(place) / "program.c"
        source.write_text(text, encoding="utf-8")
        (Path(place) / "lanes.h").write_text(header(), encoding="utf-8")
        command = (*command, "-o", f"{place}/made.so", str(source), "-lm")
        try:
            _run([*command, "-fopenmp"])
        except InputError:  # not every compiler has it; then there is one thread
            _run([*command])
        os.replace(f"{place}/made.so", made)
    return ctypes.CDLL(str(made))


def _run(command: list[str]) -> str:
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, errors="replace", check=False
        )
    except OSError as error:
        raise InputError(f"C compiler: found {error}, expected one that runs") from None
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        said = next((line for line in lines if "error" in line), lines[0])
        raise InputError(f"C compiler: found {said!r} from {command[0]}, expected it to compile")
    return done.stdout
