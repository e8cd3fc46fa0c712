"""Own parts given as Python objects: their class by content, their fields as values.

The class is loaded again from its text, in this process too, so that a scenario with an object is
the same as one that names the file. A class of an imported module is the text of its file. Of a
class of a script or a notebook, the definition is extracted with the names that it uses, because
workers must not run the script.
"""

import inspect
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from gyrostat.campaigns.own.parts import RESERVED, own_part
from gyrostat.campaigns.own.script_source import extracted
from gyrostat.campaigns.scenario import Source
from gyrostat.core.user_errors import OwnError
from gyrostat.core.user_modules import packaged
from gyrostat.core.user_sources import INSTALLED, sources_below


class OwnObject(NamedTuple):
    """Own part from a Python object.

    Attributes:
        kind: "FILE.py:NAME".
        sources: Its file and the local modules that this imports.
        values: Values of its keys, without the section, SI.
    """

    kind: str
    sources: tuple[Source, ...]
    values: dict[str, float]


def own_object(section: str, given: Any) -> OwnObject:
    """Kind, sources and values of an object.

    Args:
        section: Section of the scenario, such as "controller".
        given: Instance of a user-defined class; or the class itself, for the default values.

    Raises:
        InputError: The class cannot be found in a file or extracted from a script, or a field is
            not a number.
    """
    made = given if inspect.isclass(given) or inspect.isroutine(given) else type(given)
    place = f"{section} {made.__qualname__}"
    kind, sources = _source(place, made)
    part = own_part(section, kind, sources)
    values: dict[str, float] = {}
    for name, key in part.keys.items():
        if given is made and key.default is None:
            raise OwnError(f"{place}: found no value of {name}, expected an object with one")
        if given is made:
            value = key.defaults()
        else:
            value = _numbers(place, name, getattr(given, name), key.shape)
        values |= dict(zip(key.ends(name), value, strict=True))
    for name in RESERVED:
        if given is not made and getattr(given, name, None) is not None:
            raise OwnError(
                f"{place}: found a value of {name}, expected None: the scenario gives it"
            )
    return OwnObject(kind, sources, values)


def _numbers(place: str, name: str, value: Any, shape: tuple[int, ...]) -> tuple[float, ...]:
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        found = None
    if found is None or found.shape != shape:
        expected = "a number" if shape == () else f"numbers of shape {shape}"
        raise OwnError(f"{place}: found {name} = {value!r}, expected {expected}")
    return tuple(found.ravel().tolist())


def _source(place: str, made: Any) -> tuple[str, tuple[Source, ...]]:
    """Kind and sources of a class or function."""
    if "." in made.__qualname__ or not made.__name__.isidentifier():
        raise OwnError(
            f"{place}: found a lambda, or a definition inside another, expected a class or "
            "function of a module"
        )
    if getattr(sys.modules.get(made.__module__), made.__name__, made) is not made:
        raise OwnError(
            f"{place}: found an earlier definition of {made.__name__}, expected an object of the "
            "present one"
        )
    if made.__module__ == "__main__":
        file, text, folder = extracted(place, made)
        imported = sources_below(folder, {}, {file: text})
        return f"{file}:{made.__name__}", imported
    known = packaged(made.__module__)
    if known is not None:
        path, sources = known
        return f"{path}:{made.__name__}", sources
    module = sys.modules.get(made.__module__)
    path = Path(getattr(module, "__file__", None) or "")
    if path.suffix != ".py" or any(part in INSTALLED for part in path.parts):
        raise OwnError(
            f"{place}: found {made.__qualname__} of {made.__module__}, which is no local file, "
            "expected an object of a class of your own"
        )
    if made.__module__.partition(".")[0] == "gyrostat":
        raise OwnError(
            f"{place}: found a class of gyrostat, expected a class of yours, or a kind by its name"
        )
    depth = made.__module__.count(".") + (path.name == "__init__.py")
    folder = path.resolve().parents[depth]
    inside = path.resolve().relative_to(folder).as_posix()
    return f"{inside}:{made.__name__}", sources_below(folder, {inside: place})
