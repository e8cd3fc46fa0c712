"""What a user-defined part can be compiled for, and the line because of which it cannot."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from gyrostat.codegen.scope import FLIGHT, Scope
from gyrostat.codegen.simd.batch_scope import BATCH
from gyrostat.codegen.source import UnsupportedError
from gyrostat.codegen.support import unsupported
from gyrostat.codegen.tracing import called
from gyrostat.core.user_modules import PREFIX
from gyrostat.scenario.user.lines import Line, line_in
from gyrostat.scenario.user.recording import Call

EXPORTED = (
    *("controller", "controller.law", "compensator", "estimator"),
    *("reference", "reference.mode", "reference.transition"),
)
"""Sections whose parts are in the exported controller of a scenario."""


class Obstacle(NamedTuple):
    """Operation of a part that cannot be compiled.

    Attributes:
        operation: The operation.
        file: File of the user, relative to the folder of the scenario; "" if it is not known.
        line: Number of the line; 0 if it is not known.
        text: Text of the line.
    """

    operation: str
    file: str = ""
    line: int = 0
    text: str = ""

    def __str__(self) -> str:
        location = f"{self.file} line {self.line}, `{self.text}`: " if self.file else ""
        return location + self.operation


class Support(NamedTuple):
    """What a user-defined part can be compiled for.

    Attributes:
        native: What keeps it from the native engine; None if nothing does. The engine JAX
            simulates every part.
        export: What keeps it from an export to C; None if nothing does.
        exported: Whether it is among the parts that an export contains.
    """

    native: Obstacle | None
    export: Obstacle | None
    exported: bool

    def __str__(self) -> str:
        engine = "engine: native or JAX" if self.native is None else "engine: JAX only"
        export = "yes" if self.export is None else "no"
        export = f"export to C: {export if self.exported else 'not in flight code'}"
        if self.native == self.export and self.native is not None:
            return f"{engine}; {export}; because of {self.native}"
        reasons = ("" if each is None else f", because of {each}" for each in self[:2])
        return "; ".join(map("".join, zip((engine, export), reasons, strict=True)))

    def content(self) -> dict[str, Any]:
        """Content for JSON."""
        return {
            name: each._asdict() if isinstance(each, Obstacle) else each
            for name, each in self._asdict().items()
        }


def support_of(calls: Sequence[Call], *, exported: bool) -> Support:
    """What a part can be compiled for, from its calls.

    Args:
        calls: Calls of the part; see `recording`.
        exported: Whether an export contains such a part.
    """
    native = _obstacle([call for call in calls if call.simulated], BATCH)
    return Support(native, _obstacle(calls, FLIGHT) if exported else None, exported)


def _obstacle(calls: Sequence[Call], scope: Scope) -> Obstacle | None:
    for call in calls:
        error = unsupported(call.traced, scope)
        if error is not None:
            line = _line(error)
            location = ("", 0, "") if line is None else (line.file, line.number, line.text)
            return Obstacle(error.what, *location)
    return None


def _line(error: UnsupportedError) -> Line | None:
    """Line of the user's file that an operation comes from.

    JAX traces a function of a library once, with the lines of its first caller: the operations
    inside it have the line of the call.
    """
    line = None
    for equation in reversed(error.equations):
        line = line_in(equation) or line
        inner = called(equation)
        if inner is None:
            continue
        path = getattr(getattr(inner.jaxpr, "debug_info", None), "func_src_info", None) or ""
        if PREFIX not in path:
            break
    return line
