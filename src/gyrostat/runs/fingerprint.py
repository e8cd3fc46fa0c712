"""Software and hardware fingerprint, needed for exact replay."""

import os
import platform
import sys
from collections.abc import Collection, Mapping
from importlib.metadata import PackageNotFoundError, version

from gyrostat.codegen.simd import compiler_options, compiler_version
from gyrostat.core.engines import ACCELERATED
from gyrostat.core.errors import InputError
from gyrostat.core.instructions import instructions, recorded, set_before, xla_flags
from gyrostat.core.source_digest import source_digest

Record = Mapping[str, str]

# One thread per worker. With optimisation level 1 compilation takes two thirds of the time, and the
# program is as fast. Without fusion emitters compilation takes two thirds again, and the program is
# faster. XLA ends the process for a flag that it does not know.
_CPU = ["--xla_cpu_multi_thread_eigen=false", "--xla_backend_optimization_level=1"]
if version("jaxlib").startswith("0.10."):
    _CPU.append("--xla_cpu_use_fusion_emitters=false")
FLAGS: dict[str, str] = {"cpu": " ".join(_CPU), "gpu": ""}
PACKAGES = ("jax", "jaxlib", "numpy", "scipy", "equinox")
"""Packages whose versions are in the fingerprint."""
_PLATFORM = {"cpu": "cpu", "gpu": "cuda"}


def engine_record(device: str, flags: str, engine: str = "jax") -> dict[str, str]:
    """Fingerprint of the engine in this process: name -> version, flags or digest.

    Args:
        device: "cpu" or "gpu".
        flags: Flags of XLA.
        engine: "jax", "native" or one that uses an accelerator.

    Raises:
        InputError: There is no such accelerator.
    """
    python = platform.python_version()
    record = {"engine": engine, "device": device, "flags": flags, "python": python}
    if engine == "native":
        record["compiler"] = " ".join([compiler_version(), *compiler_options()])
    if engine in ACCELERATED:
        from gyrostat.codegen.accelerators.devices import device as accelerator

        record["accelerator"] = accelerator(engine).name
    for package in PACKAGES:
        try:
            record[package] = version(package)
        except PackageNotFoundError:  # simulation will fail as well
            record[package] = "none"
    known = {"gyrostat": source_digest(), "instructions": instructions()}
    return {**record, **known, "mathematical library": mathematical_library()}


def mathematical_library() -> str:
    """Name and version of the C library, whose functions such as `pow` compiled programs call."""
    try:
        return os.confstr("CS_GNU_LIBC_VERSION") or "unknown"
    except ValueError:  # not glibc: part of the system
        return f"{platform.system()} {platform.release()}"


def use_engine(record: Record, where: str = "this process", unused: Collection[str] = ()) -> None:
    """Configure this process for a recorded engine; call it before any computation.

    Args:
        record: Fingerprint.
        where: See `refuse_other`.
        unused: See `refuse_other`.

    Raises:
        InputError: The process has other versions or instructions, or no such device.
    """
    os.environ["XLA_FLAGS"] = " ".join([record["flags"], *xla_flags()])
    os.environ["JAX_PLATFORMS"] = _PLATFORM[record["device"]]
    if "jax" in sys.modules:
        sys.modules["jax"].config.update("jax_platforms", _PLATFORM[record["device"]])
    refuse_other(record, where, unused)
    if record["device"] == "gpu":
        from gyrostat.core.jax64 import jax

        try:
            jax.devices()
        except RuntimeError:
            raise InputError(
                "--device gpu: found no GPU for JAX, expected one (and the GPU plugin of jax)"
            ) from None


def refuse_other(record: Record, where: str, unused: Collection[str] = ()) -> None:
    """Check that this process has the recorded engine.

    Args:
        record: Fingerprint in the store.
        where: Start of the error message: the process or folder.
        unused: Names in the fingerprint that do not matter here: "compiler" where the compiled
            program is delivered.

    Raises:
        InputError: The fingerprint differs, so that results would differ from those of the store.
    """
    engine = engine_record(record["device"], record["flags"], record.get("engine", "jax"))
    for name, value in engine.items():
        if name not in unused and record.get(name) != value:
            common = recorded(record) if name == "instructions" else None
            hint = f" (--instructions {common}, or {set_before(common)})" if common else ""
            raise InputError(
                f"{where}: found {name} {value}, expected {record.get(name)}{hint}, as recorded: "
                "otherwise the last digits of the results would differ"
            )
