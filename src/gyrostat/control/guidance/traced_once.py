"""Functions that a program traces only once."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import equinox as eqx

from gyrostat.core.jax64 import jax

Function = TypeVar("Function", bound=Callable[..., Any])


def traced_once(function: Function) -> Function:
    """Function that a program traces only where it calls it first.

    A reference is evaluated in many places of a program: this halves the time that a program with a
    sequence of modes takes to be made, and in exported C it is one function. A first argument that
    is not made of numbers only may change without notice: then it is traced in each place.

    Args:
        function: Function without side effects, or method.
    """
    traced = jax.jit(function)

    @wraps(function)
    def call(first: Any, *arguments: Any) -> Any:
        of_numbers = all(map(eqx.is_array_like, jax.tree.leaves(first)))
        return (traced if of_numbers else function)(first, *arguments)

    return cast(Function, call)
