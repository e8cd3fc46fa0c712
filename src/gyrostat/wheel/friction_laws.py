"""Friction laws by name, by class, or from a user's Python file."""

import hashlib
import inspect
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.user_data import data_names, with_data
from gyrostat.core.user_errors import reported
from gyrostat.core.user_modules import Source, is_user_kind, kind_from, load, package_of, packaged
from gyrostat.core.user_sources import sources_below
from gyrostat.wheel.friction import FRICTION_MODELS, WHEEL_FRICTION, AnyFriction, Bristles, Friction
from gyrostat.wheel.friction.contract import check_law

Law = type[Friction] | type[Bristles]
"""Class of a friction law, static or with bristles."""


def friction_law(
    law: str | Law, where: str = "model", beside: tuple[str, ...] = ()
) -> type[Friction]:
    """Static friction law from its name, its class or "FILE.py:CLASS".

    Args:
        law: Name of a law of this package, path and class in a Python file, or the class itself.
            The modules beside the file are found by its imports.
        where: Place to name in the error message.
        beside: Other names that the place allows, for the message.

    Raises:
        InputError: There is no such law, or it breaks the contract of `gyrostat.wheel.friction`.
    """
    if isinstance(law, str) and is_user_kind(law):
        path, _, name = law.rpartition(":")
        kind = kind_from(f"{Path(path).name}:{name}")
        if kind is None:
            raise _unknown(where, law, beside)
        return static(law_below(Path(path).parent, kind, where)[0], where)
    if isinstance(law, str):
        if law not in FRICTION_MODELS:
            raise _unknown(where, law, beside)
        return FRICTION_MODELS[law]
    return static(require_law(law, where), where)


def _unknown(where: str, found: object, beside: tuple[str, ...]) -> InputError:
    return InputError(
        f"{where}: found {found!r}, expected one of {', '.join((*beside, *FRICTION_MODELS))}, a "
        "class of your own or FILE.py:CLASS"
    )


def static(law: Law, where: str) -> type[Friction]:
    """Return a law itself if it is a static curve; raises `InputError` if it has bristles."""
    if not issubclass(law, Friction):
        raise InputError(
            f"{where}: found {law.__name__}, expected a wheel with a static friction curve"
        )
    return law


def require_law(law: Any, where: str) -> Law:
    """Return a class itself if it is a friction law.

    Raises:
        InputError: It is something else, or breaks the contract.
    """
    if not inspect.isclass(law) or not issubclass(law, AnyFriction):
        name = law.__name__ if inspect.isclass(law) else type(law).__name__
        raise InputError(
            f"{where}: found {name}, expected a subclass of gyrostat.wheel.friction.Friction"
        )
    if issubclass(law, Friction) and not law.is_shipped():
        check_law(law)
        if law.name in WHEEL_FRICTION:
            raise InputError(
                f"{where}: found {law.__name__} with the name {law.name!r}, that of a law of "
                "gyrostat, expected another name"
            )
    return law


def law_below(
    folder: Path,
    kind: str,
    where: str,
    digests: Mapping[str, str] | None = None,
    data: Mapping[str, str] | None = None,
) -> tuple[Law, tuple[Source, ...]]:
    """Law of a Python file below a folder, and the texts of the file and its local imports.

    Args:
        folder: Folder of the file that names the law.
        kind: "FILE.py:CLASS", relative to the folder.
        where: Place to name in the error message.
        digests: Path -> digest that its content must have; None if they are not known.
        data: Path of a data file -> place where it is declared; None: those of the digests.

    Raises:
        InputError: A file is missing or was edited, or the class is no friction law.
    """
    for path in digests or ():
        if not (folder / path).is_file():
            raise InputError(f"{where}: found no file {folder / path}, expected the text of {kind}")
    if data is None:
        data = {path: where for path in digests or () if not path.endswith(".py")}
    sources = sources_below(folder, {kind.partition(":")[0]: where})
    sources = with_data(folder, sources, [kind], data)
    for source in sources:
        if digests is not None and digests.get(source.path) != digest(source):
            raise InputError(
                f"{folder / source.path}: found a text that was edited since {where} was written, "
                "expected the same: identify the wheel again, or remove the table [sources] to "
                "accept it"
            )
    return loaded_law(kind, sources, where), sources


def read_law(path: Path, key: str, table: Mapping[str, Any], digests: object = None) -> Law:
    """Friction law that a file names, of this package or from a Python file beside it.

    Args:
        path: Path of the file.
        key: Full key; its last part is the key of the table.
        table: Table with the name of the law, or "FILE.py:CLASS" and its data files.
        digests: Path -> digest that the texts of a user's law must have; None if not known.

    Raises:
        InputError: There is no such law, its file is missing or was edited, or it is no friction.
    """
    name, where = table.get(key.rpartition(".")[2]), f"{path}: key {key}"
    kind = kind_from(name) if isinstance(name, str) and not key.endswith(".kind") else None
    if kind is not None:
        if digests is not None and not isinstance(digests, dict):
            raise InputError(f"{path}: key sources: found a value, expected a table")
        data = None
        if "data" in table:
            data = data_names(f"{path}: key {key.rpartition('.')[0]}.data", table["data"])
        return law_below(path.parent, kind, where, digests, data)[0]
    if digests is not None:
        raise InputError(f"{path}: key sources: found it, expected none with this {key}")
    forms = () if key.endswith(".python") else WHEEL_FRICTION
    if not isinstance(name, str) or name not in forms:
        found = "none" if name is None else repr(name)
        expected = [*forms, *([] if key.endswith(".kind") else ["FILE.py:CLASS"])]
        raise InputError(f"{where}: found {found}, expected one of {', '.join(expected)}")
    return WHEEL_FRICTION[name]


def loaded_law(kind: str, sources: tuple[Source, ...], where: str = "friction") -> Law:
    """Law of a user's Python file, from its texts.

    Raises:
        InputError: The file cannot be executed, or the class is no friction law.
    """
    with reported(f"{where} {kind}", package_of(sources)):
        law = load(sources, kind)
    return require_law(law, f"{where} {kind}")


def law_of(name: str, sources: tuple[Source, ...]) -> Law:
    """Law of a scenario: by its name, or from the texts of the scenario."""
    return loaded_law(name, sources) if is_user_kind(name) else WHEEL_FRICTION[name]


def law_texts(law: Law) -> tuple[str, tuple[Source, ...]] | None:
    """Kind and texts of a law that was loaded from texts; None of every other law."""
    origin = packaged(law.__module__)
    return None if origin is None else (f"{origin[0]}:{law.__name__}", origin[1])


def digest(source: Source) -> str:
    """SHA-256 digest of a file."""
    return hashlib.sha256(source.content).hexdigest()


def write_texts(folder: Path, sources: Collection[Source]) -> None:
    """Write the files of a law below a folder."""
    for source in sources:
        path = folder / source.path
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(source.content)
