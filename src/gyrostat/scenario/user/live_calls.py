"""Calls of user-defined objects in memory, compared with the calls of what their texts give.

The comparison of the objects finds other code and other values. What JAX or functools stored of an
earlier call is in neither, and whether two equal objects are the same one decides only while the
code runs: both are found in the operations of a call.
"""

import contextlib
import dataclasses
import inspect
from collections.abc import Callable, Iterator, Mapping
from contextvars import ContextVar
from typing import Any

from gyrostat.codegen.comparison import Difference, first_difference
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.user_errors import UserPartError
from gyrostat.scenario.user.lines import line_in, silent
from gyrostat.scenario.user.recording import traced
from gyrostat.wheel.friction_laws import Law

UNREGISTERED = "valid JAX type"
"""Part of the message of JAX about a class that is not registered as a tree."""

_live: ContextVar[Mapping[str, Any] | None] = ContextVar("live", default=None)


@contextlib.contextmanager
def comparing(live: Mapping[str, Any]) -> Iterator[None]:
    """Compare every call of user-defined parts inside; see `compare_live`.

    Args:
        live: Kind of a part -> its object in memory.
    """
    token = _live.set(live)
    try:
        yield
    finally:
        _live.reset(token)


def compare_live(
    part: str, inner: Any, method: str, arguments: tuple[Any, ...], call: Callable[[], Any]
) -> None:
    """Compare a call with the same call of the object in memory, if calls are compared.

    Args:
        part: Name of the part, which ends with its kind.
        inner: Instance of the class that the text gives, or a function.
        method: Name of the method.
        arguments: Its arguments.
        call: The call.

    Raises:
        UserPartError: Their operations or constants differ.
    """
    kind = part.rpartition(" ")[2]
    live = (_live.get() or {}).get(kind)
    if live is None:
        return
    with comparing({}), silent():
        loaded_trace = traced(call)
        try:
            twin = _twin(live, inner)
        except TypeError:
            return  # a class that only its own constructor can fill; the objects were compared
        try:
            live_trace = traced(lambda: getattr(twin, method)(*arguments))
        except Exception as error:
            if UNREGISTERED in str(error):
                return  # JAX knows only the class from the text; the objects were compared
            message = " ".join(str(error).split())[:200]
            raise UserPartError(
                f"{part}: found {type(error).__name__} ({message}) from {method} in memory, and a "
                "result from the text, expected the same: execute the definitions again"
            ) from None
    difference = first_difference(loaded_trace, live_trace, same_run=True)
    if difference is not None:
        raise _difference_error(part, difference)


def compare_live_law(part: str, live: Law, loaded: Law) -> None:
    """Compare the curve of a friction law in memory with that of the law that its text gives.

    Args:
        part: Name of the law, which ends with its kind.
        live: Class in memory.
        loaded: Class that the text gives.

    Raises:
        UserPartError: Their operations or constants differ.
    """
    with silent():
        difference = first_difference(traced_law(loaded), traced_law(live))
    if difference is not None:
        raise _difference_error(part, difference)


def traced_law(law: Law) -> Any:
    """Closed jaxpr of the curve of a friction law: torques, and the speed of its bends."""

    def curve(theta: list[Any], speed: Any, direction: Any) -> list[Any]:
        friction: Any = law.of(**dict(zip(law.dimensions(), theta, strict=True)))
        torques = [friction.torque(speed, direction), friction.breakaway_torque(direction)]
        return [*torques, friction.viscous_torque(speed, direction), friction.speed_scale()]

    number = jax.ShapeDtypeStruct((), float)
    return jax.make_jaxpr(lambda *arguments: [jnp.asarray(each) for each in curve(*arguments)])(
        [number] * len(law.dimensions()), number, number
    )


def _difference_error(part: str, difference: Difference) -> UserPartError:
    line = line_in(difference.equation)
    location, code = ("", "a call") if line is None else (f", line {line.number}", f"`{line.text}`")
    if line is not None and f" {line.file}:" not in part:
        location = f", {line.file} line {line.number}"
    return UserPartError(
        f"{part}{location}: found {code}, which gives {difference.found} from the text and "
        f"{difference.other} in memory, expected the same: execute the definitions again, because "
        "jax.jit, jax.lax and functools.cache keep what they computed before a change; and compare "
        "equal objects by ==, not by `is`"
    )


def _twin(live: Any, inner: Any) -> Any:
    """Object in memory with the values that the part has in the trial."""
    if isinstance(inner, jax.tree_util.Partial):
        return live
    is_class = inspect.isclass(live)
    twin = object.__new__(live if is_class else type(live))
    entries = {} if is_class else dict(getattr(live, "__dict__", {}))
    for field in dataclasses.fields(inner):
        if is_class or not field.metadata.get("static"):
            entries[field.name] = getattr(inner, field.name)
    for name, value in entries.items():
        object.__setattr__(twin, name, value)
    return twin
