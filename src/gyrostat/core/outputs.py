"""Output files that never replace a file of the user.

The file `.gyrostat.json` in an output folder is the manifest of the files that gyrostat wrote
there. For each file it lists the name, the command that wrote it and the SHA-256 digest of the
content. A file may be replaced if the manifest lists it for the same command with its present
digest, or if its content is already the one to be written. Every other file belongs to the user.

All files of a command are first written to a scratch folder and then renamed. The manifest lists
the new digests beside the old ones before the first file is renamed. Therefore each file matches
one of its digests whenever the process is killed.
"""

import contextlib
import fcntl
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.files import (
    UNFINISHED,
    check_writable,
    digest_of,
    read_regular,
    set_aside,
    unwritable,
)

MANIFEST = ".gyrostat.json"
_FORMAT = 1


@dataclass(frozen=True)
class Entry:
    """A file that gyrostat wrote.

    Attributes:
        by: Command that wrote the file, such as "identify".
        digests: SHA-256 digests that the file may have. Several only while it is being replaced.
    """

    by: str
    digests: tuple[str, ...]


class Manifest:
    """List of the files that gyrostat wrote to a folder.

    Attributes:
        folder: Output folder.
        entries: Name relative to the folder -> entry.
        damaged: Whether a file, link or folder named `MANIFEST` exists that is not a manifest.
    """

    def __init__(self, folder: Path):
        """Read the manifest of a folder. Without a manifest no file is listed."""
        self.folder = folder
        self.entries: dict[str, Entry] = {}
        path = folder / MANIFEST
        self.damaged = os.path.lexists(path)
        content = read_regular(path) if self.damaged else None
        if content is not None:
            # RecursionError: thousands of nested brackets
            with contextlib.suppress(
                ValueError, TypeError, KeyError, AttributeError, RecursionError
            ):
                self.entries = _parse(json.loads(content))
                self.damaged = False

    def fault(self, name: str, by: str) -> str | None:
        """Description of the file at `name`, if it must not be replaced; otherwise None."""
        path = self.folder / name
        if name == MANIFEST:
            return "no manifest of gyrostat's" if self.damaged else None
        if not os.path.lexists(path):
            return None
        if path.is_symlink():
            return "a symbolic link"
        if not path.is_file():
            return "a folder or device"
        entry = self.entries.get(name)
        if entry is None:
            return f"a file that gyrostat {_verb(by)} did not write"
        if entry.by != by:
            return f"a file of gyrostat {_verb(entry.by)}"
        if digest_of(path) not in entry.digests:
            return f"a file that was changed since gyrostat {_verb(by)} wrote it"
        return None

    def is_own(self, name: str, by: str) -> bool:
        """Whether the file exists with the content that the command wrote."""
        return os.path.lexists(self.folder / name) and self.fault(name, by) is None

    def write(self, scratch: Path) -> None:
        """Replace the manifest in the folder.

        Args:
            scratch: Folder in the same file system for the unfinished file.

        Raises:
            OSError: The file cannot be written.
        """
        files = {
            name: {"by": entry.by, "sha256": list(entry.digests)}
            for name, entry in sorted(self.entries.items())
        }
        text = json.dumps({"gyrostat": _FORMAT, "files": files}, ensure_ascii=False, indent=1)
        unfinished = scratch / MANIFEST
        unfinished.write_text(text + "\n", encoding="utf-8")
        _sync(unfinished)
        os.replace(unfinished, self.folder / MANIFEST)


def _parse(content: Any) -> dict[str, Entry]:
    if content["gyrostat"] != _FORMAT:
        raise ValueError("another format")
    entries = {}
    for name, row in content["files"].items():
        digests = row["sha256"]
        if not isinstance(row["by"], str) or not all(isinstance(d, str) for d in digests):
            raise TypeError("an entry of another type")
        entries[name] = Entry(row["by"], tuple(digests))
    return entries


def check_outputs(folder: Path, names: Iterable[str], *, by: str, force: bool = False) -> None:
    """Check, before a long computation, that files can be written without replacing the user's.

    Args:
        folder: Output folder; need not exist yet.
        names: Names of the files to write.
        by: The command, such as "identify".
        force: Whether files of the user may be replaced.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    check_writable(folder)
    if not force:
        manifest = Manifest(folder)
        for name in (MANIFEST, *names):
            fault = manifest.fault(name, by)
            if fault is not None:
                raise _in_the_way(folder / name, fault)


@contextlib.contextmanager
def new_files(
    folder: Path, *, by: str, force: bool = False, aside: Callable[[str], None] | None = None
) -> Iterator[Path]:
    """Give a scratch folder whose files move to `folder` if no exception is raised.

    Args:
        folder: Output folder; it is created if it does not exist.
        by: Command that writes the files, such as "identify".
        force: Whether files of the user may be replaced.
        aside: Called with a one-line message for each file of the user that is renamed to
            NAME.changed. If None, such a file is an error and no file is written.

    Raises:
        InputError: A file of the user is in the way, or a file cannot be written.
    """
    try:
        is_new = not folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
        with _locked(folder):
            _sweep(folder)
            scratch = Path(tempfile.mkdtemp(dir=folder, prefix=UNFINISHED))
            alive = _lock(scratch, wait=False)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise unwritable(folder, error) from None
    try:
        yield scratch
        _move(scratch, folder, by, force, aside)
    except OSError as error:
        raise unwritable(folder, error) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
        os.close(alive)
        if is_new:
            with contextlib.suppress(OSError):
                folder.rmdir()  # where nothing was written


def _move(
    scratch: Path, folder: Path, by: str, force: bool, aside: Callable[[str], None] | None
) -> None:
    """Rename every file of the scratch folder into the output folder and add it to the manifest."""
    paths = sorted(path for path in scratch.rglob("*") if path.is_file())
    files = {path.relative_to(scratch).as_posix(): path for path in paths}
    digests = {name: digest_of(path) or "" for name, path in files.items()}
    for path in files.values():
        _sync(path)
    with _locked(folder):
        manifest = Manifest(folder)
        for name in (MANIFEST, *files):
            fault = manifest.fault(name, by)
            if fault is None or digest_of(folder / name) == digests.get(name, ""):
                continue
            if aside is not None:
                new_path = set_aside(folder / name)
                aside(f"{folder / name}: found {fault}: it is kept as {new_path.name}")
            elif not force:
                raise _in_the_way(folder / name, fault)
        for name, digest in digests.items():
            before = digest_of(folder / name)
            manifest.entries[name] = Entry(by, (digest,) if before is None else (before, digest))
        manifest.write(scratch)
        for name, path in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(path, folder / name)
            manifest.entries[name] = Entry(by, (digests[name],))
        manifest.write(scratch)


def _in_the_way(path: Path, fault: str) -> InputError:
    return InputError(
        f"{path}: found {fault}, expected no file, or one of this command: give another --out, "
        "move it, or replace it with --force"
    )


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder while its manifest is changed."""
    handle = _lock(folder, wait=True)
    try:
        yield
    finally:
        os.close(handle)


def _lock(folder: Path, *, wait: bool) -> int:
    """Lock a folder until the handle is closed. Some network file systems have no such locks."""
    handle = os.open(folder, os.O_RDONLY)
    with contextlib.suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    return handle


def _sweep(folder: Path) -> None:
    """Remove the scratch folders of killed processes. Folders of live processes are locked."""
    for leftover in folder.glob(f"{UNFINISHED}*"):
        with contextlib.suppress(OSError):
            handle = os.open(leftover, os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(leftover)
            finally:
                os.close(handle)


def _sync(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _verb(by: str) -> str:
    return by.split()[0]
