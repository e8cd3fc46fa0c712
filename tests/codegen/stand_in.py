"""Device of CUDA without one: a stand-in for its driver, and a C compiler for that of its texts."""

import ctypes
import hashlib
import subprocess
from pathlib import Path

from gyrostat.codegen.accelerators import cuda, driver
from gyrostat.codegen.simd import compiler

FLAGS = ("-std=gnu11", "-ffp-contract=off", "-shared", "-fPIC", "-w")


def library(folder, text, level, *more):
    """Path of a shared library of a text."""
    path = folder / hashlib.sha256(text.encode()).hexdigest()[:16]
    path.with_suffix(".c").write_text(text)
    files = ("-o", path.with_suffix(".so"), path.with_suffix(".c"))
    subprocess.run([*compiler(), *FLAGS, level, *files, *more], check=True)
    return path.with_suffix(".so")


def stand_in(folder, patch, level="-O1"):
    """Device of CUDA, and the library that takes the place of its driver."""
    text = Path(__file__).with_name("stand_in_driver.c").read_text()
    loaded = ctypes.CDLL(str(library(folder, text, "-O1", "-ldl")))

    def compiled(text, options):
        assert options == ("-arch=sm_90", "-fmad=false", "-std=c++17")
        return bytes(library(folder, text, level, "-lm")) + b"\0"

    for module in (driver, cuda):
        patch.setattr(module, "driver", lambda: loaded)
    patch.setattr(cuda, "compiled", compiled)
    patch.setattr(cuda, "compiler_version", lambda: "0.0")
    patch.setattr(cuda, "private_cache", lambda: None)
    return cuda.Cuda(), loaded
