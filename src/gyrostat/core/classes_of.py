"""Classes that are found in the files of a folder."""

from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

Kind = TypeVar("Kind")


def classes_of(folder: ModuleType, base: type[Kind]) -> tuple[type[Kind], ...]:
    """Subclasses of a class in the files of a folder, in the order of the files."""
    made: dict[type[Kind], None] = {}
    for file in iter_modules(folder.__path__):
        content = vars(import_module(f"{folder.__name__}.{file.name}")).values()
        kinds = (each for each in content if isinstance(each, type) and issubclass(each, base))
        made |= dict.fromkeys(kind for kind in kinds if kind is not base)
    return tuple(made)
