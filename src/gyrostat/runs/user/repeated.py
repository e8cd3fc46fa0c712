"""Repeated traces of user-defined parts: a part must be the same each time it is constructed."""

import contextlib
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from itertools import count
from typing import Any

import numpy as np

from gyrostat.codegen.comparison import first_difference
from gyrostat.core.jax64 import jax
from gyrostat.core.user_errors import OwnError
from gyrostat.core.user_modules import is_own, package_of
from gyrostat.runs.run_loop import Drawn, loop_of
from gyrostat.scenario.kinds.registry import KINDS
from gyrostat.scenario.scenario import Source
from gyrostat.scenario.structure import Structure
from gyrostat.scenario.user.lines import line_that_changes, line_that_differs, silent
from gyrostat.scenario.user.parts import own_component
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


def try_parts(structure: Structure, plans: Any, own: str) -> tuple[Call, ...]:
    """Trace the first control period three times, and each call of a user-defined part alone.

    The third trace has freshly loaded modules, so that it sees values that were computed while they
    were loaded, or in functions that JAX traces once.

    Args:
        structure: Structure of a scenario.
        plans: Designs; only the shapes and types of their numbers are used.
        own: Names of the user-defined parts, for messages about the construction of a part.

    Returns:
        The calls of user-defined parts.

    Raises:
        OwnError: A part cannot be traced, keeps something outside its memory, or differs from one
            trace to the next.
    """
    return _tried(structure, _Shapes(plans), own)


@lru_cache(maxsize=8)
def _tried(structure: Structure, shapes: _Shapes, own: str) -> tuple[Call, ...]:
    def fresh() -> Callable[[], Any]:
        empty = Source(f"trial{next(_numbers)}.py", "")
        one = replace(structure, sources=(*structure.sources, empty))

        def trace() -> Any:
            _load(one)
            return traced_period(one, shapes.plans)

        return trace

    package = package_of(structure.sources)
    try:
        first, calls = traced_period(structure, shapes.plans)
        if not structure.sources:
            return ()
        refuse_kept(own, package)
        with silent():
            before = state_of(package)
            second, _ = traced_period(structure, shapes.plans)
            refuse_changed(own, before, state_of(package))
            third, _ = fresh()()
    except ImpureError as error:
        raise error.at_line(line_that_changes(fresh())) from None
    again = fresh()
    for other, pair in ((second, (again, again)), (third, (fresh(), fresh()))):
        difference = first_difference(first, other)
        if difference is not None:
            with silent(), contextlib.suppress(OwnError):
                again()  # loads the modules
            raise differing(own, difference, line_that_differs(*pair))
    return tuple(calls)


def traced_period(structure: Structure, plans: Any) -> tuple[Any, list[Call]]:
    """Jaxpr of the first control period, and the calls of user-defined parts in it."""
    numbers = np.zeros(len(structure.keys)), Drawn(np.zeros(len(structure.dispersed)))

    def period(*given: Any) -> Any:
        loop = loop_of(structure)(*given)
        return jax.tree.leaves(loop.tick(loop.begin(), 0))

    with recording() as calls:
        return jax.make_jaxpr(period)(*numbers, plans, jax.random.key(0)), calls


def _load(structure: Structure) -> None:
    """Load the parts of a structure; inside a trace, the arrays of a module would be traced."""
    named = [(section, getattr(structure, section)) for section in KINDS]
    named += [(part.section, part.kind) for part in structure.parts]
    named += [("event", event.kind) for event in structure.events]
    for section, kind in named:
        if is_own(kind):
            own_component(section, kind, structure.sources)
