"""Flight module of functions: what each needs, and its run in Python."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.codegen.flight.module import Entry
from gyrostat.codegen.flight.reserved import HEADERS, LIBRARY
from gyrostat.codegen.scope import LARGEST
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp

STEPS = 40
"""Number of steps of the test run."""
SAFE = {"hold": "the last accepted command", "zero": "zero"}
"""Safe command -> description."""


@dataclass(frozen=True)
class Target:
    """Flight module: a set of functions that is emitted as one C module.

    Attributes:
        name: Name of the module and prefix of its functions.
        title: One-line title.
        period: Control period that the parameters were tuned for, s.
        begin: Functions called once, in this order.
        steps: Functions called once in every period, in this order.
        constants: Name -> value of constant arguments.
        inputs: Name -> values of variable arguments in a test run; the first axis is the step.
        units: Name -> unit of arguments and results that are single numbers.
        on_bad: Safe command after a rejected sample; None if inputs are not
            validated.
        cases: Steps that are of interest: name of a number in C, such as wheel.friction.coulomb ->
            its value before a step from the start. Others have their tuned values, or those of the
            first step of the test run.
        digests: What the module is made from, such as "model" -> its SHA-256 digest.
        ranges: Limits of measurements that come from the data of the sensors, for the README.
        untested: Results, or members of results as in C, that are not tested to be finite.
    """

    name: str
    title: str
    period: float
    begin: tuple[Entry, ...]
    steps: tuple[Entry, ...]
    constants: Mapping[str, Any]
    inputs: Mapping[str, Any]
    units: Mapping[str, str] = field(default_factory=dict)
    on_bad: str | None = None
    cases: tuple[Mapping[str, float], ...] = ()
    digests: Mapping[str, str] = field(default_factory=dict)
    ranges: tuple[str, ...] = ()
    untested: tuple[str, ...] = ()

    @property
    def entries(self) -> tuple[Entry, ...]:
        """All functions of the module."""
        return (*self.begin, *self.steps)

    def designed(self) -> dict[str, Any]:
        """Name -> designed value of each parameter."""
        first = self.begin[0]
        return first.named(first.function())


def renamed(target: Target, name: str) -> Target:
    """Flight module with another name, which is the prefix of its functions too.

    Raises:
        InputError: The name is that of a header of C, or a function would have a name that the test
            program or a header declares.
    """

    def rename(entry: Entry) -> Entry:
        return replace(entry, name=name + entry.name.removeprefix(target.name))

    begin, steps = (tuple(map(rename, entries)) for entries in (target.begin, target.steps))
    if name in HEADERS:
        raise InputError(f"--name: found {name!r}, which is a header of C, expected another name")
    for entry in (*begin, *steps):
        if entry.name in LIBRARY:
            raise InputError(
                f"--name: found {name!r}, which gives the function {entry.name} the name of one of "
                "the test program, expected another name"
            )
    return replace(target, name=name, begin=begin, steps=steps)


def require_controller(target: Target, form: str) -> None:
    """Check that a module has one step from a measurement to a command and a report.

    Args:
        target: Flight module.
        form: Format for which it is required, for the message.

    Raises:
        InputError: It has another one, such as that of a wheel.
    """
    results = {name for entry in target.steps for name in entry.results}
    if len(target.steps) != 1 or not {"command", "report"} <= results:
        raise InputError(
            f"--to {form}: found {target.name}, expected a controller or compensator, or a scenario"
        )


def _parameters(name: str, values: Mapping[str, Any], has_tables: bool) -> Entry:
    def parameters() -> Any:
        every = list(values.values())
        return tuple(every) if len(every) > 1 else every[0]

    remark = f"; arrays of more than {LARGEST} numbers are constants of the code" * has_tables
    parameters.__doc__ = f"Set the parameters to their identified and tuned values{remark}."
    return Entry(f"{name}_parameters", parameters, {}, tuple(values))


Call = tuple[str, Callable[..., Any], tuple[str, ...]]
"""Suffix of an entry's name, its function, and the names of its results."""


def flight_module(
    name: str,
    parameters: Mapping[str, Any],
    state: Mapping[str, Any],
    begin: Sequence[Call],
    steps: Sequence[Call],
    **others: Any,
) -> Target:
    """Flight module whose functions get their arguments by the names of their parameters.

    Args:
        name: Name of the module.
        parameters: Name -> value of the tuned parameters. Arrays of more than `LARGEST` elements
            are compiled in as constants.
        state: Name -> example of the state passed from one step to the next.
        begin: Functions called once, after the parameters are set.
        steps: Functions called once in every period.
        others: Further fields of the module.
    """
    inputs = {n: jax.tree.map(lambda x: x[0], value) for n, value in others["inputs"].items()}
    split = {
        key: eqx.partition(value, lambda leaf: np.size(leaf) <= LARGEST)
        for key, value in parameters.items()
    }
    parameters = {key: small for key, (small, _) in split.items()}
    # one array object for each table, so that every use reads the same constant
    tables = {key: jax.tree.map(jnp.asarray, large) for key, (_, large) in split.items()}
    examples = {**parameters, **state, **others["constants"], **inputs}

    def combined(key: str, value: Any) -> Any:
        return eqx.combine(value, tables[key]) if key in tables else value

    def entry(word: str, function: Callable[..., Any], results: tuple[str, ...]) -> Entry:
        arguments = {n: examples[n] for n in inspect.signature(function).parameters}

        @wraps(function)
        def with_tables(*values: Any) -> Any:
            every = dict(zip(arguments, values, strict=True))
            return function(*(combined(n, value) for n, value in every.items()))

        return Entry(f"{name}_{word}", with_tables, arguments, results)

    return Target(
        name=name,
        begin=(
            _parameters(name, parameters, bool(jax.tree.leaves(tables))),
            *(entry(*call) for call in begin),
        ),
        steps=tuple(entry(*call) for call in steps),
        **others,
    )
