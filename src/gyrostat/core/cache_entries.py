"""Entries of the cache of compiled programs: list, size limit and removal."""

import contextlib
import os
import re
import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gyrostat.core.errors import InputError

__all__ = ["KINDS", "Entry", "clear", "entries", "evict", "limit"]

KINDS: Mapping[str, str] = {
    **{"lanes-": "native engine", "jax-": "JAX", "scenario-": "designs"},
    **{"texts-": "exported code", "kernel-": "accelerators"},
}
"""Prefix of an entry's name -> its origin: the engine that compiled it, designs of scenarios or
exported code."""
_DEFAULT = 10**9
_FACTORS = {"": 1, "B": 1, "KB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12}
_FREE_SHARE = 0.1


@dataclass(frozen=True)
class Entry:
    """Compiled program in the cache.

    Attributes:
        path: Path of the file.
        size: Size, bytes.
        used: Time of last use, s since the epoch.
    """

    path: Path
    size: int
    used: float

    @property
    def kind(self) -> str:
        """Engine that compiled the program: a value of `KINDS`."""
        return next(kind for start, kind in KINDS.items() if self.path.name.startswith(start))


def limit() -> int:
    """Largest total size of the entries, bytes: `GYROSTAT_CACHE_LIMIT`, by default 1 GB.

    Raises:
        InputError: The variable is not a size such as "500 MB".
    """
    text = os.environ.get("GYROSTAT_CACHE_LIMIT", "").strip()
    if not text:
        return _DEFAULT
    match = re.fullmatch(r"(\d{1,15}(?:\.\d{1,9})?)\s*([KMGT]?B|)", text, re.ASCII | re.IGNORECASE)
    if match is None:
        raise InputError(f"GYROSTAT_CACHE_LIMIT: found {text!r}, expected a size such as 500MB")
    return int(float(match[1]) * _FACTORS[match[2].upper()])


def entries(folder: Path) -> list[Entry]:
    """List the entries of a cache; other files in its folder are ignored.

    Args:
        folder: Folder of the cache; a missing folder has no entries.

    Returns:
        Entries, the least recently used first.
    """
    programs = []
    with contextlib.suppress(OSError), os.scandir(folder) as files:
        for file in files:
            if file.name.startswith(tuple(KINDS)):
                with contextlib.suppress(OSError):  # another process removed it
                    status = file.stat(follow_symlinks=False)
                    if stat.S_ISREG(status.st_mode):
                        programs.append(Entry(Path(file.path), status.st_size, status.st_mtime))
    return sorted(programs, key=lambda entry: (entry.used, entry.path))


def evict(folder: Path, largest: int, newest: str) -> None:
    """Remove the least recently used entries if a cache is above its size limit.

    Entries are removed down to 90 % of the limit, so that most writes need not remove any.

    Args:
        folder: Folder of the cache.
        largest: Largest total size, bytes.
        newest: Name of the entry that was just written. It is removed only if it exceeds the limit
            by itself.
    """
    programs = entries(folder)
    total = sum(entry.size for entry in programs)
    if total <= largest:
        return
    for entry in sorted(programs, key=lambda entry: entry.path.name == newest):
        enough = largest if entry.path.name == newest else (1.0 - _FREE_SHARE) * largest
        if total <= enough:
            return
        with contextlib.suppress(OSError):
            entry.path.unlink()
        total -= entry.size


def clear(folder: Path) -> list[Entry]:
    """Remove all entries of a cache. Programs that are in use are not affected.

    Args:
        folder: Folder of the cache.

    Returns:
        Entries that were removed.

    Raises:
        InputError: An entry cannot be removed.
    """
    programs = entries(folder)
    for entry in programs:
        try:
            entry.path.unlink(missing_ok=True)
        except OSError as error:
            raise InputError(f"{entry.path}: cannot be removed: {error.strerror}") from None
    return programs
