"""Which modules are the user's: neither Python's, nor of installed packages, nor of this one."""

import sys
import sysconfig
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any

INSTALLED = ("site-packages", "dist-packages")
"""Folders of installed packages."""
_PYTHON = tuple({sysconfig.get_path(name) for name in ("stdlib", "platstdlib")})
_PACKAGE = str(Path(__file__).parents[1])


@lru_cache(maxsize=4096)
def is_library_file(path: str) -> bool:
    """Whether a file belongs to Python, to an installed package or to this package."""
    if path.startswith("<frozen"):
        return True
    if any(part in INSTALLED for part in Path(path).parts):
        return True
    return any(path.startswith(f"{folder}/") for folder in (*_PYTHON, _PACKAGE))


def is_local(module: Any) -> bool:
    """Whether a module, or the module of this name, is of the user.

    A name that no module has is the user's: a class that is made by a call can have any name.
    """
    name = module.__name__ if isinstance(module, ModuleType) else module
    if not isinstance(name, str):
        return False
    top = name.partition(".")[0]
    if top != "__main__" and (top in sys.stdlib_module_names or top == "gyrostat"):
        return False
    module = module if isinstance(module, ModuleType) else sys.modules.get(name)
    if module is None:
        return sys.modules.get(top) is None or is_local(sys.modules[top])
    if name == "__main__":
        return True
    file = getattr(module, "__file__", None)
    if file is not None:
        return not is_library_file(file)
    path = list(getattr(module, "__path__", ()))
    return bool(path) and not all(is_library_file(f"{folder}/") for folder in path)


def owner(value: Any) -> Any:
    """Module name of a class, function or instance."""
    scope = getattr(value, "__globals__", None)
    if isinstance(scope, dict):
        return scope.get("__name__")
    module = getattr(value, "__module__", None)
    return module if isinstance(module, str) else getattr(type(value), "__module__", None)
