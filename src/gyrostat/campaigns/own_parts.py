"""Own parts: components from a user's Python file.

The fields of a class are its keys, and are given by their names. Some names are reserved for what a
part is given in a run: see `RESERVED`.
"""

import dataclasses
import inspect
import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.campaigns.components import Component, Options, stacked
from gyrostat.campaigns.controllers import IGNORED, DesignCase, PlannedController
from gyrostat.campaigns.own_control import OwnControl
from gyrostat.campaigns.scenario import Source
from gyrostat.campaigns.schema import Key
from gyrostat.campaigns.sources import load
from gyrostat.core.arrays import Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

RESERVED = ("spacecraft", "reference", "controller", "plant")
"""Fields that a part is given: the nominal spacecraft as the controller knows it, the reference,
the wrapped controller of a compensator or an estimator, the plant of a sensor."""


@dataclass(frozen=True)
class OwnPart:
    """Class or function of a user's Python file.

    Attributes:
        kind: "FILE.py:NAME".
        made: The class or function.
        fields: Names of the fields of the class; empty for a function.
        keys: Keys of its numbers.
    """

    kind: str
    made: Any
    fields: tuple[str, ...]
    keys: Mapping[str, Key]

    def build(self, options: Options, **given: Any) -> Any:
        """Instance of the class; a function as it is.

        Args:
            options: Values of its keys, SI.
            given: Values of reserved fields; those that the class does not have are not used.
        """
        if not inspect.isclass(self.made):
            return self.made
        numbers = {
            name: stacked(options, name) if key.size == 3 else jnp.asarray(options[name], float)
            for name, key in self.keys.items()
        }
        return self.made(**numbers, **{n: v for n, v in given.items() if n in self.fields})


def is_own(kind: str) -> bool:
    """Whether a kind names a class or function of a user's Python file."""
    return ":" in kind


@lru_cache(maxsize=64)
def own_part(kind: str, sources: tuple[Source, ...]) -> OwnPart:
    """Class or function of a user's Python file with its keys.

    Raises:
        InputError: It cannot be loaded, or a field of the class is not a number.
    """
    found = load(sources, kind)
    if not inspect.isclass(found):
        if not callable(found):
            raise InputError(f"{kind}: found {type(found).__name__}, expected a class or function")
        return OwnPart(kind, found, (), {})
    made = _as_module(kind, found)
    hints = typing.get_type_hints(made, include_extras=True)
    fields = [field for field in dataclasses.fields(made) if field.init]
    keys = {
        field.name: _key(kind, field, hints[field.name])
        for field in fields
        if field.name not in RESERVED
    }
    return OwnPart(kind, made, tuple(field.name for field in fields), keys)


def _as_module(kind: str, found: type) -> type:
    """The class, with its fields as leaves of a tree for JAX."""
    if issubclass(found, eqx.Module):
        return found
    if not dataclasses.is_dataclass(found):
        if "__init__" in vars(found):
            raise InputError(
                f"{kind}: found its own __init__, expected annotated fields such as `gain: float`"
            )
        found = dataclass(frozen=True)(found)
    if not found.__dataclass_params__.frozen:  # pyright: ignore[reportAttributeAccessIssue]
        raise InputError(f"{kind}: found a dataclass, expected @dataclass(frozen=True)")
    names = [field.name for field in dataclasses.fields(found)]
    return jax.tree_util.register_dataclass(found, names, [])


def _key(kind: str, field: Any, hint: Any) -> Key:
    """Key of a field: a number, or a vector if its default or its annotation is one."""
    default = None if field.default is dataclasses.MISSING else field.default
    if field.default_factory is not dataclasses.MISSING:
        default = field.default_factory()
    own = [entry for entry in getattr(hint, "__metadata__", ()) if isinstance(entry, Key)]
    key = own[0] if own else Key("1", None, f"Field of {kind}.")
    try:
        value = None if default is None else np.asarray(default, dtype=float)
    except (TypeError, ValueError):
        value = np.zeros(0)
    bare = typing.get_args(hint)[0] if own else hint
    shape = ((3,) if bare is Vector3 else ()) if value is None else value.shape
    if shape not in ((), (3,)):
        raise InputError(
            f"{kind}: found field {field.name} = {default!r}, expected a number or three numbers"
        )
    return dataclasses.replace(
        key,
        default=None if value is None else float(value.flat[0]),
        size=3 if shape == (3,) else 1,
    )


def _controller(part: OwnPart) -> PlannedController:
    def plan(case: DesignCase) -> Any:
        return case.spacecraft

    def make(plan: Any, options: Options, momentum: Vector3) -> OwnControl:
        return OwnControl(part.build(options, spacecraft=plan, reference=None), part.kind)

    return PlannedController(f"Class of {part.kind}.", part.keys, make, plan, IGNORED)


def _compensator(part: OwnPart) -> Component:
    def make(options: Options, controller: Any, known: Any, delay: int) -> OwnControl:
        made = part.build(options, controller=controller, spacecraft=known)
        return OwnControl(made, part.kind)

    return Component(f"Class of {part.kind}.", part.keys, make)


def _estimator(part: OwnPart) -> Component:
    def make(options: Options, controller: Any, known: Any, sensors: Options) -> OwnControl:
        made = part.build(options, controller=controller, spacecraft=known)
        return OwnControl(made, part.kind)

    return Component(f"Class of {part.kind}.", part.keys, make)


OWN: dict[str, Callable[[OwnPart], Any]] = {
    "controller": _controller,
    "compensator": _compensator,
    "estimator": _estimator,
}
"""Section of a scenario -> function that makes the component of an own part."""


@lru_cache(maxsize=64)
def own_component(section: str, kind: str, sources: tuple[Source, ...]) -> Any:
    """Component of a section from a user's Python file.

    Raises:
        InputError: See `own_part`.
    """
    return OWN[section](own_part(kind, sources))
