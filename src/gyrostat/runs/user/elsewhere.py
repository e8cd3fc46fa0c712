"""Trace in another process: a user's part must not depend on process, machine or day.

What a user's Python learns of these is compiled once, and another process gets other numbers: the
order of a set of texts, `hash`, the number of the process, a date. A second trace in this process
has the same ones. The other process has a hash seed, arguments, working folder, host and date of
its own; sets and hashes are changed in this process, because two hash seeds can give a small set
the same order. This costs seconds, so that it is done only for texts with a name that can make a
difference, and once for the same texts and trace.
"""

import ast
import datetime
import os
import pickle
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from gyrostat.codegen.comparison import Outline, difference_of, outline_of
from gyrostat.core.errors import InputError
from gyrostat.core.stored_texts import stored_texts
from gyrostat.core.user_errors import UserPartError, reported
from gyrostat.core.user_modules import Source, package_of
from gyrostat.runs.user.unordered import without_order
from gyrostat.scenario.user.lines import silent
from gyrostat.scenario.user.live_calls import traced_law
from gyrostat.scenario.user.recording import differing_elsewhere
from gyrostat.wheel.friction_laws import loaded_law

MODULES = frozenset(
    {
        *("__main__", "datetime", "decimal", "gc", "getpass", "inspect", "locale", "os"),
        *("multiprocessing", "platform", "socket", "sys", "threading", "time", "uuid", "weakref"),
    }
)
"""Modules that tell something of the process, the machine or the day."""
NAMES = frozenset({"hash", "id", "set", "frozenset", "globals", "vars", "dir", "__import__"})
"""Built-in names that do."""
LATER = 400.5 * 86400.0
"""Time by which the clocks of the other process are ahead, s."""
_COMMAND = "from gyrostat.runs.user.elsewhere import answer; answer()"

Traced = Callable[[tuple[Source, ...]], Any]
"""Function that loads texts and returns a closed jaxpr of their parts; it can be pickled."""


def depends_on_process(source: Source) -> bool:
    """Whether the text of a module contains a name that can differ between processes."""
    return source.is_module and any(map(_can_differ, ast.walk(ast.parse(source.text))))


def _can_differ(node: ast.AST) -> bool:
    match node:
        case ast.Set() | ast.SetComp():
            return True
        case ast.Name(id=name):
            return name in NAMES
        case ast.Import(names=names):
            return any(alias.name.partition(".")[0] in MODULES for alias in names)
        case ast.ImportFrom(module=str(module), level=0):
            return module.partition(".")[0] in MODULES
    return False


def check_elsewhere(part: str, sources: tuple[Source, ...], traced: Traced, here: Outline) -> None:
    """Check that the trace of another process is that of this one.

    Args:
        part: Names of the user-defined parts, for messages.
        sources: Texts of the parts.
        traced: Gives the trace from the texts.
        here: Outline of the trace of this process.

    Raises:
        UserPartError: A constant or an operation differs, or the parts cannot be traced there.
    """
    if not any(map(depends_on_process, sources)):
        return

    def compare() -> dict[str, str]:
        with reported(part), silent():
            outlines = list(_outlines(sources, traced))
        for outline in outlines:
            difference = difference_of(here, outline)
            if difference is not None:
                raise differing_elsewhere(part, difference)
        return {}

    stored_texts((here.digest, *((each.path, each.text) for each in sources)), compare)


def check_law_elsewhere(kind: str, sources: tuple[Source, ...]) -> None:
    """Check that a user's friction law has the same curve in another process.

    Args:
        kind: "FILE.py:CLASS".
        sources: Texts of the file and its local imports.

    Raises:
        UserPartError: A constant or an operation of its curve differs.
    """
    trace = partial(_curve, kind)
    check_elsewhere(f"friction {kind}", sources, trace, outline_of(trace(sources)))


def _curve(kind: str, sources: tuple[Source, ...]) -> Any:
    return traced_law(loaded_law(kind, sources))


def _outlines(sources: tuple[Source, ...], trace: Traced) -> Iterator[Outline]:
    """Outlines of the traces with other sets and hashes, and of that in another process."""
    variants = (tuple(without_order(source, turn) for source in sources) for turn in (0, 1))
    for variant in dict.fromkeys(variants):
        if variant != sources:
            yield outline_of(trace(variant))
    path = os.pathsep.join(os.path.abspath(folder) for folder in sys.path)
    seed = "2" if os.environ.get("PYTHONHASHSEED") == "1" else "1"
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [sys.executable, "-c", _COMMAND, "elsewhere"],
            input=pickle.dumps((sources, pickle.dumps(trace))),
            env={**os.environ, "PYTHONPATH": path, "PYTHONHASHSEED": seed},
            cwd=folder,
            capture_output=True,
            check=False,
        )
    if run.returncode != 0:
        line = (run.stderr.decode(errors="replace").strip().splitlines() or ["no message"])[-1]
        raise InputError(f"found no trace in another process ({line}), expected the same as here")
    reply: Outline | str = pickle.loads(run.stdout)
    if isinstance(reply, str):
        raise InputError(f"in another process: {reply}")
    yield reply


def answer() -> None:
    """Write the outline of a trace, or a message; the main program of the other process."""
    sources, content = pickle.load(sys.stdin.buffer)
    package_of(sources)  # the trace can be of its classes
    trace: Traced = pickle.loads(content)
    _move_away()
    try:
        with reported("parts"):
            reply: Outline | str = outline_of(trace(sources), equations=False)
    except UserPartError as error:
        reply = str(error)
    sys.stdout.buffer.write(pickle.dumps(reply))


def _move_away() -> None:
    """Give this process another host and another day."""
    socket.gethostname = lambda: "elsewhere"
    os.getcwd = lambda: os.sep
    seconds, nanoseconds = time.time, time.time_ns
    time.time = lambda: seconds() + LATER
    time.time_ns = lambda: nanoseconds() + int(LATER * 1e9)
    datetime.date, datetime.datetime = _Date, _DateTime


class _Kind(type):
    """Class of `_Date` and `_DateTime`, whose instances are those of Python's own classes too."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, cls.__mro__[1])


class _Date(datetime.date, metaclass=_Kind):
    """Date of another day."""

    @classmethod
    def today(cls) -> Any:
        """Day in more than a year."""
        return cls.fromtimestamp(time.time())


class _DateTime(datetime.datetime, metaclass=_Kind):
    """Date and time of another day."""

    @classmethod
    def now(cls, tz: Any = None) -> Any:
        """Time in more than a year."""
        return cls.fromtimestamp(time.time(), tz)

    @classmethod
    def today(cls) -> Any:
        """Time in more than a year."""
        return cls.now()

    @classmethod
    def utcnow(cls) -> Any:
        """Time in more than a year."""
        return cls.now(datetime.UTC).replace(tzinfo=None)
