"""Small pure functions that are traced once for each shape of their arguments."""

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

from gyrostat.core.jax64 import jax

Function = TypeVar("Function", bound=Callable[..., Any])


def traced_once(function: Function) -> Function:
    """Function whose operations are traced once, and repeated wherever a program uses it.

    The program is the same as without; it is made in less time. The function must depend on its
    arguments only, arrays all of them.
    """
    compiled = jax.jit(function, inline=True)

    @wraps(function)
    def call(*arguments: Any) -> Any:
        return compiled(*arguments)

    return cast(Function, call)
