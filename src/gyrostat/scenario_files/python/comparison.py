"""Comparison of a user's objects in memory with those of the text that other processes run.

Both are followed all the way down: code, default values, closures, class attributes, decorated
objects, and the values of the global names that the code refers to. An object of a kind that is
not known counts as different.
"""

import builtins
import dataclasses
import functools
import sys
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from gyrostat.core.file_readers import real
from gyrostat.core.jax64 import jax
from gyrostat.core.local_modules import is_local
from gyrostat.scenario_files.python.code_equality import EVALUATING, READING, names_of, same_code
from gyrostat.scenario_files.python.difference import DifferentError, PatchedError, Place, shown
from gyrostat.scenario_files.python.equal_values import rule_of
from gyrostat.scenario_files.python.library_names import is_original, is_original_builtin

_OF_CLASS = frozenset(
    {
        *("__module__", "__qualname__", "__doc__", "__dict__", "__weakref__", "_abc_impl"),
        *("__annotations__", "__annotate__", "__annotate_func__", "__annotations_cache__"),
        *("__firstlineno__", "__static_attributes__"),
    }
)
"""Attributes of a class that do not change what it does, or that are compared by themselves."""
_OF_FUNCTION = frozenset(
    {
        *("__module__", "__qualname__", "__name__", "__doc__", "__annotations__"),
        *("__type_params__", "_fun", "_jit_info"),
    }
)
"""Attributes of a function that do not change what it does, or that are compared by themselves."""
_OF_MODULE = frozenset(
    {*("__name__", "__package__", "__spec__", "__loader__", "__builtins__", "__path__", "__doc__")}
)
_PARTS: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (types.MethodType, ("__func__", "__self__")),
    ((staticmethod, classmethod), ("__func__",)),
    (property, ("fget", "fset", "fdel")),
    (functools.partial, ("func", "args", "keywords", "__dict__")),
    (functools.partialmethod, ("func", "args", "keywords")),
    (functools.cached_property, ("func", "attrname")),
    (functools._lru_cache_wrapper, ("__wrapped__",)),
    (types.BuiltinFunctionType, ("__name__", "__self__")),
    (types.CellType, ("cell_contents",)),
    (Enum, ("name", "value")),
    # the annotation of a field is compared with those of its class
    (dataclasses.Field, ("name", "default", "default_factory", "init", "kw_only", "metadata")),
    (type(jax.jit(lambda: None)), ("__wrapped__",)),
)
"""Kinds of wrappers and records -> the parts that determine what they do."""
_OF_DISPATCH = ("cache_token", "dispatch_cache")
"""What functools.singledispatch keeps of earlier calls."""
_NOTHING = "nothing"


@dataclass
class Comparison:
    """Comparison of objects in memory with those of a text.

    Attributes:
        texts: Name of a module or path in memory -> the one of another process.
    """

    texts: Mapping[str, str]
    _pairs: dict[tuple[int, int], tuple[Any, Any]] = field(default_factory=dict)
    _mentioned: set[str] = field(default_factory=set)
    _modules: list[tuple[Place, Any, Any]] = field(default_factory=list)

    def require_equal(self, name: str, live: Any, loaded: Any) -> None:
        """Compare a class or function in memory with the one from its text.

        Raises:
            DifferentError: They differ, or it is not known whether they do.
        """
        self.compare(Place(name, (name,)), live, loaded)
        count = -1
        while count != len(self._mentioned) + len(self._modules):  # modules lead to further code
            count = len(self._mentioned) + len(self._modules)
            for place, live_module, loaded_module in list(self._modules):
                self._module(place, live_module, loaded_module)

    def text(self, live: str) -> str:
        """Text in another process for a text in memory: names of modules and paths differ."""
        for name, replacement in self.texts.items():
            if live == name or live.startswith((f"{name}/", f"{name}.")):
                return replacement + live[len(name) :]
        return live

    def compare(self, place: Place, live: Any, loaded: Any) -> None:
        """Compare two objects; raises `DifferentError`."""
        live, loaded = real(live), real(loaded)
        pair = id(live), id(loaded)
        if pair in self._pairs:
            return
        self._pairs[pair] = live, loaded  # keeps both, so that no other object gets their numbers
        if isinstance(live, types.ModuleType) and isinstance(loaded, types.ModuleType):
            self._modules.append((place, live, loaded))
        elif live is loaded:
            self._check_shared(place, live)
        elif isinstance(live, type) and isinstance(loaded, type):
            self._class(place, live, loaded)
        elif type(live) is not type(loaded) and not self._compare_classes(place, live, loaded):
            raise DifferentError(place, shown(live), shown(loaded))
        elif isinstance(live, types.FunctionType):
            self._function(place, live, loaded)
        elif not self._wrapper(place, live, loaded):
            rule_of(live)(self, place, live, loaded)

    def _compare_classes(self, place: Place, live: Any, loaded: Any) -> bool:
        if not is_local(type(live).__module__) and not is_local(type(loaded).__module__):
            return False
        self.compare(place.inside(".__class__"), type(live), type(loaded))
        return True

    def _wrapper(self, place: Place, live: Any, loaded: Any) -> bool:
        """Compare what a wrapper contains; returns whether it is one."""
        for kind, parts in _PARTS:
            if isinstance(live, kind):
                for part in parts:
                    inner = place if part == "__wrapped__" else place.inside(f".{part}")
                    self.compare(inner, *(getattr(each, part, None) for each in (live, loaded)))
                for part in ("cache_parameters", "_jit_info"):
                    options = (_options(each, part) for each in (live, loaded))
                    self.compare(place.inside(".options"), *options)
                return True
        return False

    def _check_shared(self, place: Place, value: Any) -> None:
        """Check an object that is in memory once: other processes have their own."""
        kind = value if isinstance(value, type) else type(value)
        scope = getattr(value, "__globals__", {}).get("__name__")
        if is_local(kind.__module__) or is_local(scope):
            raise DifferentError(place, shown(value), "nothing: other processes do not have it")
        if isinstance(value, type):
            for base in value.__mro__:
                for name, entry in vars(base).items():
                    self._refuse_patch(place.inside(f".{name}"), entry)

    def _refuse_patch(self, place: Place, value: Any) -> None:
        """Refuse a function or class of the user in a place of a library."""
        inner = getattr(value, "__func__", value)
        scope = getattr(inner, "__globals__", {}).get("__name__")
        if is_local(scope) or (isinstance(inner, type) and is_local(inner.__module__)):
            raise PatchedError(place, f"{shown(inner)} of {scope or inner.__module__}")

    def library_name(self, place: Place, module: types.ModuleType, name: str) -> None:
        """Check that a name of a library has the value that other processes find there.

        Raises:
            DifferentError: It was set from outside.
        """
        value = vars(module)[name]
        if isinstance(value, types.ModuleType):
            self.compare(place, value, value)
            return
        self._refuse_patch(place, value)
        if not is_original(module, name):
            raise PatchedError(place, shown(value))

    def _builtin(self, place: Place, name: str) -> None:
        """Check that a built-in name has the value that other processes find there."""
        value = getattr(builtins, name, None)
        self._refuse_patch(place, value)
        if not is_original_builtin(name):
            raise PatchedError(place, shown(value))

    def _class(self, place: Place, live: type, loaded: type) -> None:
        if live.__qualname__ != loaded.__qualname__:
            raise DifferentError(place, shown(live), shown(loaded))
        self.compare(place.inside(".__class__"), type(live), type(loaded))
        if len(live.__bases__) != len(loaded.__bases__):
            raise DifferentError(
                place.inside(".__bases__"), f"{live.__bases__}", f"{loaded.__bases__}"
            )
        for pair in zip(live.__bases__, loaded.__bases__, strict=True):
            self.compare(place.inside(f" base {pair[0].__name__}"), *pair)
        parts = [
            {k: v for k, v in vars(each).items() if k not in _OF_CLASS} for each in (live, loaded)
        ]
        self._entries(place, *parts)
        hints = [_hints(each) for each in (live, loaded)]
        if list(hints[0]) != list(hints[1]):
            raise DifferentError(place, f"the fields {', '.join(hints[0])}", ", ".join(hints[1]))
        self._entries(place.inside(" annotation"), *hints)

    def _entries(self, place: Place, live: Mapping[str, Any], loaded: Mapping[str, Any]) -> None:
        for name in sorted({*live, *loaded}):
            inner = place.inside(f".{name}")
            if name not in live or name not in loaded:
                texts = (shown(e[name]) if name in e else _NOTHING for e in (live, loaded))
                raise DifferentError(inner, *texts)
            self.compare(inner, live[name], loaded[name])

    def _function(self, place: Place, live: Any, loaded: Any) -> None:
        if not same_code(live.__code__, loaded.__code__):
            raise DifferentError(
                place, f"the code of line {live.__code__.co_firstlineno}", "other code"
            )
        if hasattr(live, "registry") and hasattr(loaded, "registry"):
            self.compare(place.inside(".registry"), live.registry, loaded.registry)
        for part in ("__defaults__", "__kwdefaults__"):
            self.compare(place.inside(f".{part}"), getattr(live, part), getattr(loaded, part))
        cells = zip(
            live.__code__.co_freevars, live.__closure__ or (), loaded.__closure__ or (), strict=True
        )
        for name, live_cell, loaded_cell in cells:
            if live.__module__ == "functools" and name in _OF_DISPATCH:
                continue
            self.compare(place.inside(f" with {name}"), *map(_content, (live_cell, loaded_cell)))
        parts = [
            {k: v for k, v in vars(f).items() if k not in _OF_FUNCTION} for f in (live, loaded)
        ]
        self._entries(place, *parts)
        if live.__globals__ is not loaded.__globals__:
            self._globals(place, live, loaded)
        elif is_local(live.__globals__.get("__name__")):
            raise DifferentError(place, shown(live), "nothing: other processes do not have it")

    def _globals(self, place: Place, live: Any, loaded: Any) -> None:
        """Values of the global names that a function refers to."""
        names, scopes = names_of(live.__code__), (live.__globals__, loaded.__globals__)
        self._mentioned |= names.mentioned
        global_names = set(names.global_names)
        if not EVALUATING.isdisjoint(names.mentioned):
            global_names |= {name for name in names.mentioned if name in scopes[0]} - _OF_MODULE
        if "__main__" in names.mentioned:
            raise DifferentError(
                place, "a use of __main__", "nothing: other processes have another"
            )
        for name in sorted(global_names - {"__name__"}):
            values = [scope.get(name, _NOTHING) for scope in scopes]
            missing = [value is _NOTHING for value in values]
            if all(missing):
                self._builtin(place.used(name), name)
            elif any(missing):
                texts = (each if each is _NOTHING else shown(each) for each in values)
                raise DifferentError(place.used(name), *texts)
            else:
                self.compare(place.used(name), *values)
        for name in sorted(names.imports):
            live_module, loaded_module = sys.modules.get(name), sys.modules.get(self.text(name))
            if live_module is not None and loaded_module is not None:
                self.compare(place.used(name), live_module, loaded_module)

    def _module(self, place: Place, live: Any, loaded: Any) -> None:
        """Compare the attributes of a module that code mentions."""
        if live is loaded and is_local(live):
            raise DifferentError(
                place, f"the module {live.__name__}", "nothing: it is not part of the scenario"
            )
        compares_all = live is not loaded and not READING.isdisjoint(self._mentioned)
        names = {*vars(live), *vars(loaded)} - _OF_MODULE
        for name in sorted(names if compares_all else names & self._mentioned):
            live_value, loaded_value = (vars(e).get(name, _NOTHING) for e in (live, loaded))
            if live is loaded:
                self.library_name(place.inside(f".{name}"), live, name)
            elif (
                isinstance(live_value, types.ModuleType)
                and live_value.__name__.startswith(f"{live.__name__}.")
                and loaded_value is _NOTHING
            ):
                continue  # a module below it, imported elsewhere
            else:
                values = (live_value, loaded_value)
                self._entries(place, *({} if e is _NOTHING else {name: e} for e in values))


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # the name has no value yet
        return None


def _options(value: Any, part: str) -> Any:
    """Options of a cached or compiled function."""
    info = getattr(value, part, None)
    if callable(info):
        return info()
    return tuple(repr(getattr(info, name, None)) for name in ("static_argnums", "static_argnames"))


def _hints(kind: type) -> dict[str, Any]:
    """Annotations of the fields of a class, without those of its bases."""
    names = vars(kind).get("__annotations__", {})
    try:
        hints = typing.get_type_hints(kind, include_extras=True)
    except Exception:
        return dict(names)
    return {name: hints.get(name) for name in names}
