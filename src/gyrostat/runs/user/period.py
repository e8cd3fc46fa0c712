"""First control period of a run, traced."""

from dataclasses import replace
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.user_modules import Source, is_user_kind
from gyrostat.runs.run_loop import Drawn, loop_of
from gyrostat.scenario.kinds.registry import named_components
from gyrostat.scenario.structure import Structure
from gyrostat.scenario.user.kinds import user_component


def traced_period(structure: Structure, plans: Any) -> Any:
    """Jaxpr of the first control period."""
    loop_at = loop_of(structure)

    def period(*arguments: Any) -> Any:
        loop = loop_at(*arguments)
        return jax.tree.leaves(loop.tick(loop.begin(), 0))

    return jax.make_jaxpr(period)(*arguments_of(structure, plans))


def period_from(structure: Structure, plans: Any, sources: tuple[Source, ...]) -> Any:
    """Jaxpr of the first control period with these texts of the parts."""
    return traced_period(loaded_with(structure, sources), plans)


def arguments_of(structure: Structure, plans: Any) -> tuple[Any, ...]:
    """What the loop of a run is constructed from: values, draws, designs and random key."""
    drawn = Drawn(np.zeros(len(structure.dispersed)))
    return np.zeros(len(structure.keys)), drawn, plans, jax.random.key(0)


def loaded_with(structure: Structure, sources: tuple[Source, ...]) -> Structure:
    """Structure with these texts of its parts, which are loaded.

    Inside a trace, the arrays of a module would be traced.
    """
    structure = replace(structure, sources=sources)
    for _, section, kind in named_components(structure):
        if is_user_kind(kind):
            user_component(section, kind, structure.sources)
    return structure
