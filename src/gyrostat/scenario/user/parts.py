"""Own parts: components from a user's Python file.

The fields of a class are its keys, and are given by their names. Some names are reserved for what a
part is given in a run: see `RESERVED`.
"""

import dataclasses
import inspect
import typing
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import Any, Self

import equinox as eqx
import numpy as np

from gyrostat.core.any_unit import ANY_UNIT
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import SI_UNIT
from gyrostat.core.user_errors import UserPartError, reported
from gyrostat.core.user_modules import load, package_of
from gyrostat.scenario.component import Options
from gyrostat.scenario.scenario import Source
from gyrostat.scenario.schema import Key

TAKEN = ("kind", "python", "data", "target", "name")
"""Keys of the tables of a scenario file, which no field can have as its name."""
DIMENSION_OF = {unit: dimension for dimension, unit in SI_UNIT.items()}
"""SI unit -> its dimension: a key in N·m accepts a text with any unit of torque."""
RESERVED = ("spacecraft", "reference", "controller", "plant", "orbit")
"""Fields that a part is given: the nominal spacecraft as the controller knows it, the reference,
the wrapped controller of a compensator or an estimator, the plant of a sensor, the orbit."""


@dataclass(frozen=True)
class UserPart:
    """Class or function of a user's Python file.

    Attributes:
        name: Section and kind, for messages: "controller mission.py:EarthPointer".
        made: The class or function.
        fields: Names of the fields of the class; empty for a function.
        keys: Keys of its numbers.
    """

    name: str
    made: Any
    fields: tuple[str, ...]
    keys: Mapping[str, Key]

    def build(self, options: Options, **given: Any) -> Any:
        """Instance of the class; or the function, as a tree without leaves.

        Args:
            options: Values of its keys, SI.
            given: Values of reserved fields; those that the class does not have are not used.
        """
        if not inspect.isclass(self.made):
            return jax.tree_util.Partial(self.made)
        numbers = {name: jnp.asarray(options[name], dtype=float) for name in self.keys}
        with reported(self.name, self.made.__module__):
            return self.made(**numbers, **{n: v for n, v in given.items() if n in self.fields})

    def refuse(self, found: str, expected: str) -> UserPartError:
        """Error for a class that cannot be used."""
        return UserPartError(f"{self.name}: found {found}, expected {expected}")

    def with_methods(self, **methods: str) -> Self:
        """Return the part itself if it is a class with these methods.

        Args:
            methods: Name of a method -> its arguments and result, for the message.

        Raises:
            UserPartError: It is a function, or has no such method.
        """
        if not inspect.isclass(self.made):
            raise self.refuse("a function", "a class")
        for method, form in methods.items():
            # every class has an attribute __call__, that of its type
            if not any(method in vars(base) for base in self.made.__mro__):
                raise self.refuse(f"no method {method}", f"{method}{form}")
        return self


@lru_cache(maxsize=64)
def user_part(section: str, kind: str, sources: tuple[Source, ...]) -> UserPart:
    """Class or function of a user's Python file with its keys.

    Raises:
        InputError: It cannot be loaded, or a field of the class is not a number.
    """
    part = UserPart(f"{section} {kind}", None, (), {})
    with reported(part.name, package_of(sources)):
        definition = load(sources, kind)
    if not inspect.isclass(definition):
        if not callable(definition):
            raise part.refuse(type(definition).__name__, "a class or function")
        return replace(part, made=definition)
    tree_class = as_tree(part, definition)
    with reported(part.name):
        hints = typing.get_type_hints(tree_class, include_extras=True)
    fields = [f for f in dataclasses.fields(tree_class) if f.init and not f.metadata.get("static")]
    keys = {f.name: _key(part, f, hints[f.name]) for f in fields if f.name not in RESERVED}
    return replace(part, made=tree_class, fields=tuple(f.name for f in fields), keys=keys)


def as_tree(part: UserPart, found: type) -> type:
    """The class, with its fields as leaves of a tree for JAX.

    Raises:
        UserPartError: It is no class with fields.
    """
    if issubclass(found, eqx.Module):
        return found
    # an attribute of the class can also be one of its metaclass
    if not any("__dataclass_params__" in vars(base) for base in found.__mro__):
        if "__init__" in vars(found):
            raise part.refuse("a method __init__", "annotated fields such as `gain: float` instead")
    elif not found.__dataclass_params__.frozen:  # pyright: ignore[reportAttributeAccessIssue]
        raise part.refuse("a dataclass that can change", "@dataclass(frozen=True)")
    return _register(found)


@cache  # JAX keeps every class, and takes it once
def _register(kind: type) -> type:
    """The class as a frozen dataclass, registered as a tree once."""
    is_dataclass = any("__dataclass_params__" in vars(base) for base in kind.__mro__)
    data_class = kind if is_dataclass else dataclass(frozen=True)(kind)
    names = [field.name for field in dataclasses.fields(data_class)]
    return jax.tree_util.register_dataclass(data_class, names, [])


def _key(part: UserPart, field: Any, hint: Any) -> Key:
    """Key of a field: a number, or an array if its default or its annotation is one."""
    if field.name in TAKEN:
        raise part.refuse(f"a field {field.name}", "another name: it is a key of the section")
    default = None if field.default is dataclasses.MISSING else field.default
    if field.default_factory is not dataclasses.MISSING:
        default = field.default_factory()
    notes = [entry for entry in getattr(hint, "__metadata__", ()) if isinstance(entry, Key)]
    key = notes[0] if notes else Key(ANY_UNIT)
    key = replace(key, dimension=DIMENSION_OF.get(key.dimension, key.dimension))
    bare = typing.get_args(hint)[0] if notes else hint
    shape = (3,) if bare is Vector3 else ()
    if default is not None:
        try:
            value = np.asarray(default, dtype=float)
        except (TypeError, ValueError):
            raise part.refuse(f"{field.name} = {default!r}", "a number or an array") from None
        shape, default = value.shape, tuple(value.ravel().tolist())
        default = default if shape else default[0]
    meaning = key.meaning or f"Field of {part.name}."
    return replace(key, default=default, shape=shape, meaning=meaning)
