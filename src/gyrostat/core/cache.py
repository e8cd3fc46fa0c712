"""Private folder of compiled programs; damaged or incomplete entries are never used.

Security comes from the folder's permissions: only its owner and root can write to it or replace it
or one of its parents. The digest of an entry detects damage (a flipped bit, a truncated file, a
swapped name). It does not stop an attacker who can write to the folder and recompute the digest.
"""

import atexit
import contextlib
import fcntl
import hashlib
import os
import shutil
import stat
import tempfile
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from gyrostat.core.cache_entries import evict, limit

__all__ = ["Cache", "named_folder", "private_cache", "temporary_cache"]

_MARK = b"gyrostat cache 1\n"
_HEADER = len(_MARK) + 32
_LARGEST = 2**30
_LOCK = "lock"
_UNFINISHED = "making-"
_PATTERNS = (_LOCK, f"{_UNFINISHED}*", "lanes-*", "jax-*", "scenario-*", "texts-*", "jax")


@dataclass(frozen=True)
class Cache:
    """Folder of entries that only this user can access.

    Attributes:
        path: Folder, absolute and without symbolic links.
    """

    path: Path

    def read(self, name: str) -> bytes | None:
        """Read an entry; remove it if it is damaged.

        Args:
            name: File name of the entry.

        Returns:
            Content of the entry; None if there is no complete entry of that name.
        """
        path = self.path / name
        with contextlib.suppress(OSError):
            # open neither a symbolic link nor a pipe, which would wait for a writer
            handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
            with open(handle, "rb") as stream:
                status = os.fstat(handle)
                is_private = stat.S_ISREG(status.st_mode) and status.st_uid == os.geteuid()
                if is_private and not status.st_mode & 0o022 and status.st_size <= _LARGEST:
                    entry = stream.read()
                    content = entry[_HEADER:]
                    if entry[:_HEADER] == _header(name, content):
                        with contextlib.suppress(OSError):
                            os.utime(handle)  # the time of last use, for `evict`
                        return content
        with contextlib.suppress(OSError):
            path.unlink()
        return None

    def write(self, name: str, content: bytes) -> None:
        """Write an entry atomically; on a full disk or another error no entry appears.

        Args:
            name: File name of the entry.
            content: Content of the entry.
        """
        with contextlib.suppress(OSError), self.workplace() as folder:
            unfinished = folder / name
            with unfinished.open("xb") as stream:
                unfinished.chmod(0o600)
                stream.write(_header(name, content))
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(unfinished, self.path / name)
            evict(self.path, limit(), name)

    @contextlib.contextmanager
    def workplace(self) -> Iterator[Path]:
        """Give a folder for temporary files, removed at the end.

        Folders left by a killed process are removed when the cache is opened next.

        Raises:
            OSError: The folder cannot be created.
        """
        with (
            _locked(self.path, fcntl.LOCK_SH),
            tempfile.TemporaryDirectory(
                dir=self.path, prefix=_UNFINISHED, ignore_cleanup_errors=True
            ) as folder,
        ):
            yield Path(folder)


def private_cache(say: Callable[[str], None] = warnings.warn) -> Cache | None:
    """Open the private cache: `GYROSTAT_CACHE`, or `gyrostat` in the user's cache folder.

    A folder is not used if it belongs to another user, if others may write to it, or if that is
    true of a parent (parents with the sticky bit, such as /tmp, are accepted). A temporary
    folder then takes its place. Child processes share it; it is removed when this process ends.

    Args:
        say: Called with a one-line message if another folder is used.

    Returns:
        The cache; None if not even a private temporary folder can be created.
    """
    limit()  # refused before anything is compiled
    folder = named_folder()
    cache = None if folder is None else _replaced.get(folder)
    if cache is not None and cache.path.is_dir():
        return cache
    reason = "no home folder" if folder is None else None
    if folder is not None:
        try:
            return _open_cache(folder)
        except OSError as error:
            reason = str(error) if error.errno is None else f"{folder}: {error.strerror}"
    cache = temporary_cache()
    instead = "no cache" if cache is None else f"temporary folder {cache.path}"
    say(
        f"cache of compiled programs: found {reason}, expected a folder (GYROSTAT_CACHE) that only "
        f"you may write to, in parents that only you or root may write to; using {instead}"
    )
    if cache is not None:
        _replaced[cache.path] = cache
        if folder is not None:
            _replaced[folder] = cache
        os.environ["GYROSTAT_CACHE"] = str(cache.path)
    return cache


def named_folder() -> Path | None:
    """Cache folder that the environment selects, absolute; None without a home folder."""
    folder = os.environ.get("GYROSTAT_CACHE")
    if folder:
        return Path(folder).absolute()
    try:
        root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    except RuntimeError:
        return None
    return Path(root).absolute() / "gyrostat"


def temporary_cache() -> Cache | None:
    """Create a private cache that is removed when this process ends; None if it cannot be made."""
    prefix = f"gyrostat-{os.geteuid()}-"
    for base in dict.fromkeys((tempfile.gettempdir(), "/tmp", "/var/tmp")):
        with contextlib.suppress(OSError):
            for old in Path(base).glob(f"{prefix}*"):
                _remove_if_left(old)
            path = Path(tempfile.mkdtemp(prefix=prefix, dir=base)).resolve()
            if _unsafe(path) is not None:
                path.rmdir()
                continue
            lock = contextlib.ExitStack()
            lock.enter_context(_locked(path, fcntl.LOCK_SH))
            if not path.is_dir():  # another process removed it before it was locked
                continue
            atexit.register(_remove, path, lock, os.getpid())
            return Cache(path)
    return None


_replaced: dict[Path, Cache] = {}
_swept: set[Path] = set()


def _header(name: str, content: bytes) -> bytes:
    digest = hashlib.sha256(name.encode() + b"\0")
    digest.update(content)
    return _MARK + digest.digest()


def _open_cache(folder: Path) -> Cache:
    """Create and check a folder, and restrict its permissions.

    Raises:
        OSError: The folder is not private (no errno) or cannot be written.
    """
    path = Path(os.path.realpath(folder))
    if (reason := _unsafe(path)) is not None:
        raise OSError(reason)
    for directory in reversed([p for p in (path, *path.parents) if not p.exists()]):
        directory.mkdir(mode=0o700, exist_ok=True)
    # check again: in a parent such as /tmp another user may have created it meanwhile
    if (reason := _unsafe(path)) is not None:
        raise OSError(reason)
    private = not path.stat().st_mode & 0o077
    if not private and all(any(p.match(pattern) for pattern in _PATTERNS) for p in path.iterdir()):
        path.chmod(0o700)
    if path not in _swept:
        _sweep(path)
        _swept.add(path)
    return Cache(path)


def _unsafe(path: Path) -> str | None:
    """Reason why other users could write files there, or None. Missing folders are ignored."""
    for folder in (path, *path.parents):
        try:
            status = folder.lstat()
        except FileNotFoundError:
            continue
        owners = (os.geteuid(),) if folder == path else (os.geteuid(), 0)
        if status.st_uid not in owners:
            return f"{folder}, which belongs to user {status.st_uid}"
        sticky = folder != path and status.st_mode & stat.S_ISVTX
        if status.st_mode & 0o022 and not sticky:
            return f"{folder}, which others may write to (chmod go-w)"
    return None


@contextlib.contextmanager
def _locked(path: Path, kind: int) -> Iterator[None]:
    """Hold the lock of a cache: shared while files are written, exclusive for the clean-up."""
    handle = os.open(path / _LOCK, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    try:
        fcntl.flock(handle, kind)
        yield
    finally:
        os.close(handle)


def _sweep(path: Path) -> None:
    """Remove temporary files of killed processes, unless files are being written now."""
    with contextlib.suppress(BlockingIOError), _locked(path, fcntl.LOCK_EX | fcntl.LOCK_NB):
        for leftover in path.glob(f"{_UNFINISHED}*"):
            shutil.rmtree(leftover, ignore_errors=True)


def _remove_if_left(path: Path) -> None:
    """Remove a temporary cache whose process was killed."""
    with contextlib.suppress(OSError):
        is_private = path.lstat().st_uid == os.geteuid() and stat.S_ISDIR(path.lstat().st_mode)
        if is_private and (path / _LOCK).exists():
            with _locked(path, fcntl.LOCK_EX | fcntl.LOCK_NB):
                shutil.rmtree(path, ignore_errors=True)


def _remove(path: Path, lock: contextlib.ExitStack, process: int) -> None:
    if os.getpid() == process:  # not in a forked child
        shutil.rmtree(path, ignore_errors=True)
        lock.close()
