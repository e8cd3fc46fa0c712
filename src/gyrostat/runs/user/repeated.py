"""Repeated traces of user-defined parts: a part must be the same each time it is constructed."""

import contextlib
from functools import lru_cache, partial
from itertools import count
from typing import Any

from gyrostat.codegen.comparison import difference_of, outline_of
from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import UserPartError
from gyrostat.core.user_modules import package_of
from gyrostat.runs.run_loop import loop_of
from gyrostat.runs.user.elsewhere import check_elsewhere
from gyrostat.runs.user.period import arguments_of, loaded_with, period_from, traced_period
from gyrostat.scenario.scenario import Source
from gyrostat.scenario.structure import Structure
from gyrostat.scenario.user.lines import line_that_changes, line_that_differs, silent
from gyrostat.scenario.user.recording import (
    Call,
    ImpureError,
    differing,
    recording,
    refuse_changed,
    refuse_kept,
)
from gyrostat.scenario.user.state import state_of

_numbers = count()
"""Numbers of further files: a package with another file has another digest, and is loaded anew."""


class _Shapes:
    """Plans of which only the shapes and types of the numbers count."""

    def __init__(self, plans: Any):
        self.plans = jax.eval_shape(lambda: plans)
        leaves, tree = jax.tree.flatten(self.plans)
        self._key = tree, tuple((leaf.shape, leaf.dtype) for leaf in leaves)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Shapes) and self._key == other._key

    def __hash__(self) -> int:
        return hash(self._key)


def try_parts(structure: Structure, plans: Any, names: str) -> tuple[Call, ...]:
    """Trace the first control period twice, and each call of a user-defined part alone.

    The second trace has freshly loaded modules and constructs each part once more than the first,
    so that it sees values that were computed while modules were loaded, in constructors, or in
    functions that JAX traces once.

    Args:
        structure: Structure of a scenario.
        plans: Designs; only the shapes and types of their numbers are used.
        names: Names of the user-defined parts, for messages about the construction of a part.

    Returns:
        The calls of user-defined parts.

    Raises:
        UserPartError: A part cannot be traced, keeps something outside its memory, or differs from
            one trace to the next.
    """
    return _try(structure, _Shapes(plans), names)


@lru_cache(maxsize=8)
def _try(structure: Structure, shapes: _Shapes, names: str) -> tuple[Call, ...]:
    def reload() -> Structure:
        empty = Source(f"trial{next(_numbers)}.py", "")
        return loaded_with(structure, (*structure.sources, empty))

    def retrace() -> Any:
        return traced_period(structure, shapes.plans)

    def retrace_anew() -> Any:
        return traced_period(reload(), shapes.plans)

    try:
        with recording() as calls:
            first = retrace()
        if not structure.sources:
            return ()
        package = package_of(structure.sources)
        refuse_kept(names, package)
        with silent():
            before = state_of(package)
            _construct(structure, shapes.plans)
            refuse_changed(names, before, state_of(package))
            copy = reload()
            _construct(copy, shapes.plans)
            second = traced_period(copy, shapes.plans)
    except ImpureError as error:
        raise error.at_line(line_that_changes(retrace_anew)) from None
    outline = outline_of(first)
    difference = difference_of(outline, outline_of(second))
    if difference is not None:
        with silent(), contextlib.suppress(UserPartError):
            retrace()  # loads the modules
        line = line_that_differs(retrace, retrace) or line_that_differs(retrace_anew, retrace_anew)
        raise differing(names, difference, line)
    trace = partial(period_from, structure, shapes.plans)
    check_elsewhere(names, structure.sources, trace, outline)
    return tuple(calls)


def _construct(structure: Structure, plans: Any) -> None:
    """Construct the parts of a run as they are in a trace."""
    loop_at = loop_of(structure)
    arguments = arguments_of(structure, plans)
    jax.eval_shape(lambda *inputs: jax.tree.leaves(loop_at(*inputs).begin()), *arguments)
