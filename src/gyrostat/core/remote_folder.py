"""Output folder on an object store: a folder of this machine that is copied to it at once.

Commands write files as always, each of them complete under its name; a thread copies new files
to the store within a second. After a kill the next command finds there what was copied. What cannot
be copied at the end stays on this machine.
"""

import contextlib
import os
import re
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError, reason_of
from gyrostat.core.extras import missing
from gyrostat.core.files import UNFINISHED
from gyrostat.core.outputs import MANIFEST
from gyrostat.core.remote_lock import NAME, RemoteLock

LOOK = 0.5
"""Time between two looks for new files, s."""
_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://.+")
_BUCKETS = {"s3", "s3a", "gs", "gcs", "abfs", "abfss", "az", "oci", "oss"}
"""Protocols of stores without folders."""
State = tuple[int, int]
"""Size and time of change of a file."""


def is_remote(folder: object) -> bool:
    """Whether the name of a folder is an address of fsspec, such as "s3://bucket/prefix"."""
    return isinstance(folder, str) and _URL.fullmatch(folder) is not None


@contextlib.contextmanager
def local_folder(
    folder: str | Path, say: Callable[[str], None], where: str = "--out"
) -> Iterator[tuple[Path, Callable[[str], None]]]:
    """Give a folder of this machine for an output folder that may be on an object store.

    Args:
        folder: Path, or address of fsspec.
        say: Called with each message for the user.
        where: Option with the folder, for messages.

    Yields:
        The folder itself or its copy, and a function for messages, in which the address stands for
        the path of the copy.

    Raises:
        InputError: fsspec or the package of the protocol is not installed, the store cannot be read
            or written, or another command writes to this folder.
    """
    if not is_remote(folder):
        yield Path(folder), say
        return
    url = str(folder).rstrip("/")
    copy = Path(tempfile.mkdtemp(prefix="gyrostat-")) / "campaign"
    copy.mkdir()

    def named(text: str) -> str:
        return text.replace(str(copy), url)

    with contextlib.ExitStack() as stack:
        stack.callback(shutil.rmtree, copy.parent, ignore_errors=True)
        files, root = _file_system(url, where)
        with _one_line(url):
            _make_folder(files, root)
            lock = RemoteLock(files, root, url, say)
        stack.callback(_release, lock)
        mirror = _Mirror(files, root, url, copy, lock, say)
        with _one_line(url):
            mirror.fetch()
        try:
            with mirror.copied():
                try:
                    yield copy, lambda text: say(named(text))
                except InputError as error:
                    raise InputError(named(str(error))) from None
        finally:
            if mirror.is_behind:
                stack.pop_all()
                _release(lock)


def text_of(folder: str | Path, name: str) -> str:
    """Text of a file in a folder that may be on an object store.

    Args:
        folder: Path, or address of fsspec.
        name: Name of the file.

    Raises:
        InputError: The store cannot be read.
        OSError: The file cannot be read.
    """
    if not is_remote(folder):
        return (Path(folder) / name).read_text(encoding="utf-8")
    files, root = _file_system(str(folder).rstrip("/"), "FOLDER")
    with _one_line(str(folder)):
        return files.cat_file(f"{root}/{name}").decode()


class _Mirror:
    """Copy of a folder of an object store on this machine.

    Args:
        files: File system of fsspec.
        root: Path of the folder in it.
        url: Its address.
        folder: Folder of this machine.
        lock: Lock of the folder of the store.
        say: Called with a message if the store does not answer meanwhile.

    Attributes:
        is_behind: Whether the folder has files that could not be copied at the end.
    """

    def __init__(
        self,
        files: Any,
        root: str,
        url: str,
        folder: Path,
        lock: RemoteLock,
        say: Callable[[str], None],
    ):
        self._files, self._root, self._url, self._folder = files, root, url, folder
        self._lock, self._say = lock, say
        self.is_behind = False
        self._copied: dict[str, State] = {}

    def fetch(self) -> None:
        """Copy what the store has to this machine."""
        self._files.invalidate_cache()
        for path in self._files.find(self._root):
            name = path.removeprefix(self._root).lstrip("/")
            # a name that ends with "/" marks a folder; tools that show folders make it
            if name and not name.endswith("/") and _is_copied(name):
                local = self._folder / name
                local.parent.mkdir(parents=True, exist_ok=True)
                self._files.get_file(path, str(local))
                self._copied[name] = _state(local)

    @contextlib.contextmanager
    def copied(self) -> Iterator[None]:
        """Copy new files to the store in the meantime, and all of them at the end."""
        ended = threading.Event()

        def follow() -> None:
            has_told = False
            while not ended.wait(LOOK):
                try:
                    with _one_line(self._url):
                        self._push()
                    has_told = False
                except InputError as error:
                    if not has_told:
                        self._say(f"{error}: it is tried again until the end")
                    has_told = True

        thread = threading.Thread(target=follow, daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
            self.is_behind = True
            try:
                with _one_line(self._url):
                    self._push()
            except InputError as error:
                raise InputError(
                    f"{error}; all files are in {self._folder}, and the same command with --out "
                    f"{self._folder} goes on with them"
                ) from None
            self.is_behind = False
        if self._lock.is_lost:
            raise InputError(
                f"{self._url}: found another campaign that took it over while this one did not "
                "answer, expected none: repeat the command"
            )

    def _push(self) -> None:
        """Copy what is new to the store, and remove there what was renamed here."""
        if self._lock.is_lost:
            return
        states = dict(self._states())
        new = [name for name, state in states.items() if self._copied.get(name) != state]
        for name in sorted(new, key=lambda name: (name == MANIFEST, name)):
            path = f"{self._root}/{name}"
            _make_folder(self._files, path.rpartition("/")[0])
            self._files.put_file(str(self._folder / name), path)
            self._copied[name] = states[name]
        for name in set(self._copied) - set(states):
            self._files.rm_file(f"{self._root}/{name}")
            del self._copied[name]

    def _states(self) -> Iterator[tuple[str, State]]:
        """Name and state of each complete file."""
        # a folder that cannot be read is no folder without files, which would be removed there
        for folder, _, names in os.walk(self._folder, onerror=_raised):
            for name in names:
                path = Path(folder) / name
                relative = path.relative_to(self._folder).as_posix()
                if _is_copied(relative):
                    with contextlib.suppress(FileNotFoundError):  # renamed meanwhile
                        yield relative, _state(path)


def _is_copied(name: str) -> bool:
    """Whether a file, by its path in the folder, is copied: no lock, and not unfinished."""
    *folders, last = name.split("/")
    is_unfinished = last.startswith(UNFINISHED) and last != MANIFEST
    is_lock = last == ".lock" or last.startswith(NAME)
    return not (is_lock or is_unfinished or any(each.startswith(UNFINISHED) for each in folders))


def _raised(error: OSError) -> None:
    raise error


def _release(lock: RemoteLock) -> None:
    with contextlib.suppress(Exception):
        lock.release()


def _make_folder(files: Any, path: str) -> None:
    """Make a folder where there are any; on an object store this would make a missing bucket."""
    protocols = {files.protocol} if isinstance(files.protocol, str) else {*files.protocol}
    if not protocols & _BUCKETS:
        files.makedirs(path, exist_ok=True)


def _state(path: Path) -> State:
    status = path.stat()
    return status.st_size, status.st_mtime_ns


def _file_system(url: str, where: str) -> tuple[Any, str]:
    """File system of an address, and the path in it."""
    try:
        import fsspec  # pyright: ignore[reportMissingImports]
    except ImportError:
        raise missing(where, "fsspec", "s3") from None
    protocol = url.partition("://")[0]
    try:
        with _one_line(url):
            # what another process has written meanwhile must be seen
            files, root = fsspec.url_to_fs(url, use_listings_cache=False, skip_instance_cache=True)
            return files, root.rstrip("/")
    except InputError as error:
        if protocol in ("s3", "s3a") and "s3fs" in str(error).lower():
            raise missing(where, "s3fs", "s3") from None
        raise


@contextlib.contextmanager
def _one_line(url: str) -> Iterator[None]:
    """Turn any error of a store, whose libraries have errors of their own, into one line."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:
        raise InputError(
            f"{url}: found {type(error).__name__} ({reason_of(error)}), expected a store that can "
            "be read and written (an existing bucket, and credentials for it)"
        ) from None
