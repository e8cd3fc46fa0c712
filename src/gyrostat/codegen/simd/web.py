"""WebAssembly from C modules for SIMD lanes, by zig or clang, whichever is installed."""

import hashlib
import importlib.util
import shutil
import sys
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

from gyrostat.codegen.simd.compiler import header, output_of, run_compiler
from gyrostat.core.cache import private_cache
from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing

_FLAGS = (
    *("-msimd128", "-std=gnu11", "-O2", "-ffp-contract=off", "-fno-math-errno"),
    *("-fno-trapping-math", "-Wno-psabi", "-Wno-unknown-pragmas"),
    "-Wno-unused-command-line-argument",
)
_LINK = ("-Wl,--no-entry", "-Wl,--export=__heap_base", "-Wl,-s", "-Wl,-z,stack-size=4194304")
_CLANG = ("clang", *(f"clang-{version}" for version in range(24, 13, -1)))
_PROBE = "#include <math.h>\ndouble probe(double x) { return sin(x); }\n"
_ABI = 1


@lru_cache
def web_compiler() -> tuple[str, ...] | None:
    """Command line of a compiler for WebAssembly; None if there is none.

    clang is used where it finds the headers and the library of WASI (wasi-libc) and the linker of
    LLVM (lld), otherwise zig: its program, or the package ziglang of this Python.
    """
    for name in _CLANG:
        path = shutil.which(name)
        if path is not None:
            # below its own data, so that a program whose stack is too small stops
            command = (path, "--target=wasm32-wasi", "-nostartfiles", "-Wl,--stack-first")
            if _compiles(command):
                return command
    zig = shutil.which("zig")
    program = None if zig is None else (zig,)
    if importlib.util.find_spec("ziglang") is not None:
        program = (sys.executable, "-m", "ziglang")
    if program is None:
        return None
    return (*program, "cc", "-target", "wasm32-wasi", "-mexec-model=reactor")


def require_web_compiler(where: str = "--fly") -> tuple[str, ...]:
    """Command line of the compiler; see `web_compiler`.

    Args:
        where: Option that needs it.

    Raises:
        InputError: There is none.
    """
    command = web_compiler()
    if command is None:
        error = missing(where, "compiler for WebAssembly", "fly")
        raise InputError(f"{error}; or install clang, lld and wasi-libc")
    return command


def web_assembly(texts: Mapping[str, str]) -> bytes:
    """WebAssembly module that exports the function `fly_all` of each C module under its name.

    The first address after its own data is the global `__heap_base`. It imports nothing.

    Args:
        texts: Name -> text of a C module; see `gyrostat.codegen.simd.module`.

    Raises:
        InputError: There is no compiler, or it fails.
    """
    command = require_web_compiler()
    cache = private_cache()
    if cache is None:
        raise InputError("--fly: found no private folder, expected one (see GYROSTAT_CACHE)")
    parts = (str(_ABI), *command, *_FLAGS, *_LINK, header(), *map(str, sorted(texts.items())))
    name = f"lanes-web-{hashlib.sha256(chr(0).join(parts).encode()).hexdigest()}"
    content = cache.read(name)
    if content is None:
        try:
            with cache.workplace() as folder:
                content = _compiled(texts, command, folder)
        except OSError as error:
            raise InputError(f"--fly: found {error}, expected {command[0]} to run") from None
        cache.write(name, content)
    return content


def _compiled(texts: Mapping[str, str], command: tuple[str, ...], folder: Path) -> bytes:
    (folder / "lanes.h").write_text(header(), encoding="utf-8")
    objects = []
    for name, text in texts.items():
        (folder / f"{name}.c").write_text(text, encoding="utf-8")
        renamed = (f"-Dfly_all={name}", f"-Dlanes=lanes_{name}")
        output_of((*command, *_FLAGS, *renamed, "-c", f"{name}.c", "-o", f"{name}.o"), folder)
        objects.append(f"{name}.o")
    exports = [f"-Wl,--export={name}" for name in texts]
    output_of((*command, *_LINK, *exports, *objects, "-o", "program.wasm", "-lm"), folder)
    return (folder / "program.wasm").read_bytes()


def _compiles(command: tuple[str, ...]) -> bool:
    """Whether a compiler finds the libraries of its target."""
    cache = private_cache()
    if cache is None:
        return False
    with cache.workplace() as folder:
        (folder / "probe.c").write_text(_PROBE, encoding="utf-8")
        exports = ("-Wl,--export=probe", "probe.c", "-o", "probe.wasm", "-lm")
        return run_compiler((*command, *_FLAGS, *_LINK, *exports), folder).returncode == 0
