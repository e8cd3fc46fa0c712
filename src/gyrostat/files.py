"""Files that appear under their final name only when whole."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from gyrostat.errors import InputError


def check_writable(folder: Path) -> None:
    """Check, before long work, that files can be written in a folder that may not exist yet.

    Raises:
        InputError: it cannot be made, or nothing can be written there.
    """
    try:
        existing = next(p for p in (folder.absolute(), *folder.absolute().parents) if p.exists())
        with tempfile.TemporaryFile(dir=existing):
            pass
    except (OSError, ValueError) as error:
        raise _unwritable(folder, error) from None


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a temporary file to write; it takes the final name only if no exception is raised.

    The folder is made where it does not exist.

    Args:
        path: final name.

    Raises:
        InputError: the file cannot be written.
    """
    unfinished: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".", suffix=path.suffix)
        os.close(handle)
        unfinished = Path(name)
        yield unfinished
        # a temporary file is private; the result gets the permissions of any new file
        mask = os.umask(0)
        os.umask(mask)
        unfinished.chmod(0o666 & ~mask)
        os.replace(unfinished, path)
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise _unwritable(path, error) from None
    finally:
        if unfinished is not None:
            unfinished.unlink(missing_ok=True)


def write_whole(path: Path, text: str) -> None:
    """Write a text file so that a reader sees either the old one or the whole new one.

    Raises:
        InputError: the file cannot be written.
    """
    with whole_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def _unwritable(path: Path, error: OSError | ValueError) -> InputError:
    reason = getattr(error, "strerror", None) or str(error)
    # a path may hold line breaks and bytes that are no text
    name = str(path) if str(path).isprintable() else repr(str(path))
    return InputError(f"{name}: found no way to write it ({reason}), expected a writable folder")
