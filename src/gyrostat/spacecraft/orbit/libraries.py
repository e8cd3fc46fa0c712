"""Import of the libraries of the extra `orbit`, when they are needed."""

from importlib import import_module
from typing import Any

from gyrostat.core.extras import missing

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
        raise missing("orbit", _PACKAGES.get(module, module), "orbit") from None
