"""Functions that are traced once for each shape of their arguments."""

import traceback
from collections.abc import Callable
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import equinox as eqx

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import Tracer, jax

Function = TypeVar("Function", bound=Callable[..., Any])
_PACKAGE = __name__.partition(".")[0]
_ROOT = str(Path(__file__).parents[1])


def traced_once(function: Function) -> Function:
    """Function whose operations are traced once, and repeated wherever a program uses it.

    The operations are the same as without, and so is generated C; it is made in less time. The
    function must depend on its arguments only, arrays all of them.
    """
    compiled = _compiled(function)

    @wraps(function)
    def call(*arguments: Any) -> Any:
        return compiled(*arguments)

    return cast(Function, call)


def method_traced_once(method: Function) -> Function:
    """Method of a module of equinox that is traced once in a process; see `traced_once`.

    It is traced anew for an object with a part that is not of this package: a user's part may
    change without notice, and its trial counts its traces.
    """
    compiled = _compiled(method)

    @wraps(method)
    def call(self: Any, *arguments: Any) -> Any:
        leaves, tree = jax.tree.flatten(self)
        traced = all(isinstance(leaf, Tracer) for leaf in leaves)
        return (compiled if traced and _is_shipped(tree) else method)(self, *arguments)

    return cast(Function, call)


def one_function(function: Function) -> Function:
    """Function, or method, that is traced once in a program, and is one function in generated C.

    A reference is evaluated in many places of a program. A first argument that is not made of
    arrays and floats only is traced in each place: it may change without notice, and Python may
    need its integers and flags, for a range or an `if`.

    Args:
        function: Function without side effects, or method.
    """
    traced = jax.jit(function)

    @wraps(function)
    def call(first: Any, *arguments: Any) -> Any:
        leaves = jax.tree.leaves(first)
        of_reals = all(eqx.is_array(leaf) or isinstance(leaf, float) for leaf in leaves)
        if not of_reals:
            return function(first, *arguments)
        try:
            return traced(first, *arguments)
        except jax.errors.TracerBoolConversionError as error:
            raise _undecided(error) from error

    return cast(Function, call)


def _undecided(error: Exception) -> InputError:
    """Error in one line for an `if` in a function of the user, whose numbers are traced."""
    frames = traceback.extract_tb(error.__traceback__)
    users = [each for each in frames if _ROOT not in each.filename and "jax" not in each.filename]
    place = frames[-1] if not users else users[-1]
    return InputError(
        f"{place.name} ({Path(place.filename).name}, line {place.lineno}): found an if, and, or, "
        f"min or max of a number that is traced in `{(place.line or '')[:80]}`, expected "
        "jnp.where(condition, a, b), & and |, jnp.minimum and jnp.maximum; the numbers of its "
        "object are traced too"
    )


def _compiled(function: Callable[..., Any]) -> Any:
    """Compiled function, which is no function of its own in generated C: its name is none there.

    Inlined by JAX, its operations would have the line of the call as their source.
    """

    def traced(*arguments: Any) -> Any:
        return function(*arguments)

    traced.__name__ = f"<{function.__name__}>"
    return jax.jit(traced)


@lru_cache(maxsize=256)
def _is_shipped(tree: Any) -> bool:
    """Whether all classes in a tree are of this package or of Python."""
    node = tree.node_data()
    own = node is None or node[0].__module__.partition(".")[0] in (_PACKAGE, "builtins")
    return own and all(map(_is_shipped, tree.children()))
