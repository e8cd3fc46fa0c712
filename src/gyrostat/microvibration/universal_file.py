"""Datasets 58 of universal files, by pyuff."""

import importlib
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.read import require_readable

_WANTED = "a universal file"


def datasets(path: Path) -> list[dict[str, Any]]:
    """Datasets of type 58 of a universal file.

    Raises:
        InputError: pyuff is not installed, or the file cannot be read.
    """
    try:
        pyuff: Any = importlib.import_module("pyuff")
    except ImportError:
        raise missing(str(path), "pyuff", "structure") from None
    require_readable(path, _WANTED)
    try:
        file = pyuff.UFF(str(path))
        indices = [k for k, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        found = [file.read_sets(k) for k in indices]
    except Exception as error:  # pyuff raises bare exceptions
        raise damaged(path, _WANTED, error) from None
    if not found:
        raise InputError(f"{path}: found no dataset 58, expected functions at nodal degrees")
    return found
