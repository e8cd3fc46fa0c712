"""Texts for the compiler of an accelerator."""

from collections.abc import Mapping
from importlib.resources import files

from gyrostat.codegen.simd.compiler import header
from gyrostat.codegen.simd.module import INCLUDE


def source(module: str, definitions: Mapping[str, int]) -> str:
    """Text of a program with one run in each work item.

    Args:
        module: C module for SIMD lanes; see `gyrostat.codegen.simd.module`.
        definitions: Macros of `work_item.h`: RECORDS, WORK_GROUP and SHARED_WORDS.
    """
    return _defined(definitions) + module.replace(INCLUDE, header("work_item.h"))


def ranks_source(group: int) -> str:
    """Text of the kernel of `ranks.h`, for work groups of `group` work items."""
    ranks = files("gyrostat.codegen.accelerators").joinpath("ranks.h").read_text(encoding="utf-8")
    return _defined({"RECORDS": 0, "WORK_GROUP": group}) + header("work_item.h") + ranks


def _defined(definitions: Mapping[str, int]) -> str:
    return "".join(f"#define {name} {value}\n" for name, value in definitions.items())
