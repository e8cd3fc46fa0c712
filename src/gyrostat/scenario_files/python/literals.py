"""Python expressions that give a value again, exact to the last bit."""

import dataclasses
import functools
import inspect
import sys
import types
from enum import Enum
from typing import Any, Protocol

import numpy as np

from gyrostat.core.jax64 import jax

LARGEST = 100_000
"""Most numbers of an array that is copied."""
PLAIN = (bool, int, float, complex, str, bytes, type(None), type(...), range)


class NoLiteralError(Exception):
    """There is no expression for a value."""


class Module(Protocol):
    """Text of a module that is being written."""

    def import_module(self, name: str) -> None:
        """Add an import."""
        ...

    def global_name(self, value: Any) -> str | None:
        """Name of a class or function of the script, which is added; None if there is none."""
        ...


def literal(value: Any, module: Module) -> str:
    """Expression of a value: numbers, texts, arrays, containers, and instances of data classes.

    Args:
        value: Value.
        module: Module that contains the expression.

    Raises:
        NoLiteralError: There is none.
    """
    if isinstance(value, float) and not np.isfinite(value):
        return f"float({str(value)!r})"
    if type(value) in PLAIN:
        return repr(value)
    entries: Any = value
    if type(value) in (tuple, list):
        inner = "".join(f"{literal(entry, module)}, " for entry in entries)
        return f"({inner})" if isinstance(value, tuple) else f"[{inner}]"
    if type(value) is dict:
        pairs = [f"{literal(k, module)}: {literal(v, module)}" for k, v in value.items()]
        return f"{{{', '.join(pairs)}}}"
    if type(value) in (set, frozenset):
        inner = ", ".join(sorted(literal(entry, module) for entry in entries))
        return f"{type(value).__name__}(({inner},))" if value else f"{type(value).__name__}()"
    if isinstance(value, np.ndarray | np.generic | jax.Array):
        return _array(value, module)
    return _object(value, module)


def _array(value: Any, module: Module) -> str:
    """Expression of an array of numbers or texts."""
    if value.size > LARGEST or getattr(value.dtype, "kind", "?") not in "biufcU":
        raise NoLiteralError
    array = np.asarray(value)
    text = literal(array.tolist(), module)
    is_jax = isinstance(value, jax.Array)
    library = "jax.numpy" if is_jax else "numpy"
    module.import_module(library)
    if type(value) not in (np.ndarray, type(array[()])) and not is_jax:
        raise NoLiteralError
    if isinstance(value, np.generic):
        return f"numpy.dtype('{array.dtype}').type({text})"
    if is_jax and value.weak_type:
        if value.shape:
            raise NoLiteralError
        return f"jax.numpy.asarray({text})"
    return f"{library}.asarray({text}, dtype='{array.dtype}')"


def _object(value: Any, module: Module) -> str:
    """Expression of a class, a function, or an instance by its fields."""
    if isinstance(value, type | types.FunctionType):
        return _qualified_name(value, module)
    kind = type(value)
    if isinstance(value, Enum):
        return f"{_qualified_name(kind, module)}[{value.name!r}]"
    if kind is functools.partial:
        module.import_module("functools")
        arguments = [literal(each, module) for each in (value.func, *value.args)]
        arguments += [f"{name}={literal(each, module)}" for name, each in value.keywords.items()]
        return f"functools.partial({', '.join(arguments)})"
    if isinstance(value, tuple) and hasattr(kind, "_fields"):
        fields = dict(zip(kind._fields, value, strict=True))
    elif dataclasses.is_dataclass(kind):
        fields = {f.name: getattr(value, f.name, None) for f in dataclasses.fields(kind) if f.init}
    else:
        raise NoLiteralError
    name = _qualified_name(kind, module)
    return f"{name}({', '.join(f'{n}={literal(v, module)}' for n, v in fields.items())})"


def _qualified_name(value: Any, module: Module) -> str:
    """Name of a class or function, of the script or of a module that can be imported."""
    name = module.global_name(value)
    if name is not None:
        return name
    home = inspect.getmodule(value)
    target = home
    for part in value.__qualname__.split("."):
        target = getattr(target, part, None)
    if home is None or target is not value or home is sys.modules["__main__"]:
        raise NoLiteralError
    module.import_module(home.__name__)
    return (
        f"{home.__name__}.{value.__qualname__}" if home.__name__ != "builtins" else value.__name__
    )
