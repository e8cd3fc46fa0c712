"""Own parts given as Python objects: their class by content, their fields as values.

The class is loaded again from its text, in this process too, so that a scenario with an object is
the same as one that names the file. A class of an imported module is the text of its file. Of a
class of a script or a notebook, the definition is extracted with the names that it uses, because
workers must not run the script. What the text gives is compared with the object in memory: a text
that was changed later, or an object that was, is refused.
"""

import contextlib
import dataclasses
import inspect
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.local_modules import is_library_file
from gyrostat.core.user_data import with_data
from gyrostat.core.user_errors import UserPartError, reported
from gyrostat.core.user_modules import loaded_again, module_name, package_of, packaged
from gyrostat.core.user_sources import sources_below
from gyrostat.scenario.scenario import Source
from gyrostat.scenario.user.parts import RESERVED, UserPart, as_tree, user_part
from gyrostat.scenario_files.python.comparison import Comparison
from gyrostat.scenario_files.python.difference import DifferentError, PatchedError, Place
from gyrostat.scenario_files.python.library_names import imported_names
from gyrostat.scenario_files.python.script_source import extracted

MOST_CHOICES = 50
"""Most combinations of definitions of a script that are tried."""


class UserObject(NamedTuple):
    """Own part from a Python object.

    Attributes:
        kind: "FILE.py:NAME".
        sources: Its file and the local modules that this imports.
        values: Values of its keys, without the section, SI.
        live: The object in memory.
    """

    kind: str
    sources: tuple[Source, ...]
    values: dict[str, float]
    live: Any


class _Text(NamedTuple):
    """Text of a class or function.

    Attributes:
        kind: "FILE.py:NAME".
        sources: Its file and the local modules that this imports.
        folder: Folder of the files.
        module: Name of its module in memory.
    """

    kind: str
    sources: tuple[Source, ...]
    folder: Path
    module: str


def user_object(section: str, given: Any) -> UserObject:
    """Kind, sources and values of an object.

    Args:
        section: Section of the scenario, such as "controller".
        given: Instance of a user-defined class; or the class itself, for the default values.

    Raises:
        InputError: The class cannot be found in a file or extracted from a script, is not the one
            of its text, or a field is not a number.
    """
    is_kind = inspect.isclass(given) or inspect.isroutine(given) or hasattr(given, "__wrapped__")
    definition = given if is_kind else type(given)
    label = f"{section} {getattr(definition, '__qualname__', type(definition).__name__)}"
    with reported(label):  # comparing asks objects of the user for their attributes
        kind, sources = _source(section, label, definition, given)
    part = user_part(section, kind, sources)
    values: dict[str, float] = {}
    for name, key in part.keys.items():
        if given is not definition:
            value = _numbers(label, name, getattr(given, name), key.shape)
        elif key.default is None:
            raise UserPartError(f"{label}: found no value of {name}, expected an object with one")
        else:
            value = key.defaults()
        values |= dict(zip(key.ends(name), value, strict=True))
    for name in RESERVED:
        if given is not definition and getattr(given, name, None) is not None:
            raise UserPartError(
                f"{label}: found a value of {name}, expected None: the scenario gives it"
            )
    return UserObject(kind, sources, values, given)


def _numbers(label: str, name: str, value: Any, shape: tuple[int, ...]) -> tuple[float, ...]:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = None
    if array is None or array.shape != shape:
        expected = "a number" if shape == () else f"numbers of shape {shape}"
        raise UserPartError(f"{label}: found {name} = {value!r}, expected {expected}")
    return tuple(array.ravel().tolist())


def _source(section: str, label: str, definition: Any, live: Any) -> tuple[str, tuple[Source, ...]]:
    """Kind and sources of a class or function, which were compared with the object."""
    if "." in definition.__qualname__ or not definition.__name__.isidentifier():
        raise UserPartError(
            f"{label}: found a lambda, or a definition inside another, expected a class or "
            "function of a module"
        )
    module = sys.modules.get(definition.__module__)
    if getattr(module, definition.__name__, definition) is not definition:
        raise UserPartError(
            f"{label}: found an earlier definition of {definition.__name__}, expected an object of "
            "the present one"
        )
    package = packaged(definition.__module__)
    if package is not None:
        path, sources = package
        return f"{path}:{definition.__name__}", sources
    if definition.__module__ != "__main__":
        text = _file_text(label, definition)
        remedy = "import the module again in a new process, or write the change into its file"
        try:
            _require_equal(section, text, definition, live)
        except DifferentError as different:
            raise _refusal(label, text, different, remedy) from None
        return text.kind, text.sources
    choice: Mapping[str, int] | None = {}
    first: tuple[_Text, DifferentError] | None = None
    for _ in range(MOST_CHOICES):
        extract = extracted(label, definition, choice)
        kind = f"{extract.file}:{definition.__name__}"
        sources = sources_below(extract.folder, {}, {extract.file: extract.text})
        sources = with_data(extract.folder, sources, [kind], {})
        text = _Text(kind, sources, extract.folder, "__main__")
        try:
            _require_equal(section, text, definition, live)
        except DifferentError as different:
            first = first or (text, different)
            choice = extract.other(different.place.names)
        else:
            return text.kind, text.sources
        if choice is None:
            break
    assert first is not None
    remedy = "execute its definition again, or move it into a module file and import it"
    raise _refusal(label, *first, remedy)


def _refusal(label: str, text: _Text, different: DifferentError, remedy: str) -> UserPartError:
    file = text.kind.partition(":")[0]
    if isinstance(different, PatchedError):
        return UserPartError(
            f"{label}: found {different.place.text}: {different.live} in memory, expected "
            f"{different.loaded}: other processes do not have the change; restore it, and give the "
            "value a name of your own"
        )
    return UserPartError(
        f"{label}: found {different.place.text}: {different.live} in memory, {different.loaded} "
        f"from the text of {file}, expected the same: {remedy}"
    )


def _file_text(label: str, definition: Any) -> _Text:
    """Text of a class or function of a local module."""
    module = sys.modules.get(definition.__module__)
    path = Path(getattr(module, "__file__", None) or "")
    if definition.__module__.partition(".")[0] == "gyrostat":
        raise UserPartError(
            f"{label}: found a class of gyrostat, expected a class of yours, or a kind by its name"
        )
    if path.suffix != ".py" or is_library_file(str(path.resolve())):
        raise UserPartError(
            f"{label}: found {definition.__qualname__} of {definition.__module__}, which is no "
            "local file, expected an object of a class of your own"
        )
    depth = definition.__module__.count(".") + (path.name == "__init__.py")
    folder = path.resolve().parents[depth]
    relative_path = path.resolve().relative_to(folder).as_posix()
    kind = f"{relative_path}:{definition.__name__}"
    sources = with_data(folder, sources_below(folder, {relative_path: label}), [kind], {})
    return _Text(kind, sources, folder, definition.__module__)


def _require_equal(section: str, text: _Text, definition: Any, live: Any) -> None:
    """Compare an object in memory with the one that its text gives.

    Raises:
        DifferentError: They differ.
        InputError: The text raises an exception.
    """
    part = UserPart(f"{section} {text.kind}", None, (), {})
    with contextlib.ExitStack() as stack:
        with reported(part.name, package_of(text.sources)):
            loaded = stack.enter_context(loaded_again(text.sources, text.kind))
        package, _, path = loaded.__module__.partition(".")
        names = [module_name(source.path) for source in text.sources if source.is_module]
        texts = {name: f"{package}.{name}" for name in names}
        root = str(Path(sys.modules[loaded.__module__].__file__ or "").parents[path.count(".")])
        texts |= {text.module: loaded.__module__, str(text.folder): root}
        comparison = Comparison(texts)
        comparison.require_equal(definition.__name__, definition, loaded)
        for source in text.sources:
            for module, name in imported_names(source.text):
                comparison.library_name(Place(f"{module.__name__}.{name}"), module, name)
        if live is not definition:
            kind = as_tree(part, loaded)
            with reported(part.name, loaded.__module__):
                copy = _remake(kind, live)
            for name in sorted({*vars(live), *vars(copy)}):
                live_value, loaded_value = (getattr(each, name, "nothing") for each in (live, copy))
                comparison.compare(Place(f"{definition.__name__}.{name}"), live_value, loaded_value)


def _remake(kind: type, live: Any) -> Any:
    """Instance of a class with the fields of another one that the scenario passes on."""
    fields = [f.name for f in dataclasses.fields(kind) if f.init and not f.metadata.get("static")]
    return kind(**{name: getattr(live, name, None) for name in fields})
