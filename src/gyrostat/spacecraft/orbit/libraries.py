"""Import of the libraries of the extra `orbit`, when they are needed."""

from importlib import import_module
from typing import Any

from gyrostat.core.errors import InputError

_PACKAGES = {"erfa": "pyerfa", "sgp4.api": "sgp4", "sgp4.io": "sgp4"}


def library(module: str) -> Any:
    """Import a module of a library of the extra `orbit`.

    Args:
        module: Name of the module, such as "erfa".

    Raises:
        InputError: The library is not installed.
    """
    try:
        return import_module(module)
    except ImportError:
        raise InputError(
            f"orbit: found no {_PACKAGES.get(module, module)}, expected the extra orbit "
            "(pip install 'gyrostat[orbit]')"
        ) from None
