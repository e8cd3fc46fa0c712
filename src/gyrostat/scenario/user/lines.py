"""Lines of a user's Python as they are executed, to name the one that does something unwanted."""

import contextlib
import io
import linecache
import sys
from collections.abc import Callable, Iterator
from itertools import pairwise, zip_longest
from types import FrameType
from typing import Any, NamedTuple

from gyrostat.core.user_modules import PREFIX
from gyrostat.scenario.user.state import content, state_of


class Line(NamedTuple):
    """Line of a user's file.

    Attributes:
        file: Path relative to the folder of the scenario.
        number: Number of the line.
        text: Text of the line, stripped.
    """

    file: str
    number: int
    text: str


class Event(NamedTuple):
    """State of execution before a line, or at the return of a function.

    Attributes:
        place: File and number of the line, and what happens there.
        content: What was probed.
        culprit: Line that was executed before, which has computed this content.
    """

    place: tuple[str, int, str]
    content: Any
    culprit: tuple[str, int]


def line_at(file: str, number: int) -> Line | None:
    """Line of a user's file; None for any other file.

    Args:
        file: Name of the file as code has it.
        number: Number of the line.
    """
    package, _, path = file.partition("/")
    if not package.startswith(PREFIX):
        return None
    return Line(path, number, linecache.getline(file, number).strip()[:80])


def line_in(equation: Any) -> Line | None:
    """Innermost line of a user's file that an equation comes from; None if there is none.

    Args:
        equation: Equation of a jaxpr, or None.
    """
    traceback = None if equation is None else equation.source_info.traceback
    lines = (line_at(f.file_name, f.line_num) for f in (traceback.frames if traceback else ()))
    return next((line for line in lines if line is not None), None)


def line_that_differs(one: Callable[[], Any], other: Callable[[], Any]) -> Line | None:
    """First line of a user's file that computes another value in a second execution."""

    def values(frame: FrameType, result: Any) -> Any:
        package = frame.f_code.co_filename.partition("/")[0]
        names = {n: v for n, v in frame.f_locals.items() if not n.startswith("__")}
        return content([names, result], package)

    for first, second in zip_longest(_events(one, values), _events(other, values)):
        event: Event = second if first is None else first
        if first is None or second is None or first[:2] != second[:2]:
            return line_at(*event.culprit)
    return None


def line_that_changes(run: Callable[[], Any]) -> Line | None:
    """First line of a user's file, inside a function, that changes a global."""

    def state(frame: FrameType, result: Any) -> Any:
        return state_of(frame.f_code.co_filename.partition("/")[0])

    for before, after in pairwise(_events(run, state, while_loading=False)):
        if before.content != after.content:
            return line_at(*after.culprit)
    return None


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Discard what is printed; it was printed in the first call."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        yield


def _events(
    run: Callable[[], Any], probe: Callable[[FrameType, Any], Any], *, while_loading: bool = True
) -> list[Event]:
    """Events of an execution in a user's files, until its end or an exception."""
    events: list[Event] = []
    last: dict[int, tuple[str, int]] = {}

    def local(frame: FrameType, event: str, argument: Any) -> Any:
        file, number = frame.f_code.co_filename, frame.f_lineno
        if event in ("line", "return") and (while_loading or not _is_loading(frame)):
            result = argument if event == "return" else None
            position = file, number
            culprit = position if event == "return" else last.get(id(frame), position)
            place = file.partition("/")[2], number, event
            events.append(Event(place, probe(frame, result), culprit))
        last[id(frame)] = file, number
        if event == "return":
            del last[id(frame)]
        return local

    def trace_frame(frame: FrameType, event: str, argument: Any) -> Any:
        return local if frame.f_code.co_filename.startswith(PREFIX) else None

    old_trace = sys.gettrace()
    with silent(), contextlib.suppress(Exception):
        sys.settrace(trace_frame)
        try:
            run()
        finally:
            sys.settrace(old_trace)
    return events


def _is_loading(frame: FrameType | None) -> bool:
    """Whether a module of the user is being loaded."""
    while frame is not None:
        if frame.f_code.co_name == "<module>" and frame.f_code.co_filename.startswith(PREFIX):
            return True
        frame = frame.f_back
    return False
