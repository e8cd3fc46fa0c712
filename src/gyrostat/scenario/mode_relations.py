"""Relations with which each run of a scenario has the graph of its modes."""

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

from gyrostat.scenario.mode_graph import FREE, GraphEdge, cycle_of, edges, hold_together, place_of
from gyrostat.scenario.mode_kind import IN_MODE, UNTIL
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.timeline import END_OF_MODE, TRANSITION
from gyrostat.scenario.transition_kind import CONDITIONS, PAIRS

_DURATIONS = ("time_in_mode", "held", "minimum_dwell")
"""Least durations beside other conditions; none is 0."""
_KEYS = {TRANSITION: CONDITIONS, "reference.mode": {**UNTIL, **IN_MODE}}


def mode_relations(scenario: Scenario) -> Iterator[Relation]:
    """Relations with which what `check_modes` has proven of a scenario is true of its runs.

    A condition that is used stays in use, and no other one is used; a change may take longer.
    Changes that take no time, and of which only the limits exclude that they follow each other,
    exclude it in every run.
    """
    for part in scenario.parts:
        for name, entry in _KEYS.get(part.section, {}).items():
            key = f"{part.section}.{part.name}.{name}"
            default, nominal = entry.defaults()[0], scenario.values[key]
            is_free = name == "unloading" or (name in _DURATIONS and nominal == default)
            if not is_free:
                yield _stays(key, default, nominal)
    instant = [edge for edge in edges(scenario) if edge.time == 0.0 and not edge.once]
    if cycle_of([edge._replace(limits=FREE) for edge in instant]):
        for pair in combinations([edge._replace(view=0.0) for edge in instant], 2):
            if not hold_together(pair):
                yield _stay_apart(*pair, scenario.values)


def _stays(key: str, default: float, nominal: float) -> Relation:
    """A condition is used, or not, as in the scenario."""
    if nominal == default:
        text = f"{key}: found {{{key}}}, expected no such condition, as in the scenario"
        return Relation((key,), text, lambda values: values[key] == default)
    text = f"{key}: found {{{key}}}, which is no condition, expected one, as in the scenario"
    return Relation((key,), text, lambda values: values[key] != default)


def _stay_apart(first: GraphEdge, second: GraphEdge, known: Mapping[str, float]) -> Relation:
    """The limits of two changes exclude each other."""
    pairs = [
        (low, high)
        for name in PAIRS
        for one, other in ((first, second), (second, first))
        if (low := _key(one, f"{name}_above")) in known
        and (high := _key(other, f"{name}_below")) in known
    ]

    def holds(values: Mapping[str, Any]) -> Any:
        return sum(1.0 * (values[low] > values[high]) for low, high in pairs) > 0.5

    keys = tuple(dict.fromkeys(key for pair in pairs for key in pair))
    return Relation(
        keys,
        f"{place_of(first)}: found limits that hold together with those of {place_of(second)}, "
        "expected that they exclude each other, as in the scenario: both changes take no time",
        holds,
    )


def _key(edge: GraphEdge, name: str) -> str:
    """Key of a limit of a change."""
    start = "until_" if edge.name.startswith(END_OF_MODE) else ""
    return f"{place_of(edge)}.{start}{name}"
