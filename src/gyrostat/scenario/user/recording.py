"""Calls of user-defined parts during a trial: each is traced again, alone, and must be the same."""

import contextlib
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from typing import Any, NamedTuple

import numpy as np

from gyrostat.codegen.comparison import Difference, first_difference
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.user_errors import UserPartError
from gyrostat.scenario.user.lines import Line, line_in, line_that_differs, silent
from gyrostat.scenario.user.state import SHARED, kept_tracers, state_of

FROZEN = (
    "the same in each call: a part is compiled once, so that NumPy's random numbers, the time or a "
    "counter would keep their first value in all runs (the memory is for what changes, "
    "measurement.time is the time, the key of a sensor gives random numbers)"
)
OF_NO_PROCESS = (
    "the same in each process, on each machine and day: a part is compiled once, and its runs are "
    "replayed later (sorted(...) gives the entries of a set an order; what hash, the number or "
    "arguments of a process, a host or a date tell is a field of the part)"
)
RETURNED = "the value in the memory, which each call returns"


class Call(NamedTuple):
    """Call of a user-defined part.

    Attributes:
        part: Name of the part, such as "controller mission.py:EarthPointer".
        method: Name of the method.
        traced: Its operations, a closed jaxpr without arguments, whose constants can be values of
            the trace of the whole loop.
        simulated: Whether the simulation makes this call; otherwise only flight code does.
    """

    part: str
    method: str
    traced: Any
    simulated: bool


class ImpureError(UserPartError):
    """User-defined part that keeps something outside its memory; the line is not known yet.

    Attributes:
        at_line: Function that gives the error that names the line.
    """

    def __init__(self, at_line: Callable[[Line | None], UserPartError]):
        super().__init__(str(at_line(None)))
        self.at_line = at_line


_calls: ContextVar[list[Call] | None] = ContextVar("calls", default=None)


@contextlib.contextmanager
def recording() -> Iterator[list[Call]]:
    """Record all calls of user-defined parts that are traced inside."""
    calls: list[Call] = []
    token = _calls.set(calls)
    try:
        yield calls
    finally:
        _calls.reset(token)


def record(
    part: str, method: str, module: str, call: Callable[[], Any], *, simulated: bool = True
) -> None:
    """Record a call of a user-defined part, if calls are recorded.

    Args:
        part: Name of the part.
        method: Name of the method.
        module: Module of the user's class or function.
        call: The call; it is traced twice.
        simulated: See `Call`.

    Raises:
        UserPartError: The part keeps something outside its memory, or its second trace differs.
    """
    calls = _calls.get()
    if calls is None:
        return
    package = module.partition(".")[0]
    refuse_kept(part, package)
    token = _calls.set(None)
    try:
        with silent():
            first, before = traced(call), state_of(package)
            second, after = traced(call), state_of(package)
        refuse_changed(part, before, after)
        difference = first_difference(first, second, same_run=True)
        if difference is not None:
            traces = [lambda: traced(call)] * 2
            raise differing(part, difference, line_that_differs(*traces))
    finally:
        _calls.reset(token)
    calls.append(Call(part, method, first, simulated))


def refuse_kept(part: str, package: str) -> None:
    """Check that no value of a trace is stored in a global.

    Raises:
        ImpureError: There is one.
    """
    names = kept_tracers(package)
    if names:
        raise ImpureError(
            lambda line: _error_at(part, line, f"keeps a value of the run in {names[0]}", RETURNED)
        )


def refuse_changed(part: str, before: dict[str, Any], after: dict[str, Any]) -> None:
    """Check that no global has changed in a call.

    Raises:
        ImpureError: One has.
    """
    names = [name for name in after if after[name] != before.get(name)]
    if names:
        expected = FROZEN if names[0] == SHARED else RETURNED
        raise ImpureError(lambda line: _error_at(part, line, f"changes {names[0]}", expected))


def differing(part: str, difference: Difference, line: Line | None) -> UserPartError:
    """Error for two traces that differ."""
    line = line or line_in(difference.equation)
    effect = f"gives {difference.found} in one trace and {difference.other} in another"
    return _error_at(part, line, effect, FROZEN)


def differing_elsewhere(part: str, difference: Difference) -> UserPartError:
    """Error for a trace of another process that differs."""
    effect = f"gives {difference.found} here and {difference.other} in another process"
    return _error_at(part, line_in(difference.equation), effect, OF_NO_PROCESS)


def _error_at(part: str, line: Line | None, found: str, expected: str) -> UserPartError:
    if line is None:
        return UserPartError(f"{part}: found a line that {found}, expected {expected}")
    # of several parts, the one whose file it is
    part = next((each for each in part.split(", ") if f" {line.file}:" in each), part)
    file = "" if f" {line.file}:" in part else f" {line.file}"
    label = f"{part},{file} line {line.number}"
    return UserPartError(f"{label}: found `{line.text}`, which {found}, expected {expected}")


def traced(call: Callable[[], Any]) -> Any:
    """Closed jaxpr of a call without arguments; its results are the numbers among them."""

    def numbers() -> list[Any]:
        leaves = jax.tree.leaves(call())
        kinds = jax.Array | np.ndarray | np.generic | bool | int | float | complex
        return [jnp.asarray(leaf) for leaf in leaves if isinstance(leaf, kinds)]

    return jax.make_jaxpr(numbers)()
