"""Classes that are found in the files of a folder."""

from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

Kind = TypeVar("Kind")


def classes_of(folder: ModuleType, base: type[Kind]) -> tuple[type[Kind], ...]:
    """Subclasses of a class that the files of a folder define, in the order of the files.

    The class itself may be in one of them.
    """
    subclasses: list[type[Kind]] = []
    for file in iter_modules(folder.__path__):
        module = import_module(f"{folder.__name__}.{file.name}")
        classes = (each for each in vars(module).values() if isinstance(each, type))
        # not those that the file imports
        classes = (each for each in classes if each.__module__ == module.__name__)
        subclasses += [each for each in classes if issubclass(each, base) and each is not base]
    return tuple(subclasses)
