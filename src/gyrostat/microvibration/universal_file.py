"""Datasets 58 of universal files, by pyuff."""

import importlib
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing


def datasets(path: Path) -> list[dict[str, Any]]:
    """Datasets of type 58 of a universal file.

    Raises:
        InputError: pyuff is not installed, or the file cannot be read.
    """
    try:
        pyuff: Any = importlib.import_module("pyuff")
    except ImportError:
        raise missing(str(path), "pyuff", "structure") from None
    try:
        with path.open("rb"):
            pass
        file = pyuff.UFF(str(path))
        indices = [k for k, kind in enumerate(file.get_set_types()) if int(kind) == 58]
        found = [file.read_sets(k) for k in indices]
    except Exception as error:  # pyuff raises bare exceptions
        raise InputError(f"{path}: found {error}, expected a universal file") from None
    if not found:
        raise InputError(f"{path}: found no dataset 58, expected functions at nodal degrees")
    return found
