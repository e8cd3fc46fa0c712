"""Instructions, stack and memory on Cortex-M4F and Cortex-M7."""

import re
from collections.abc import Mapping
from importlib.resources import files
from typing import ClassVar

from gyrostat.codegen import bounds
from gyrostat.codegen.flight.expressions import Dialect
from gyrostat.codegen.flight.header import prototype
from gyrostat.codegen.flight.measure import FLAGS, OPTIMISATION
from gyrostat.exports.evidence.board import board_file, board_files, counting_code
from gyrostat.exports.evidence.evidence_kind import EvidenceKind, Subject
from gyrostat.exports.template import filled

REDUCTION = "int {name}({real} *x, {real} *y, int e0, int nx, int prec, const int32_t *digits)"
"""Prototype of the function of newlib that reduces large angles."""


class Resources(EvidenceKind):
    """Bounds of instructions and stack beside their counts in a run, and the size of the code."""

    name = "resources"
    title = "bounds of instructions and stack, size of the code"
    clause = "5.8.3.12"
    tools: ClassVar[Mapping[str, str]] = {
        "gcc": "arm-none-eabi-gcc",
        "objdump": "arm-none-eabi-objdump",
        "size": "arm-none-eabi-size",
        "qemu": "qemu-system-arm",
        "python": "python3",
    }

    @classmethod
    def script(cls, subject: Subject) -> str:
        """See `EvidenceKind.script`."""
        entries = [entry.name for entry in subject.target.entries]
        return filled(
            "evidence/resources.sh",
            flags=f"{FLAGS} {OPTIMISATION}",
            wrapped=" ".join(f"-Wl,--wrap={entry}" for entry in entries),
            entries=" ".join([f"-Wl,-e,{entries[-1]}", *(f"-Wl,-u,{entry}" for entry in entries)]),
            real=subject.precision,
            reduction=_reduction(subject),
        )

    @classmethod
    def files(cls, subject: Subject) -> dict[str, str]:
        """See `EvidenceKind.files`."""
        module, real, dialect = subject.module, subject.precision, Dialect(subject.precision)
        prototypes = [prototype(name, ports, dialect) for name, ports in module.ports.items()]
        texts = {
            **board_files(),
            "count.c": counting_code(f'#include "{module.name}.h"\n', prototypes),
        }
        if reduction := _reduction(subject):
            tangent = "tan" if real == "double" else "tanf"
            texts["angles.c"] = board_file("angles.c", real=real, tangent=tangent)
            head = REDUCTION.format(name=reduction, real=real)
            texts["count_reduction.c"] = counting_code("", [head])
        texts = {f"resources/{name}": text for name, text in texts.items()}
        for file in sorted(files(bounds).iterdir(), key=lambda file: file.name):
            if file.name.endswith(".py"):
                texts[f"bounds/{file.name}"] = file.read_text(encoding="utf-8")
        return texts

    @classmethod
    def notes(cls, subject: Subject) -> list[str]:
        """See `EvidenceKind.notes`."""
        return [
            "Instructions are those of a call with its arguments and with the functions of the C "
            "library, without interrupts. They are no cycles: the manual of the processor says how "
            "many cycles each takes. The count is the largest of the test program, which QEMU "
            "runs on the simulated processor; its results must be those of Python. The bound is "
            "the longest path through the control-flow graph of the same program, with the passes "
            "of the loops of C from their text and those of the C library from "
            "`evidence/bounds/library.py`. A loop that may end early counts with its most passes. "
            "The stack is that of the deepest chain of calls, by `-fstack-usage` and, for the C "
            "library, by its instructions.",
            *([" ".join(_SOFTWARE.split())] if subject.precision == "double" else []),
            *([" ".join(_REDUCED.split())] if _reduction(subject) else []),
        ]


_SOFTWARE = """
A Cortex-M4F computes `double` by software, which takes up to 52 passes more for a product or a
quotient with a subnormal operand (smaller than 2.3e-308). The bound without them holds if there are
none."""
_REDUCED = """
Angles from 8e5 rad (`float`: 200 rad) are reduced by `__kernel_rem_pio2` of the C library, whose
passes depend on the digits of the angle. It has no bound; the largest count of 4020 angles
(`float`: 488) that take long, among them those next to a multiple of pi/2, stands in its place."""


def _reduction(subject: Subject) -> str:
    """Function of the C library that reduces large angles; "" if the code has no angles."""
    if not re.search(r"\b(?:sin|cos|tan)f?\(", subject.module.source):
        return ""
    return "__kernel_rem_pio2" + ("f" if subject.precision == "float" else "")
