"""Undeclared reads: what the Python of a user reads from outside of a scenario.

Reads are watched while user-defined parts are loaded, constructed and traced: files by the audit
events of Python and by `gyrostat.core.file_readers`, environment variables by a class of
`os.environ`. A read counts if a line of a private package has led to it. Python's own files, those
of installed packages and what their import reads do not count.
"""

import contextlib
import functools
import importlib
import importlib.util
import linecache
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from threading import RLock, local
from types import CodeType, FrameType
from typing import Any, NamedTuple

from gyrostat.core.data_folder import working_in
from gyrostat.core.errors import InputError
from gyrostat.core.file_readers import WatchedReaders, mark
from gyrostat.core.jax64 import jax
from gyrostat.core.local_modules import is_library_file, is_local
from gyrostat.core.user_modules import PREFIX, folder_of, unload

_IMPORT = "<frozen importlib._bootstrap>"
_OWN_READERS = (
    *("/gyrostat/core/cache.py", "/jax/_src/compilation_cache", "/jax/_src/lru_cache"),
    "/importlib/metadata/",
)
"""Files that read compiled programs, and what is installed: JAX asks for its plugins at the first
array of a process."""
_MACHINE = (
    *("/sys/fs/cgroup/", "/proc/self/cgroup", "/proc/self/mountinfo"),
    *("/proc/cpuinfo", "/proc/meminfo"),
)
"""Files in which libraries look how many processors and how much memory there are."""
_ENVIRONMENT = {
    *("os.py", "_collections_abc.py", "posixpath.py", "ntpath.py", "undeclared_reads.py"),
    *("<frozen os>", "<frozen _collections_abc>", "<frozen posixpath>", "<frozen ntpath>"),
}
"""Files of Python that read the environment for their caller."""
_AS_FIELD = (
    "a value of the scenario: a field of the part, which is a key, or a constant in the module"
)
_AS_DATA = 'its result in a data file of the part, data = ["FILE", ...] beside python'


class Read(NamedTuple):
    """Undeclared read.

    Attributes:
        package: Private package of the line.
        file: Path of the file of the line, relative to the folder of the scenario.
        line: Number of the line.
        text: Text of the line.
        what: What the line does: "reads weights.npz".
        remedy: What is expected instead.
    """

    package: str
    file: str
    line: int
    text: str
    what: str
    remedy: str


class UndeclaredReadError(InputError):
    """Undeclared read of a user-defined part.

    Attributes:
        read: The first one.
    """

    def __init__(self, read: Read) -> None:
        fault = f"found `{read.text}`, which {read.what}"
        super().__init__(f"{read.file} line {read.line}: {fault}, expected {read.remedy}")
        self.read = read


_watches: dict[int, list[Read]] = {}
"""Reads of each watch, the innermost last."""
_SWITCHING = RLock()
_hearing = local()


@contextlib.contextmanager
def watched_reads(package: str = "") -> Iterator[None]:
    """Refuse undeclared reads inside; the data files of a package are in the working folder.

    Args:
        package: Name of the private package whose lines are executed, or of a module in it.

    Raises:
        UndeclaredReadError: A line of a private package has read something from outside of the
            scenario, in place of any exception that this led to.
    """
    location = folder_of(package.partition(".")[0])
    reads: list[Read] = []
    with _SWITCHING:
        if not _watches:
            _switch_on()
        _watches[id(reads)] = reads
    try:
        with working_in(location[0] if location else None):
            yield
    except Exception:
        if not reads:
            raise
    finally:
        with _SWITCHING:
            del _watches[id(reads)]
            if not _watches:
                _switch_off()
    if reads:
        unload(reads[0].package)  # what its modules have read must not be used
        raise UndeclaredReadError(reads[0])


def _switch_on() -> None:
    jax.devices()  # JAX looks for them at its first use, which is no read of a part
    if not _HOOKED:
        sys.addaudithook(_hear)  # it cannot be removed
        _HOOKED.append(True)
    _set_environment(_WATCHED)
    importlib.import_module = _import_module
    _READERS.switch_on()


def _switch_off() -> None:
    _READERS.switch_off()
    importlib.import_module = _REAL_IMPORT
    _set_environment(_PLAIN)


class _Environment(os._Environ):
    """Environment variables that reports which of them are read."""

    def __getitem__(self, key: Any) -> Any:
        _note_variable(f"the environment variable {os.fsdecode(key)}")
        return super().__getitem__(key)

    def __iter__(self) -> Iterator[Any]:
        _note_variable("the environment variables")
        return super().__iter__()


_HOOKED: list[bool] = []
_PLAIN, _WATCHED = os._Environ, _Environment
_REAL_IMPORT = importlib.import_module


def _set_environment(kind: type) -> None:
    """Give the environment variables a class; names that refer to them stay valid."""
    for name in ("environ", "environb"):
        variables = getattr(os, name, None)
        if type(variables) in (_PLAIN, _WATCHED):
            variables.__class__ = kind


@functools.wraps(_REAL_IMPORT)
def _import_module(name: str, package: str | None = None) -> Any:
    """See `importlib.import_module`; reports a local module that is not of the scenario."""
    module = _REAL_IMPORT(name, package)
    if is_local(module) and not module.__name__.startswith(PREFIX):
        _note(
            f"imports {module.__name__}",
            f"the statement import {module.__name__}, which makes it part of the scenario",
        )
    return module


mark(_import_module)


def _hear(event: str, arguments: Any) -> None:
    """Audit hook."""
    if not _watches or getattr(_hearing, "on", False):
        return
    _hearing.on = True  # what is read to judge a read is none
    try:
        _judge(event, arguments)
    finally:
        _hearing.on = False


def _judge(event: str, arguments: Any) -> None:
    """Note a read from an audit event."""
    if event == "open":
        path, mode, flags = arguments
        new = flags & (os.O_TRUNC | os.O_EXCL) or flags & os.O_ACCMODE == os.O_WRONLY
        if (mode is None and not new) or (mode is not None and ("r" in mode or mode[:2] == "a+")):
            _note_file(path)
    elif event in ("sqlite3.connect", "ctypes.dlopen"):
        _note_file(arguments[0])
    elif event in ("os.listdir", "os.scandir"):
        _note_file(arguments[0] or ".", listed=True)
    elif event in ("subprocess.Popen", "os.system"):
        _note(f"runs {_shorten(arguments[0])}", _AS_DATA)
    elif event == "socket.connect":
        _note("opens a connection", _AS_DATA)


def _note_file(path: Any, *, listed: bool = False) -> None:
    """Note a file that is opened, or a folder that is listed."""
    if not isinstance(path, str | bytes | os.PathLike):
        return  # an open file
    name = os.fsdecode(path)
    caller = _caller()
    if caller is None:
        return
    frame, between = caller
    imported = any(code.co_filename == _IMPORT for code in between)
    file = os.path.abspath(name)
    if file.endswith(".pyc") and imported:
        with contextlib.suppress(ValueError, NotImplementedError):
            file = os.path.abspath(importlib.util.source_from_cache(file))
    is_code = file.endswith((".py", ".pyc"))
    if is_library_file(file) or file == os.devnull or (imported and not is_code):
        return
    if any(part in code.co_filename for code in between for part in _OWN_READERS):
        return
    if file.startswith(_MACHINE) and any(is_library_file(code.co_filename) for code in between):
        return
    if is_code and any(code is linecache.updatecache.__code__ for code in between):
        return  # the lines of a warning or a traceback
    package = frame.f_code.co_filename.partition("/")[0]
    start, declared = folder_of(package) or (Path(os.path.abspath(package)), ())
    inside = Path(file).is_relative_to(start)
    short = Path(file).relative_to(start).as_posix() if inside else name
    if inside and (short in declared or (declared and listed)):
        return
    if is_code:
        _note(
            f"{'imports' if imported else 'reads'} {short}",
            f"the statement import {Path(file).stem}, which makes it part of the scenario",
        )
        return
    if listed:
        _note(f"lists the folder {short}", 'the names of its files, data = ["FILE", ...]')
        return
    relative = not os.path.isabs(short) and ".." not in Path(short).parts
    entry = short if relative else os.path.basename(file)
    copy = "" if relative else f"a copy beside the module, Path(__file__).parent / {entry!r}, and "
    _note(
        f"reads {short}",
        f'{copy}data = ["{entry}"] beside python, or in the body of the class: the file is part '
        "of the scenario",
    )


def _note_variable(action: str) -> None:
    """Note an environment variable that a line of a user reads, itself or by a function of os."""
    caller = _caller()
    if caller is None:
        return
    files = {os.path.basename(code.co_filename) for code in caller[1]}
    names = {code.co_name for code in caller[1]}
    if files <= _ENVIRONMENT and "setdefault" not in names:
        _note(f"reads {action}", _AS_FIELD)


def _note(action: str, remedy: str) -> None:
    """Note a read, if a line of a user leads to it, which no import of a package does."""
    caller = _caller()
    if caller is None or not _watches:
        return
    frame, between = caller
    if any(code.co_filename == _IMPORT for code in between) and not action.startswith("imports "):
        return
    package, _, file = frame.f_code.co_filename.partition("/")
    text = linecache.getline(frame.f_code.co_filename, frame.f_lineno).strip()[:80]
    next(reversed(_watches.values())).append(
        Read(package, file, frame.f_lineno, text, action, remedy)
    )


def _caller() -> tuple[FrameType, list[CodeType]] | None:
    """Innermost frame of a private package, and the code that it has called; None without one."""
    frame: FrameType | None = sys._getframe(1)
    between: list[CodeType] = []
    while frame is not None:
        if frame.f_code.co_filename.startswith(PREFIX):
            return frame, between
        between.append(frame.f_code)
        frame = frame.f_back
    return None


def _shorten(value: Any) -> str:
    text = os.fsdecode(value) if isinstance(value, str | bytes) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


_READERS = WatchedReaders(_note_file)
