"""Text of a program for an accelerator."""

from gyrostat.codegen.simd.compiler import header
from gyrostat.codegen.simd.module import INCLUDE


def source(module: str, definitions: dict[str, int]) -> str:
    """Text that a compiler for accelerators takes.

    Args:
        module: C module for SIMD lanes; see `gyrostat.codegen.simd.module`.
        definitions: Macros of `work_item.h`: RECORDS, WORK_GROUP and SHARED_WORDS.
    """
    lines = "".join(f"#define {name} {value}\n" for name, value in definitions.items())
    return lines + module.replace(INCLUDE, header("work_item.h"))
