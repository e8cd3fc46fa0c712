"""Compiled functions of trees of parts, whose machine code is kept in the private cache."""

import dataclasses
import sys
from collections.abc import Callable
from enum import Enum
from functools import wraps
from operator import attrgetter
from types import FunctionType
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.random_keys import is_random_key
from gyrostat.core.stored_function import stored_function

_MOST = 32
"""Largest number of programs of a function that a process keeps."""


def stored_tree_function(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of trees, as `eqx.filter_jit` does; its machine code outlives the process.

    Arrays are arguments of the program. Everything else determines it: classes and names of fields,
    numbers of Python, texts, functions. It is part of the name of the entry. With an object, class
    or function that is not of this package, whose code the name does not cover, the program is
    compiled by `eqx.filter_jit` and not kept.

    Args:
        function: Function of a module of this package; returns a tree of arrays.
    """
    compiled = eqx.filter_jit(function)
    name = f"{function.__module__}.{function.__qualname__}"
    programs: dict[str, Callable[..., Any]] = {}

    @wraps(function)
    def call(*trees: Any) -> Any:
        about = structure_text(trees)
        if about is None:
            return compiled(*trees)
        leaves, tree = jax.tree.flatten(trees)
        if about not in programs:
            if len(programs) >= _MOST:
                del programs[next(iter(programs))]
            static = [None if _is_array(leaf) else leaf for leaf in leaves]
            kinds = [jax.random.key_impl(leaf) if is_random_key(leaf) else None for leaf in leaves]

            def flat(*arrays: Any) -> Any:
                data, values = iter(arrays), []
                for leaf, kind in zip(static, kinds, strict=True):
                    values.append(next(data) if leaf is None else leaf)
                    if kind is not None:
                        values[-1] = jax.random.wrap_key_data(values[-1], impl=kind)
                return function(*jax.tree.unflatten(tree, values))

            programs[about] = stored_function(flat, name, about)
        arrays = (leaf for leaf in leaves if _is_array(leaf))
        return programs[about](*(jax.random.key_data(a) if is_random_key(a) else a for a in arrays))

    return call


def structure_text(value: Any, *, is_data: bool = True) -> str | None:
    """Describe everything in a tree but the values of its arrays.

    Two trees with the same text have the same program for arrays of the same shapes and types.

    Args:
        value: The tree.
        is_data: Whether arrays are data; in a field that JAX takes as static they are not.

    Returns:
        The text; None if an object, class or function in the tree is not of this package.
    """
    try:
        return _describe(value, is_data)
    except _UserCodeError:
        return None


class _UserCodeError(Exception):
    """The tree contains something that is not of this package."""


def _describe(value: Any, is_data: bool) -> str:
    kind = type(value)
    if value is None or kind in (bool, int, float, str):
        return f"{kind.__name__} {value!r}"
    if is_data and _is_array(value):
        return f"key {jax.random.key_impl(value)}" if is_random_key(value) else "array"
    if kind in (tuple, list):
        return f"{kind.__name__} [{', '.join(_describe(each, is_data) for each in value)}]"
    if kind is dict:
        parts = (f"{_describe(k, False)}: {_describe(v, is_data)}" for k, v in value.items())
        return f"dict {{{', '.join(parts)}}}"
    if isinstance(value, type | FunctionType):
        return f"object {_qualified_name(value)}"
    if isinstance(value, Enum):
        return f"{_qualified_name(kind)} {value.name}"
    if isinstance(value, eqx.Module):
        parts = (
            f"{each.name}="
            + _describe(
                getattr(value, each.name), is_data and not each.metadata.get("static", False)
            )
            for each in dataclasses.fields(value)
        )
        return f"{_qualified_name(kind)}({', '.join(parts)})"
    if isinstance(value, tuple) and hasattr(kind, "_fields"):
        return f"{_qualified_name(kind)}({', '.join(_describe(each, is_data) for each in value)})"
    raise _UserCodeError


def _qualified_name(value: Any) -> str:
    """Module and name of a class or function of this package."""
    home, name = value.__module__, value.__qualname__
    if not home.startswith("gyrostat.") or "<" in name:
        raise _UserCodeError
    try:
        definition = attrgetter(name)(sys.modules[home])
    except (AttributeError, KeyError):
        definition = None
    if definition is not value:
        raise _UserCodeError
    return f"{home}.{name}"


def _is_array(leaf: Any) -> bool:
    return isinstance(leaf, jax.Array | np.ndarray | np.generic)
