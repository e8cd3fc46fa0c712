"""Files of user-defined parts: collected by content, and loaded from their content.

The Python files that a scenario names, the modules below its folder that they import, and the data
files of the parts are part of the scenario. Every process loads the modules from their texts, as
modules of a private package that is named by the digest of all files, so that a campaign runs the
same code everywhere, even if a file changes. Data files are copied into a private folder.
"""

import base64
import builtins
import contextlib
import hashlib
import importlib
import importlib.abc
import importlib.machinery
import linecache
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import count
from pathlib import Path, PurePosixPath
from types import CodeType, ModuleType
from typing import Any, NamedTuple, Self

from gyrostat.core.data_folder import data_folder
from gyrostat.core.errors import InputError

BINARY = "base64:"
"""Start of the text of a data file that is no UTF-8 text."""


@dataclass(frozen=True)
class Source:
    """File or text that belongs to a scenario, such as a user's Python file, by its content.

    Attributes:
        path: Path relative to the folder of the scenario, with "/" between folders; or the place in
            the scenario.
        text: Content; of a data file see `of_data`.
    """

    path: str
    text: str

    @classmethod
    def of_data(cls, path: str, content: bytes) -> Self:
        """Data file: its text if it is UTF-8, otherwise its bytes in base 64 after `BINARY`."""
        try:
            text = content.decode()
        except UnicodeDecodeError:
            text = BINARY
        if text.startswith(BINARY):
            text = BINARY + base64.b64encode(content).decode()
        return cls(path, text)

    @property
    def is_module(self) -> bool:
        """Whether it is a Python module, not a data file."""
        return self.path.endswith(".py")

    @property
    def content(self) -> bytes:
        """Bytes of the file."""
        if not self.is_module and self.text.startswith(BINARY):
            return base64.b64decode(self.text.removeprefix(BINARY))
        return self.text.encode()


class _Package(NamedTuple):
    """Private package.

    Attributes:
        modules: Files by the names of their modules below the package.
        sources: All files.
    """

    modules: Mapping[str, Source]
    sources: tuple[Source, ...]

    def folder(self) -> Path | None:
        """Folder with copies of the data files; None if there are none.

        Raises:
            InputError: A copy was changed.
        """
        data = [source for source in self.sources if not source.is_module]
        return data_folder({source.path: source.content for source in data}) if data else None


PREFIX = "gyrostat_own_"
"""Start of the names of the private packages."""
_PACKAGES: dict[str, _Package] = {}
"""Private packages by name."""
_NUMBERS = count(1)


def is_user_kind(kind: str) -> bool:
    """Whether a kind names a class or function of a user's Python file."""
    return ":" in kind


def kind_from(text: str) -> str | None:
    """Kind "FILE.py:NAME" with a normalised path from a text; None if it has another form."""
    file, _, name = text.partition(":")
    path = PurePosixPath(file)
    if path.suffix != ".py" or "." in path.stem or not name.isidentifier() or "\0" in file:
        return None
    return f"{path}:{name}"


def module_name(path: str) -> str:
    """Name of the module of a file: "parts/drag.py" -> "parts.drag"."""
    parts = PurePosixPath(path).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def joined_sources(
    name: str, sources: tuple[Source, ...], further: tuple[Source, ...]
) -> tuple[Source, ...]:
    """All files of two sets, sorted by path.

    Args:
        name: Name of the scenario, for the message.
        sources: Files.
        further: Further files.

    Raises:
        InputError: Two of them have the same path and other texts.
    """
    files = {source.path: source for source in sources}
    for source in further:
        if files.setdefault(source.path, source) != source:
            raise InputError(
                f"{name}: found two different files {source.path}, expected files with different "
                "names"
            )
    return tuple(files[path] for path in sorted(files))


@lru_cache(maxsize=64)
def package_of(sources: tuple[Source, ...]) -> str:
    """Name of the private package of these files, which can then be imported."""
    digest = hashlib.sha256(repr([(s.path, s.text) for s in sources]).encode()).hexdigest()[:16]
    name = f"{PREFIX}{digest}"
    modules = {module_name(source.path): source for source in sources if source.is_module}
    _PACKAGES[name] = _Package(modules, sources)
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.append(_Finder())
    return name


def load(sources: tuple[Source, ...], kind: str) -> Any:
    """Class or function of a user's Python file.

    Args:
        sources: Python files of the scenario.
        kind: "FILE.py:NAME".

    Raises:
        InputError: The file has no such name; further, what the file raises when it is executed.
    """
    file = kind.partition(":")[0]
    if file not in {source.path for source in sources}:
        raise InputError(f"{kind}: found no file {file}, expected its text in the scenario")
    return _load_object(package_of(sources), kind)


def _load_object(package: str, kind: str) -> Any:
    """Class or function of a private package."""
    file, _, name = kind.partition(":")
    module = f"{package}.{module_name(file)}"
    namespace = importlib.import_module(module)
    if not hasattr(namespace, name):
        names = [n for n, v in vars(namespace).items() if getattr(v, "__module__", None) == module]
        raise InputError(
            f"{file}: found no {name}, expected one of {', '.join(names) or 'its names'}"
        )
    return getattr(namespace, name)


@contextlib.contextmanager
def loaded_again(sources: tuple[Source, ...], kind: str) -> Iterator[Any]:
    """Execute files once more, for an object that nothing else has changed; see `load`."""
    name = f"{package_of(sources)}_{next(_NUMBERS)}"
    _PACKAGES[name] = _PACKAGES[package_of(sources)]
    try:
        yield _load_object(name, kind)
    finally:
        del _PACKAGES[name]
        unload(name)


def packaged(module: str) -> tuple[str, tuple[Source, ...]] | None:
    """Path and all files of a module of a private package; None for any other module."""
    package, _, inner = module.partition(".")
    entry = _PACKAGES.get(package)
    return None if entry is None else (entry.modules[inner].path, entry.sources)


def unload(package: str) -> None:
    """Forget the loaded modules of a private package; the next `load` executes them again."""
    for module in [m for m in sys.modules if m == package or m.startswith(f"{package}.")]:
        del sys.modules[module]


def folder_of(package: str) -> tuple[Path, tuple[str, ...]] | None:
    """Folder of the data files of a private package, and their paths in it; None without any.

    Raises:
        InputError: A file in the folder was changed.
    """
    entry = _PACKAGES.get(package)
    folder = None if entry is None else entry.folder()
    if entry is None or folder is None:
        return None
    return folder, tuple(source.path for source in entry.sources if not source.is_module)


class _Finder:
    """Finds and loads the modules of the private packages."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Specification of a module of a private package; None for any other module."""
        package, _, inner = fullname.partition(".")
        entry = _PACKAGES.get(package)
        if entry is None:
            return None
        source, start = entry.modules.get(inner), f"{inner}." if inner else ""
        folder = not inner or any(name.startswith(start) for name in entry.modules)
        if source is None and not folder:
            return None
        return importlib.machinery.ModuleSpec(fullname, _Loader(package, source), is_package=folder)


class _Loader(importlib.abc.Loader):
    """Executes a module from its text."""

    def __init__(self, package: str, source: Source | None) -> None:
        self._package, self._source = package, source

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """Default module."""

    def exec_module(self, module: ModuleType) -> None:
        """Execute the text; a folder without `__init__.py` has none."""
        if self._source is None:
            return
        code = _compile(self._package, self._source)
        folder = _PACKAGES[self._package].folder()
        # a part reads its data beside `__file__`
        module.__file__ = str(folder / self._source.path) if folder else code.co_filename
        vars(module)["__builtins__"] = _builtins(self._package)
        exec(code, vars(module))


def _compile(package: str, source: Source) -> CodeType:
    name = f"{package}/{source.path}"
    # tracebacks show the lines of the text; without a modification time, it stays
    lines = source.text.splitlines(keepends=True)
    linecache.cache[name] = (len(source.text), None, lines, name)
    return compile(source.text, name, "exec", dont_inherit=True)


@lru_cache(maxsize=64)
def _builtins(package: str) -> dict[str, Any]:
    """Built-in names of own modules: absolute imports find the modules of the scenario first."""
    tops = {name.partition(".")[0] for name in _PACKAGES[package].modules}

    def own_import(
        name: str,
        globals: Mapping[str, object] | None = None,
        locals: Mapping[str, object] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        top = name.partition(".")[0]
        if level or top not in tops:
            return builtins.__import__(name, globals, locals, fromlist or (), level)
        module = builtins.__import__(f"{package}.{name}", globals, locals, fromlist or ())
        return module if fromlist else sys.modules[f"{package}.{top}"]

    return {**vars(builtins), "__import__": own_import}
