"""Comparison of values: numbers, texts, arrays, containers and instances."""

import inspect
import types
import typing
from collections.abc import Callable, Iterable
from pathlib import PurePath
from typing import Any, Protocol

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.local_modules import is_local
from gyrostat.core.random_keys import is_random_key
from gyrostat.scenario_files.python.difference import DifferentError, Place, shown
from gyrostat.scenario_files.python.literals import LARGEST

PLAIN = (bool, int, float, complex, bytes, type(None), type(...), type(NotImplemented), range)
CONTAINERS = (tuple, list, dict, set, frozenset)
NAMES = ("__module__", "__name__", "__qualname__", "__doc__", "__annotations__")
"""Attributes that a wrapper copies from a function; they do not change what it does."""
Rule = Callable[["Comparer", Place, Any, Any], None]


class Comparer(Protocol):
    """Comparison that these rules are part of."""

    def compare(self, place: Place, live: Any, loaded: Any) -> None:
        """Compare two objects; raises `DifferentError`."""
        ...

    def text(self, live: str) -> str:
        """Text in another process for a text in memory: names of modules and paths differ."""
        ...


def rule_of(value: Any) -> Rule:
    """Rule for a value whose type is the same in memory and from the text."""
    for kind, rule in _RULES:
        if isinstance(value, kind):
            return rule
    return _instance


def refuse_unequal(place: Place, live: Any, loaded: Any, *, equal: bool) -> None:
    """Raise `DifferentError` unless two values are equal."""
    if not equal:
        left, right = shown(live), shown(loaded)
        raise DifferentError(place, left, f"another {right}" if left == right else right)


def _plain(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    # repr is exact, and tells 0.0 from -0.0
    refuse_unequal(place, live, loaded, equal=repr(live) == repr(loaded))


def _text(comparer: Comparer, place: Place, live: str, loaded: str) -> None:
    equal = str.__eq__(live, loaded) or comparer.text(str(live)) == str(loaded)
    refuse_unequal(place, live, loaded, equal=equal)


def _path(comparer: Comparer, place: Place, live: PurePath, loaded: PurePath) -> None:
    _text(comparer, place, str(live), str(loaded))


def _array(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    if is_random_key(live):
        live, loaded = jax.random.key_data(live), jax.random.key_data(loaded)
    alike = (live.dtype, live.shape) == (loaded.dtype, loaded.shape)
    alike &= getattr(live, "weak_type", False) == getattr(loaded, "weak_type", False)
    left, right = np.asarray(live), np.asarray(loaded)
    if alike and left.dtype.hasobject:
        comparer.compare(place, left.tolist(), right.tolist())
        return
    if not alike:
        raise DifferentError(
            place, *(f"an array {each.dtype}{each.shape}" for each in (left, right))
        )
    if left.tobytes() != right.tobytes():
        limit = f" (of more than {LARGEST} numbers, the statement is copied and not the numbers)"
        first = f"an array {left.dtype}{left.shape}{limit if left.size > LARGEST else ''}"
        raise DifferentError(place, first, "other numbers")


def _sequence(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    live_elements, loaded_elements = list(_elements(live)), list(_elements(loaded))
    if len(live_elements) != len(loaded_elements):
        raise DifferentError(place, f"{len(live_elements)} elements", f"{len(loaded_elements)}")
    for k, pair in enumerate(zip(live_elements, loaded_elements, strict=True)):
        comparer.compare(place.inside(f"[{k}]"), *pair)
    _state(comparer, place, live, loaded)


def _elements(value: Iterable[Any]) -> Iterable[Any]:
    if isinstance(value, tuple):
        return tuple.__iter__(value)
    return list.__iter__(value) if isinstance(value, list) else value


def _set(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    comparer.compare(place, sorted(live, key=repr), sorted(loaded, key=repr))
    _state(comparer, place, live, loaded)


def _mapping(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    pairs = list(dict.items(live)), list(dict.items(loaded))
    if [str(key) for key, _ in pairs[0]] != [str(key) for key, _ in pairs[1]]:
        raise DifferentError(place, f"the keys {[*live]}"[:60], f"{[*loaded]}"[:60])
    for (key, entry), (loaded_key, loaded_entry) in zip(*pairs, strict=True):
        comparer.compare(place.inside(f" key {key!r}"), key, loaded_key)
        comparer.compare(place.inside(f"[{key!r}]"), entry, loaded_entry)
    _state(comparer, place, live, loaded)


def _proxy(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    comparer.compare(place, dict(live), dict(loaded))


def _signature(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    def parameters(each: inspect.Signature) -> list[Any]:
        return [(p.name, p.kind.name, p.default) for p in each.parameters.values()]

    comparer.compare(place, parameters(live), parameters(loaded))


def _tree(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    """Structures of trees, which can name a user's class."""
    comparer.compare(place, live.node_data(), loaded.node_data())
    comparer.compare(place, live.children(), loaded.children())


def _type_variable(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    for name in ("__name__", "__bound__", "__constraints__"):
        comparer.compare(place, getattr(live, name), getattr(loaded, name))


def _slot(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    """Descriptors of slots: the names in `__slots__` say all about them."""
    comparer.compare(place, live.__name__, loaded.__name__)


_RULES: tuple[tuple[Any, Rule], ...] = (
    (PLAIN, _plain),
    (str, _text),
    (PurePath, _path),
    ((np.ndarray, np.generic, jax.Array), _array),
    ((tuple, list), _sequence),
    ((set, frozenset), _set),
    (dict, _mapping),
    (types.MappingProxyType, _proxy),
    (inspect.Signature, _signature),
    (jax.tree_util.PyTreeDef, _tree),
    ((typing.TypeVar, typing.ParamSpec), _type_variable),
    ((types.MemberDescriptorType, types.GetSetDescriptorType), _slot),
)
"""Kind of a value -> its rule; the first that fits holds."""


def _instance(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    """Instances: by their fields; those of a library by what they give to be copied."""
    if not is_local(type(live).__module__):
        live_parts, loaded_parts = _reduction(live), _reduction(loaded)
        if live_parts is not None and loaded_parts is not None:
            comparer.compare(place, live_parts, loaded_parts)
            return
    if _is_compiled(type(live)):
        raise DifferentError(place, shown(live), "it is not known whether it is the same")
    _state(comparer, place, live, loaded)


def _reduction(value: Any) -> tuple[Any, ...] | None:
    """What a value gives to be copied: function, arguments, state, elements; None: nothing."""
    try:
        reduction = value.__reduce_ex__(4)
    except Exception:
        return None
    if not isinstance(reduction, tuple):
        return None
    parts: Any = (*reduction, None, None, None)[:5]
    make, arguments, state, *elements = parts
    if isinstance(state, dict):
        state = {name: entry for name, entry in state.items() if name not in NAMES}
    return make, arguments, state, *(each and list(each) for each in elements)


def _is_compiled(kind: type) -> bool:
    """Whether instances have a state that Python does not show."""
    plain_kinds = (object, *CONTAINERS, *PLAIN[:4], bytes, str)
    return any(base not in plain_kinds and _is_in_c(base) for base in kind.__mro__)


def _is_in_c(kind: type) -> bool:
    """Whether a class has methods of its own in C; classes of extensions can be heap types."""
    return any(
        (
            isinstance(entry, types.WrapperDescriptorType | types.MethodDescriptorType)
            and entry.__objclass__ is kind
        )
        or (isinstance(entry, types.BuiltinFunctionType) and entry.__self__ is kind)
        for entry in vars(kind).values()
    )


def _state(comparer: Comparer, place: Place, live: Any, loaded: Any) -> None:
    """Attributes of instances."""
    for name in sorted({*_fields(live), *_fields(loaded)}):
        left, right = (_fields(each).get(name, _NONE) for each in (live, loaded))
        if left is not _NONE and right is not _NONE:
            comparer.compare(place.inside(f".{name}"), left, right)
        elif left is not right:
            raise DifferentError(
                place.inside(f".{name}"),
                *("nothing" if each is _NONE else shown(each) for each in (left, right)),
            )


_NONE: Any = object()
"""Attribute that an instance does not have."""


def _fields(value: Any) -> dict[str, Any]:
    """Attributes of an instance, in its dictionary and its slots."""
    fields = dict(getattr(value, "__dict__", {}))
    for base in type(value).__mro__:
        slots = vars(base).get("__slots__", ())
        for slot in (slots,) if isinstance(slots, str) else slots:
            descriptor = vars(base).get(slot)
            if isinstance(descriptor, types.MemberDescriptorType):
                try:
                    fields[slot] = descriptor.__get__(value)
                except AttributeError:
                    fields[slot] = _NONE
    return fields
