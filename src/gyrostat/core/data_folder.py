"""Private copies of the data files of user-defined parts, one folder in each process."""

import atexit
import contextlib
import hashlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from threading import RLock

from gyrostat.core.errors import InputError

_FOLDERS: dict[tuple[int, str], Path] = {}
"""Process and digest of the files -> folder."""
_INSIDE = RLock()


def data_folder(files: Mapping[str, bytes]) -> Path:
    """Folder of this process with these files, which is removed when the process ends.

    Args:
        files: Path below the folder -> content.

    Raises:
        InputError: A file in the folder was changed, or the folder cannot be written.
    """
    digests = sorted((path, hashlib.sha256(content).hexdigest()) for path, content in files.items())
    name = os.getpid(), repr(digests)
    folder = _FOLDERS.get(name)
    try:
        if folder is None or not all((folder / path).is_file() for path in files):
            folder = _FOLDERS[name] = _write_copies(files)
        for path, content in files.items():
            if (folder / path).read_bytes() != content:
                raise InputError(
                    f"{path}: found a private copy ({folder / path}) that was changed, expected "
                    "the content of the scenario: a part reads its data, and does not write it"
                )
    except OSError as error:
        reason = (error.strerror or "an error").lower()
        raise InputError(
            f"{error.filename}: found {reason}, expected a copy of a data file of the scenario"
        ) from None
    return folder


def _write_copies(files: Mapping[str, bytes]) -> Path:
    """New folder with these files, which cannot be written."""
    folder = Path(tempfile.mkdtemp(prefix="gyrostat-data-")).resolve()
    atexit.register(_remove, folder, os.getpid())
    for path, content in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(content)
        (folder / path).chmod(0o400)
    return folder


def _remove(folder: Path, process: int) -> None:
    if os.getpid() == process:  # not in a copy of the process
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def working_in(folder: Path | None) -> Iterator[None]:
    """Make a folder the working folder of the process, one thread at a time; None: no change."""
    if folder is None:
        yield
        return
    with _INSIDE:
        before = Path.cwd()
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)
