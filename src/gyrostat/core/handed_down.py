"""Functions of upper rooms that a method of a lower room calls, such as `Scenario.replace`.

A lower room cannot import them: imports point downwards. The root of the package, which may know
every room, names their modules when it is imported; a module is loaded at the first call.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

_HOMES: dict[str, str] = {}


def hand_down(**homes: str) -> None:
    """Name the modules of functions for lower rooms: function -> module."""
    _HOMES.update(homes)


def handed_down(name: str) -> Callable[..., Any]:
    """Load a function that the root of the package has named."""
    return getattr(import_module(_HOMES[name]), name)
