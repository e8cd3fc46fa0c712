"""Scenario that is ready to be simulated: its designs and the program of an engine."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from gyrostat.campaigns.accelerated import AcceleratedProgram, accelerated_program
from gyrostat.campaigns.delivered_programs import delivered_program
from gyrostat.campaigns.native import Program, program_name, program_of
from gyrostat.codegen.jax_versions import require_supported
from gyrostat.codegen.simd.compiler import require_compiler
from gyrostat.core.engines import ACCELERATED
from gyrostat.core.jax64 import jax
from gyrostat.core.random_keys import is_random_key, random_keys
from gyrostat.core.threefry import Words
from gyrostat.core.types import Vector
from gyrostat.runs.designs import Plans
from gyrostat.runs.metrics.observer import Seen
from gyrostat.runs.plans import plans_of
from gyrostat.runs.run_loop import OWN, Drawn, loop_of, runner_of
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import Structure, structure_of
from gyrostat.simulation import Runner


@dataclass(frozen=True)
class Ready:
    """Scenario that is ready to be simulated.

    Attributes:
        scenario: Scenario.
        nominal: Nominal values.
        plans: Controller designs.
        runner: Runner of its loop.
        program: Program of the native engine or of an accelerator; None for the engine "jax".
    """

    scenario: Scenario
    nominal: Vector
    plans: Plans
    runner: Runner
    program: Program | AcceleratedProgram | None

    def fly_with_jax(
        self, nominal: Vector, drawn: Drawn, plans: Plans, keys: Words, asked: Sequence[int]
    ) -> Iterator[tuple[Seen, Any, Any]]:
        """Simulate 64 runs by JAX; see `gyrostat.campaigns.native.Program.chunks`."""
        arguments = (nominal, drawn, plans, random_keys(keys))
        carry = _begin(structure_of(self.scenario))(*arguments)
        for (_, metrics), (errors, rows) in self.runner.chunks(
            *arguments, carry=carry, asked=asked
        ):
            yield metrics, errors, rows


@lru_cache(maxsize=8)
def _begin(structure: Structure) -> Callable[..., Any]:
    make = loop_of(structure)
    axes = tuple(0 if is_drawn else None for is_drawn in OWN)

    def begin(*arguments: Any) -> Any:
        return jax.tree.map(_of_definite_type, make(*arguments).begin())

    return jax.jit(jax.vmap(begin, axes))


def _of_definite_type(leaf: Any) -> Any:
    """Array without the weak type of a number of Python.

    A scan returns its carry without it: the chunk after the first one would be another program.
    """
    return leaf if is_random_key(leaf) else jax.lax.convert_element_type(leaf, leaf.dtype)


@dataclass(frozen=True)
class _Wanted:
    """Program of the native engine, which its name identifies within a process."""

    name: str
    structure: Structure = field(compare=False)
    plans: Plans = field(compare=False)
    parts: int = field(compare=False)


@lru_cache(maxsize=8)
def _program(wanted: _Wanted) -> Program:
    """Program that scenarios share which differ in numbers only; one with user parts is traced."""
    return program_of(wanted.structure, wanted.plans, parts=wanted.parts)


@lru_cache(maxsize=8)
def make_ready(scenario: Scenario, engine: str, parts: int = 0) -> Ready:
    """Make all that a scenario needs to be simulated, once in this process.

    Args:
        scenario: Scenario.
        engine: "jax", "native" or one that uses an accelerator.
        parts: See `gyrostat.campaigns.native.program_of`.

    Raises:
        InputError: See `prepare`.
    """
    structure, plans = structure_of(scenario), plans_of(scenario)
    program = None
    if engine == "native":
        program = delivered_program(scenario, parts)
        if program is None:
            name = program_name(structure, plans, parts)
            program = _program(_Wanted(name, structure, plans, parts))
    elif engine in ACCELERATED:
        program = accelerated_program(structure, plans, engine)
    nominal = np.array([*scenario.values.values()])
    return Ready(scenario, nominal, plans, runner_of(structure), program)


def prepare(
    scenario: Scenario, *, parts: int = 0, verify: bool = False, engine: str = "native"
) -> None:
    """Make the program of a scenario for an engine; workers then find it in the cache.

    Args:
        scenario: Scenario.
        parts: See `gyrostat.campaigns.native.program_of`.
        verify: See `gyrostat.campaigns.native.program_of`.
        engine: "native", or an engine that uses an accelerator.

    Raises:
        InputError: See `gyrostat.campaigns.native.program_of` and
            `gyrostat.campaigns.accelerated.accelerated_program`.
    """
    require_supported()
    if engine in ACCELERATED:
        make_ready(scenario, engine, parts)
        return
    require_compiler()  # also where the program is loaded already
    if verify:
        program_of(structure_of(scenario), plans_of(scenario), parts=parts, verify=True)
    make_ready(scenario, "native", parts)
