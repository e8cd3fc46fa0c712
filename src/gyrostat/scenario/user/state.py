"""What Python code keeps outside its arguments: globals, class attributes, closures."""

import inspect
import random
import sys
from collections.abc import Iterator
from functools import partial
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from gyrostat.core.jax64 import Tracer, jax

DEEPEST = 8
"""Largest depth of nested objects that are looked into."""
LARGEST = 10_000
"""Largest number of entries of a container that is looked into."""
MOST_ELEMENTS = 100_000
"""Largest number of compared elements of an array; of a larger one, equally spaced ones."""
SHARED = "the random generators of numpy and random"
"""Name of the state of the generators that all modules share."""
_NUMBERS = (str, bytes, bool, int, float, complex, type(None))


def state_of(package: str) -> dict[str, Any]:
    """Name of each global of a user's modules -> its content, which can be compared.

    The states of the shared random generators of NumPy and Python are among them.

    Args:
        package: Name of the private package of the modules.
    """
    contents = {
        name: content(value, package)
        for module in _modules(package)
        for name, value in vars(module).items()
        if not name.startswith("__") and not isinstance(value, ModuleType)
    }
    generators = np.random.get_state(legacy=False), random.getstate()
    return contents | {SHARED: repr(generators)}


def kept_tracers(package: str) -> tuple[str, ...]:
    """Names of the globals of a user's modules that contain values of a trace."""
    return tuple(
        name
        for module in _modules(package)
        for name, value in vars(module).items()
        if not isinstance(value, ModuleType) and _has_tracer(value, package)
    )


def content(value: Any, package: str) -> Any:
    """Content of any object, which can be compared; of a value of a trace, its shape and type.

    Args:
        value: Object.
        package: Name of the private package whose classes and functions are looked into.
    """
    return _content(value, package, 0, frozenset())


def _content(value: Any, package: str, depth: int, outer: frozenset[int]) -> Any:
    if isinstance(value, _NUMBERS):
        return type(value).__name__, repr(value)
    if isinstance(value, Tracer):
        return "value of a trace", str(value.aval)
    if isinstance(value, np.ndarray | np.generic):
        plain = np.asarray(value)
        if plain.size > MOST_ELEMENTS:
            plain = plain.ravel()[:: plain.size // MOST_ELEMENTS]
        return str(plain.dtype), plain.shape, plain.tobytes() if plain.dtype != object else None
    if isinstance(value, np.random.Generator):
        return repr(value.bit_generator.state)
    if isinstance(value, np.random.RandomState):
        return repr(value.get_state())
    if isinstance(value, jax.Array):
        return str(value.dtype), value.shape, repr(value)
    if depth > DEEPEST or id(value) in outer:
        return type(value).__qualname__
    inner = ((key, part) for key, part in _parts(value, package))
    ids = outer | {id(value)}
    parts = [(key, _content(part, package, depth + 1, ids)) for key, part in inner]
    if isinstance(value, set | frozenset):
        parts.sort(key=repr)
    # counters of itertools show their state
    label = repr(value) if type(value).__module__ == "itertools" else type(value).__qualname__
    return label, tuple(parts)


def _has_tracer(
    value: Any, package: str, depth: int = 0, outer: frozenset[int] = frozenset()
) -> bool:
    if isinstance(value, Tracer):
        return True
    if isinstance(value, (*_NUMBERS, np.ndarray)) or depth > DEEPEST or id(value) in outer:
        return False
    ids = outer | {id(value)}
    return any(_has_tracer(part, package, depth + 1, ids) for _, part in _parts(value, package))


def _parts(value: Any, package: str) -> Iterator[tuple[str, Any]]:
    """Objects that an object keeps, with their names in it."""
    if isinstance(value, dict):
        if len(value) <= LARGEST:
            yield from ((repr(key)[:80], part) for key, part in list(value.items()))
    elif isinstance(value, list | tuple | set | frozenset):
        if len(value) <= LARGEST:
            yield from (("", part) for part in list(value))
    elif isinstance(value, partial):
        yield from (("function", value.func), ("", value.args), ("", value.keywords))
    elif inspect.ismethod(value):
        yield from (("function", value.__func__), ("self", value.__self__))
    elif isinstance(value, FunctionType):
        if _is_in(value.__module__, package):
            yield "attributes", vars(value)
            yield "defaults", (value.__defaults__, value.__kwdefaults__)
            names = value.__code__.co_freevars
            for name, cell in zip(names, value.__closure__ or (), strict=False):
                try:
                    yield name, cell.cell_contents
                except ValueError:  # assigned later
                    continue
    elif inspect.isclass(value):
        if _is_in(value.__module__, package):
            public = [n for n in vars(value) if not n.startswith(("__", "_abc_"))]
            yield from ((name, vars(value)[name]) for name in public)
    elif _is_in(type(value).__module__, package):
        yield from vars(value).items() if hasattr(value, "__dict__") else ()


def _is_in(module: Any, package: str) -> bool:
    return str(module).partition(".")[0] == package


def _modules(package: str) -> list[ModuleType]:
    # a session has thousands of modules: most are excluded by the first test
    return [
        module
        for name, module in list(sys.modules.items())
        if name.startswith(package) and _is_in(name, package)
    ]
