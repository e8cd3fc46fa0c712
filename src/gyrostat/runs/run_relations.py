"""Relations between the values of each run, for the program of a scenario."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from gyrostat.runs.designs import phases_of
from gyrostat.scenario.mode_relations import mode_relations
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.relations import relations_of
from gyrostat.scenario.scenario import Event, Scenario
from gyrostat.scenario.structure import notified, structure_of
from gyrostat.wheel.array import LIMIT_TOLERANCE


def run_relations(scenario: Scenario) -> Iterator[Relation]:
    """Relations that the values of each run of a scenario must fulfil.

    Beside those of a scenario, the program is for the order of its events and for the graph of its
    modes, and no wheel starts beyond its momentum limit.
    """
    yield from relations_of(scenario)
    yield from mode_relations(scenario)
    for before, after in pairwise(phases_of(structure_of(scenario))):
        yield _in_order(scenario, before, after)
    for wheel in scenario.wheels:
        yield _start(*(f"wheel.{wheel}.{name}" for name in ("speed", "inertia", "momentum_limit")))


def _in_order(scenario: Scenario, before: Event, after: Event) -> Relation:
    """The controller is notified of two events in the order of the scenario."""
    ends = [f"event.{e.name}.{n}" for e in (after, before) for n in ("time", "detected_after")]
    names = f"{before.name} before {after.name}"
    return Relation(
        tuple(key for key in ends if key in scenario.values),
        f"event.{after.name}: found events in another order, expected {names}, as in the scenario",
        lambda values: notified(before, values) <= notified(after, values),
    )


def _start(speed: str, inertia: str, limit: str) -> Relation:
    """A wheel starts within its momentum limit."""
    return Relation(
        (speed, inertia, limit),
        f"{speed}: found {{{speed}}} rad/s, a start beyond its momentum limit, expected "
        f"{{{limit}}} N·m·s or less with its inertia, {{{inertia}}} kg·m²",
        lambda values: (
            np.abs(values[inertia] * values[speed]) <= values[limit] * (1.0 + LIMIT_TOLERANCE)
        ),
    )
