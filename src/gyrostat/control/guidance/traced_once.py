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
    is not made of arrays and floats only is traced in each place: it may change without notice, and
    Python may need its integers and flags, for a range or an `if`.

    Args:
        function: Function without side effects, or method.
    """
    traced = jax.jit(function)

    @wraps(function)
    def call(first: Any, *arguments: Any) -> Any:
        leaves = jax.tree.leaves(first)
        of_reals = all(eqx.is_array(leaf) or isinstance(leaf, float) for leaf in leaves)
        return (traced if of_reals else function)(first, *arguments)

    return cast(Function, call)
