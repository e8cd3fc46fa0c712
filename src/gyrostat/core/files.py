"""Atomic file writing: a file appears under its name only when it is complete."""

import fcntl
import hashlib
import os
import re
import stat
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import TypeVar

from gyrostat.core.errors import InputError

T = TypeVar("T")

_LARGE = 64_000_000
"""Size from which digests are remembered, bytes."""
_DIGESTS: dict[Path, tuple[tuple[int, ...], str]] = {}
"""Path of a large file -> its inode, size and times of change, and its digest."""

_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:/")
UNFINISHED = ".gyrostat-"
"""Prefix of the names of temporary files and folders."""


def check_writable(folder: Path) -> None:
    """Check, before long work, that files can be written to a folder that may not exist yet.

    Raises:
        InputError: The folder cannot be created, no file can be written there, or the name is that
            of an address such as s3://BUCKET/PREFIX.
    """
    if _ADDRESS.match(str(folder)):
        raise InputError(
            f"{folder}: found an address, expected a folder of this machine (an address, such as "
            "s3://BUCKET/PREFIX, is possible for gyrostat campaign, as text)"
        )
    try:
        existing = next(p for p in (folder.absolute(), *folder.absolute().parents) if p.exists())
        with tempfile.TemporaryFile(dir=existing):
            pass
    except (OSError, ValueError) as error:
        raise unwritable(folder, error) from None


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary file to write; it gets its final name only if no exception is raised.

    The folder is created if it does not exist.

    Args:
        path: Final path of the file.

    Raises:
        InputError: The file cannot be written.
    """
    unfinished: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=UNFINISHED, suffix=path.suffix)
        os.close(handle)
        unfinished = Path(name)
        yield unfinished
        # a temporary file is private; the result gets the permissions of an ordinary new file
        mask = os.umask(0)
        os.umask(mask)
        unfinished.chmod(0o666 & ~mask)
        os.replace(unfinished, path)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise unwritable(path, error) from None
    finally:
        if unfinished is not None:
            unfinished.unlink(missing_ok=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text file atomically: a reader sees the old content or all of the new content.

    Raises:
        InputError: The file cannot be written.
    """
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def write_texts(folder: Path, texts: Mapping[str, str]) -> None:
    """Write text files to a folder that is removed or renamed if it is left incomplete.

    Args:
        folder: Existing folder.
        texts: Name, or path relative to the folder, -> text. Folders in it are created.
    """
    for name, text in texts.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def set_aside(path: Path) -> Path:
    """Rename a file, link or folder to NAME.changed, or NAME.changed.2 and so on.

    Returns:
        New path.

    Raises:
        InputError: The file cannot be renamed.
    """
    number, free = 1, path.with_name(f"{path.name}.changed")
    while os.path.lexists(free):
        number += 1
        free = path.with_name(f"{path.name}.changed.{number}")
    try:
        return path.rename(free)
    except OSError as error:
        raise unwritable(path, error) from None


def read_regular(path: Path) -> bytes | None:
    """Content of a regular file; None if there is no file, or a link, folder or device instead.

    Raises:
        InputError: The file cannot be read.
    """
    return _with_regular(path, lambda stream: stream.read())


def digest_of(path: Path) -> str | None:
    """SHA-256 digest of a regular file; None if there is no file, or a link, folder or device.

    A large file that this process has read before is not read again unless it has changed.

    Raises:
        InputError: The file cannot be read.
    """

    def digest(stream: BufferedReader) -> str:
        state = os.fstat(stream.fileno())
        content = (state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns)
        known = _DIGESTS.get(path)
        if state.st_size >= _LARGE and known is not None and known[0] == content:
            return known[1]
        value = hashlib.file_digest(stream, "sha256").hexdigest()
        if state.st_size >= _LARGE:
            _DIGESTS[path] = content, value
        return value

    return _with_regular(path, digest)


def _with_regular(path: Path, use: Callable[[BufferedReader], T]) -> T | None:
    try:
        if not stat.S_ISREG(os.lstat(path).st_mode):
            return None
        # another process may put a pipe in the file's place, and reading it would block
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(handle, "rb") as stream:
            return use(stream)
    except (FileNotFoundError, NotADirectoryError):
        return None
    except OSError as error:
        raise InputError(
            f"{path}: found no way to read it ({error.strerror}), expected a readable file"
        ) from None


def lock(handle: int, message: str) -> None:
    """Lock an open file; raises `InputError` with the message if it is locked already."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise InputError(message) from None


def unwritable(path: Path, error: OSError | ValueError) -> InputError:
    """Error for a file or folder that cannot be written."""
    reason = getattr(error, "strerror", None) or str(error)
    # a path may contain line breaks and bytes that are not text
    name = str(path) if str(path).isprintable() else repr(str(path))
    return InputError(f"{name}: found no way to write it ({reason}), expected a writable folder")
