"""Software and hardware fingerprint, needed for exact replay."""

import os
import platform
import sys
from collections.abc import Mapping
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
    return {**record, "gyrostat": source_digest(), "instructions": instructions()}


def use_engine(record: Record) -> None:
    """Configure this process for a recorded engine; call it before any computation.

    Raises:
        InputError: The process has other versions or instructions, or no such device.
    """
    os.environ["XLA_FLAGS"] = " ".join([record["flags"], *xla_flags()])
    os.environ["JAX_PLATFORMS"] = _PLATFORM[record["device"]]
    if "jax" in sys.modules:
        sys.modules["jax"].config.update("jax_platforms", _PLATFORM[record["device"]])
    refuse_other(record, "this process")
    if record["device"] == "gpu":
        from gyrostat.core.jax64 import jax

        try:
            jax.devices()
        except RuntimeError:
            raise InputError(
                "--device gpu: found no GPU for JAX, expected one (and the GPU plugin of jax)"
            ) from None


def refuse_other(record: Record, where: str) -> None:
    """Check that this process has the recorded engine.

    Args:
        record: Fingerprint in the store.
        where: Start of the error message: the process or folder.

    Raises:
        InputError: The fingerprint differs, so that results would differ from those of the store.
    """
    engine = engine_record(record["device"], record["flags"], record.get("engine", "jax"))
    for name, value in engine.items():
        if record.get(name) != value:
            common = recorded(record) if name == "instructions" else None
            hint = f" (--instructions {common}, or {set_before(common)})" if common else ""
            raise InputError(
                f"{where}: found {name} {value}, expected {record.get(name)}{hint}, as recorded: "
                "otherwise the last digits of the results would differ"
            )
