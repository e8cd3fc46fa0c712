"""Data files of user-defined parts: declared beside `python`, or in the class, and read.

A class declares its files in its body, relative to the folder of its module:

    data = ("weights.npz",)
"""

import ast
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from gyrostat.core.errors import InputError, placed
from gyrostat.core.toml_file import described, read_content
from gyrostat.core.user_modules import Source
from gyrostat.core.user_sources import path_below

LARGEST_DATA = 10_000_000
"""Largest data file of a part, bytes: it is stored in the text of the scenario."""


def data_names(place: str, found: Any) -> dict[str, str]:
    """Paths of the key `data`: path relative to the folder of the scenario -> place of the path.

    Args:
        place: File and key, for messages.
        found: Value of the key.

    Raises:
        InputError: The value is not a list of different paths.
    """
    if not isinstance(found, list | tuple) or not found:
        text = "an empty list" if isinstance(found, list | tuple) else described(found)
        raise InputError(f'{place}: found {text}, expected paths, such as ["weights.npz"]')
    names: dict[str, str] = {}
    for k, path in enumerate(found):
        inner = f"{place}[{k}]"
        if not isinstance(path, str) or not path or "\0" in path:
            raise InputError(f"{inner}: found {path!r}, expected the path of a file")
        name = str(PurePosixPath(path))
        if name in names:
            raise InputError(f"{inner}: found {path} twice, expected each file once")
        names[name] = inner
    return names


def with_data(
    folder: Path, sources: tuple[Source, ...], kinds: Iterable[str], data: Mapping[str, str]
) -> tuple[Source, ...]:
    """Modules of a scenario, and the data files of its parts, sorted by path.

    Args:
        folder: Folder of the scenario.
        sources: Modules.
        kinds: "FILE.py:NAME" of each part, whose class may declare data files.
        data: Path relative to the folder -> place where it is declared, for messages.

    Raises:
        InputError: A file cannot be read, is too large, is a Python module or is not below the
            folder.
    """
    paths = dict(data)
    for kind in kinds:
        file, _, name = kind.partition(":")
        text = next(source.text for source in sources if source.path == file)
        for path in _of_class(text, name):
            where = f"{folder / file}: {name}.data"
            for entry, _ in data_names(where, [path]).items():
                paths.setdefault(str(PurePosixPath(file).parent / entry), where)
    files = [*sources, *(_read(folder, path, where) for path, where in paths.items())]
    return tuple(sorted(files, key=lambda source: source.path))


def _of_class(text: str, name: str) -> Iterator[str]:
    """Texts in the attribute `data` in the body of a class of a module."""
    for kind in ast.parse(text).body:
        if not isinstance(kind, ast.ClassDef) or kind.name != name:
            continue
        for node in kind.body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            if isinstance(node, ast.AnnAssign):
                targets = [node.target]
            is_data = any(isinstance(each, ast.Name) and each.id == "data" for each in targets)
            value = getattr(node, "value", None)
            if is_data and isinstance(value, ast.Tuple | ast.List):
                entries = [getattr(each, "value", None) for each in value.elts]
                yield from (each for each in entries if isinstance(each, str))


def _read(folder: Path, path: str, where: str) -> Source:
    """Data file below the folder of the scenario."""
    if path.endswith(".py"):
        raise InputError(
            f"{where}: found the Python file {path}, expected a data file: modules are found by "
            "the import statements of the part"
        )
    full_path = path_below(folder, path, where)
    kind = f"a data file of at most {LARGEST_DATA // 10**6} MB"
    with placed(where):
        return Source.of_data(path, read_content(full_path, kind, LARGEST_DATA))
