"""Instruction set of programs: that of this processor, or one that several processors share.

The last digits of results depend on the instructions. NumPy, OpenBLAS and XLA choose theirs when
they are loaded, therefore a common set must be in the environment before Python imports them.
"""

import os
import platform
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from gyrostat.core.errors import InputError

NAME = "GYROSTAT_INSTRUCTIONS"
"""Environment variable with the name of a common instruction set."""


class Common(NamedTuple):
    """Instruction set by its name for the compiler, and how the libraries are limited to it.

    Attributes:
        needed: Features of the processor, as in /proc/cpuinfo.
        beyond: Features that NumPy must not use; names of all its versions.
        openblas: Core type of OpenBLAS.
        xla: Limit of XLA.
    """

    needed: frozenset[str]
    beyond: tuple[str, ...]
    openblas: str
    xla: str


_V3 = {"avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"}
_LATER = ("AVX512_CLX", "AVX512_CNL", "AVX512_ICL", "AVX512_SPR")
_V4 = ("X86_V4", "AVX512F", "AVX512CD", "AVX512_KNL", "AVX512_KNM", "AVX512_SKX")
COMMON = {
    "x86-64-v3": Common(frozenset(_V3), (*_V4, *_LATER), "Haswell", "AVX2"),
    "x86-64-v4": Common(
        frozenset(_V3 | {f"avx512{each}" for each in ("f", "bw", "cd", "dq", "vl")}),
        *(_LATER, "SkylakeX", "AVX512"),
    ),
}


def environment(name: str) -> dict[str, str]:
    """Environment variables with which a process uses a common instruction set.

    Raises:
        InputError: There is no such set.
    """
    if name not in COMMON:
        raise InputError(f"--instructions: found {name!r}, expected one of {', '.join(COMMON)}")
    common = COMMON[name]
    return {
        NAME: name,
        "NPY_DISABLE_CPU_FEATURES": " ".join(common.beyond),
        "OPENBLAS_CORETYPE": common.openblas,
        "XLA_FLAGS": f"--xla_cpu_max_isa={common.xla}",
    }


def limit_process(name: str | None) -> None:
    """Limit a process that has not imported NumPy to a common instruction set; None: no limit.

    Raises:
        InputError: There is no such set.
    """
    if name:
        os.environ.update(environment(name))


def instructions() -> str:
    """Instruction set of this process: the name of a common one, or what its processor has.

    Raises:
        InputError: There is no such set, the processor lacks some of it, or the process was started
            without the `environment` of the set.
    """
    name, features = os.environ.get(NAME, ""), _features()
    if not name:
        vector = sorted(each for each in features if re.match("avx|fma|sve|asimd", each))
        return " ".join([platform.machine(), *vector])
    variables = environment(name)
    lacking = sorted(COMMON[name].needed - features)
    if lacking:
        raise InputError(
            f"--instructions: found a processor without {', '.join(lacking)}, expected {name}"
        )
    keys = [key for key, value in variables.items() if value not in os.environ.get(key, "")]
    if keys or not set(_of_numpy()).isdisjoint(COMMON[name].beyond):
        raise InputError(
            f"--instructions: found a process with other instructions, expected {set_before(name)}"
        )
    return name


def check_instructions(wanted: str | None) -> None:
    """Check that this process uses the wanted common instruction set; None: its own.

    Raises:
        InputError: It does not, or there is no such set.
    """
    if wanted is not None and os.environ.get(NAME) != wanted:
        raise InputError(
            f"--instructions: found a process without {wanted}, expected {set_before(wanted)}"
        )
    instructions()


def set_before(name: str) -> str:
    """Words that tell how to start a process with a common instruction set."""
    values = " ".join(f"{key}='{value}'" for key, value in environment(name).items())
    return f"{values} in the environment before Python starts"


def xla_flags() -> tuple[str, ...]:
    """Flags of XLA that limit it to the instruction set of this process."""
    name = os.environ.get(NAME, "")
    return (environment(name)["XLA_FLAGS"],) if name else ()


def compiler_flags() -> tuple[str, ...]:
    """Flags of the C compiler for the instruction set of this process."""
    if platform.machine() == "arm64":  # the compiler of macOS has no -march=native there
        return ("-mcpu=native",)
    return (f"-march={os.environ.get(NAME) or 'native'}",)


def recorded(engine: Mapping[str, str]) -> str | None:
    """Name of the common instruction set in the fingerprint of an engine; None if it has none."""
    name = engine.get("instructions")
    return name if name in COMMON else None


def processor() -> str:
    """Description of the processor by the system, /proc/cpuinfo; empty if there is none."""
    try:
        return Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""


def _features() -> set[str]:
    words = re.search(r"^(?:flags|Features)\s*:(.*)$", processor(), re.MULTILINE)
    return set(words[1].split() if words else ())


def _of_numpy() -> list[str]:
    """Features that NumPy uses in this process beyond those of its build; none if not imported."""
    if "numpy" not in sys.modules:
        return []
    import numpy as np

    config = np.show_config(mode="dicts") or {}
    return config.get("SIMD Extensions", {}).get("found", [])
