"""Read the Python files of user-defined parts below the folder of a scenario."""

import ast
import importlib.util
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath

from gyrostat.core.errors import InputError, placed
from gyrostat.core.local_modules import INSTALLED
from gyrostat.core.toml_file import read_text
from gyrostat.core.user_modules import Source


def sources_below(
    folder: Path, named: Mapping[str, str], texts: Mapping[str, str] | None = None
) -> tuple[Source, ...]:
    """Files below a folder, and the local modules below it that they import.

    Args:
        folder: Folder of the scenario.
        named: Path relative to it -> place where it is named, for the error message.
        texts: Path -> text, for files that are not read.

    Raises:
        InputError: See `user_sources`.
    """
    texts = texts or {}
    waiting, sources = {**named, **dict.fromkeys(texts, "")}, {}
    while waiting:
        path, where = waiting.popitem()
        text = texts[path] if path in texts else _text(folder, path, where)
        sources[path] = Source(path, text)
        for module_path in _imports(folder, path, text):
            if module_path not in sources:
                waiting[module_path] = f"{folder / path}: import of {module_path}"
    return tuple(sources[path] for path in sorted(sources))


def path_below(folder: Path, path: str, where: str) -> Path:
    """Full path of a file below the folder of a scenario; raises `InputError` for any other."""
    inside = folder.resolve() in (folder / path).resolve().parents
    if PurePosixPath(path).is_absolute() or ".." in PurePosixPath(path).parts or not inside:
        raise InputError(f"{where}: found {path}, expected a file below the folder {folder}")
    return folder / path


def _text(folder: Path, path: str, where: str) -> str:
    """Content of a file below the folder of the scenario."""
    full_path = path_below(folder, path, where)
    with placed(where):
        return read_text(full_path, "a Python file", 1_000_000)


def _imports(folder: Path, path: str, text: str) -> Iterator[str]:
    """Paths of the local modules that a file imports.

    Raises:
        InputError: The text is not Python, or imports a local module from another folder.
    """
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        line = f", line {error.lineno}" if isinstance(error, SyntaxError) else ""
        reason = error.msg if isinstance(error, SyntaxError) else error
        raise InputError(f"{folder / path}{line}: found {reason}, expected Python") from None
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [(alias.name, False) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = _base(folder, path, node)
            names = [(base, False)] if base else []
            start = f"{base}." if base else ""
            names += [(f"{start}{alias.name}", True) for alias in node.names if alias.name != "*"]
            if node.level == 0 and not _files(folder, base):
                names = [(base, False)]
        else:
            continue
        for name, is_attribute in names:
            files = _files(folder, name)
            yield from files
            if not files and not is_attribute and not getattr(node, "level", 0):
                _refuse_local(folder, path, node.lineno, name)


def _base(folder: Path, path: str, node: ast.ImportFrom) -> str:
    """Module below the folder of which a statement imports names."""
    package = PurePosixPath(path).parent.parts
    if node.level > len(package) + 1:
        raise InputError(
            f"{folder / path}, line {node.lineno}: found an import from above the folder of the "
            "scenario, expected modules below it"
        )
    start = package[: len(package) - node.level + 1] if node.level else ()
    return ".".join((*start, *filter(None, [node.module])))


def _files(folder: Path, name: str) -> list[str]:
    """Files that the import of a module executes, if it is below the folder."""
    parts = name.split(".")
    files = [
        "/".join((*parts[:k], "__init__.py"))
        for k in range(1, len(parts) + 1)
        if (folder.joinpath(*parts[:k]) / "__init__.py").is_file()
    ]
    if folder.joinpath(*parts).with_suffix(".py").is_file():
        files.append("/".join(parts) + ".py")
    return files


def _refuse_local(folder: Path, path: str, line: int, name: str) -> None:
    """Raise `InputError` for a module that is neither installed nor part of Python."""
    top = name.partition(".")[0]
    if top in sys.stdlib_module_names or top == "gyrostat":
        return
    try:
        spec = importlib.util.find_spec(top)
    except ValueError:
        spec = None
    if spec is None:
        return
    paths = [spec.origin, *(spec.submodule_search_locations or ())]
    if not any(part in INSTALLED for root in paths if root for part in Path(root).parts):
        raise InputError(
            f"{folder / path}, line {line}: found an import of {name} from {paths[0] or paths[1]}"
            f", expected installed packages, or modules below {folder}"
        )
