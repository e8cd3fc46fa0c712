"""Names of a package that are loaded when they are first used."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any


def lazy_names(
    package: str, shown: Callable[[str, Any], Any] = lambda module, value: value
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Functions `__getattr__` and `__dir__` of a package, and its `__all__`.

    The names and their modules are those of the file `__init__.pyi`, which type checkers read.

    Args:
        package: Name of the package, which is being imported.
        shown: What the package shows of a value of another module: (name of the module, value) ->
            value.
    """
    module = sys.modules[package]
    loader: Any = module.__loader__
    stub = ast.parse(loader.get_data(f"{module.__file__}i"))
    imports = [part for part in stub.body if isinstance(part, ast.ImportFrom)]
    homes = {each.name: str(part.module) for part in imports for each in part.names}

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = shown(homes[name], getattr(import_module(homes[name]), name))
        setattr(module, name, value)
        return value

    def names() -> list[str]:
        return sorted({*homes, *(name for name in vars(module) if name.startswith("__"))})

    return load, names, [*homes]
