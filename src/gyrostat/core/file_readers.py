"""Readers of packages that open files in C, without the audit event of Python.

While reads are watched, each is replaced by one that reports the path that it is given.
"""

import functools
import importlib.abc
import importlib.machinery
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from types import FunctionType, ModuleType
from typing import Any

READERS = {
    "h5py.h5f": ("open",),
    "netCDF4": ("Dataset",),
    "pyarrow": ("OSFile", "memory_map"),
    "pyarrow.csv": ("read_csv", "open_csv"),
    "pyarrow.dataset": ("dataset",),
    "pyarrow.feather": ("read_table", "read_feather"),
    "pyarrow.json": ("read_json", "open_json"),
    "pyarrow.orc": ("ORCFile.__init__",),
    "pyarrow.parquet.core": ("ParquetFile.__init__", "ParquetDataset.__init__"),
}
"""Module -> its functions and classes that open files."""
Report = Callable[[Any], None]
"""Receives the path that a reader is given."""


class WatchedReaders(importlib.abc.MetaPathFinder):
    """Replaces the readers of all modules, also of those that are imported while it is on.

    Args:
        report: Called with each path before it is read.
    """

    def __init__(self, report: Report) -> None:
        self._report = report
        self._replaced: list[tuple[Any, str, Any]] = []

    def switch_on(self) -> None:
        """Replace the readers."""
        for name in READERS:
            if name in sys.modules:
                self._replace(sys.modules[name])
        sys.meta_path.insert(0, self)

    def switch_off(self) -> None:
        """Restore the readers."""
        sys.meta_path.remove(self)
        while self._replaced:
            setattr(*self._replaced.pop())

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Specification of a module of `READERS` that replaces its readers when it is executed."""
        if fullname not in READERS:
            return None
        finders = (finder for finder in sys.meta_path if finder is not self)
        specs = (finder.find_spec(fullname, path, target) for finder in finders)
        spec = next((each for each in specs if each is not None), None)
        if spec is not None and spec.loader is not None:
            loader: Any = spec.loader
            execute = loader.exec_module

            def exec_module(module: ModuleType) -> None:
                execute(module)
                self._replace(module)

            loader.exec_module = exec_module
        return spec

    def _replace(self, module: ModuleType) -> None:
        for name in READERS[module.__name__]:
            owner, _, method = name.rpartition(".")
            scope: Any = getattr(module, owner, None) if owner else module
            real = getattr(scope, method, None)
            if real is not None:
                self._replaced.append((scope, method, real))
                setattr(scope, method, _reporting(real, self._report))


def real(value: Any) -> Any:
    """Function or class of a package itself, if the value is what replaces it; or the value."""
    is_marked = isinstance(value, type | FunctionType) and "_gyrostat_reader" in vars(value)
    return vars(value)["__wrapped__"] if is_marked else value


def mark(replacement: Any) -> None:
    """Mark a function or class that replaces its attribute `__wrapped__`; see `real`."""
    replacement._gyrostat_reader = True


def _reporting(reader: Any, report: Report) -> Any:
    """Reader that reports its paths."""
    if isinstance(reader, type):

        def make(kind: Any, *arguments: Any, **options: Any) -> Any:
            for path in _paths(arguments, options):
                report(path)
            return reader.__new__(kind, *arguments, **options)

        wrapper: Any = type(reader.__name__, (reader,), {"__new__": make, "__wrapped__": reader})
        wrapper.__module__ = reader.__module__
    else:

        @functools.wraps(reader)
        def read(*arguments: Any, **options: Any) -> Any:
            for path in _paths(arguments, options):
                report(path)
            return reader(*arguments, **options)

        wrapper = read
    mark(wrapper)
    return wrapper


def _paths(arguments: Sequence[Any], options: dict[str, Any]) -> Iterator[Any]:
    """Paths among the first arguments, of which the first may be the object of a method."""
    for value in (*arguments[:2], *options.values()):
        values = value if isinstance(value, list | tuple) else [value]
        yield from (path for path in values if isinstance(path, str | bytes | os.PathLike))
