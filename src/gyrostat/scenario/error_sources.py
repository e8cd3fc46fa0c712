"""Sources of pointing error of a scenario, and the values with which each is switched off.

A number belongs to a source by `gyrostat.scenario.schema.Key.source`. Only values of the simulated
spacecraft change: they are drawn, so that controller and estimator keep the design for the nominal
ones, and one compiled program computes all runs with the same random numbers.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.kinds.registry import APPENDAGES, named_components, sections_of
from gyrostat.scenario.scenario import Dispersion, Scenario
from gyrostat.scenario.schema import FRICTION
from gyrostat.scenario.structure import structure_of

MILLIONTH = 1e-6
"""Factor on a number without its source, unless its key has another value."""
SWITCHED = frozenset({"environment.torque", "sensor", "actuator", "star_tracker"})
"""Sections whose parts can have a source of pointing error."""


@dataclass(frozen=True, eq=False)
class ErrorSource:
    """Source of pointing error.

    Attributes:
        name: Name: the source, and the place in the scenario if there are several such places.
        keys: Full key -> value without the source, SI; None: a millionth of its value.
        is_property: Whether it produces no error of its own, as an appendage, but changes that of
            the others.
        is_known: Whether controller and estimator have a model of it, which compensates for it and
            is switched off with it.
    """

    name: str
    keys: Mapping[str, float | None]
    is_property: bool = False
    is_known: bool = False


def error_sources(scenario: Scenario) -> tuple[ErrorSource, ...]:
    """Sources of pointing error that a scenario has: with a value other than that without them."""
    values, dispersed = scenario.values, set(scenario.dispersed)
    keys: dict[tuple[str, str], dict[str, float | None]] = {}
    fixed = _fixed_events(scenario)
    for place, entries in sections_of(scenario).items():
        if place in fixed:
            continue
        for name, entry in entries.items():
            for end in entry.ends(f"{place}.{name}") if entry.source else ():
                # numbers of optional sections are not in every scenario
                if values.get(end) not in (None, entry.without or 0.0) or end in dispersed:
                    keys.setdefault((entry.source, place), {})[end] = entry.without
    return tuple(
        ErrorSource(
            _name(source, place),
            of_place,
            place.partition(".")[0] in APPENDAGES,
            source == FRICTION,
        )
        for (source, place), of_place in keys.items()
    )


def _name(source: str, place: str) -> str:
    if source in place.split("."):  # as in environment.torque.NAME
        return place
    return f"{source}, {place}" if "." in place else source


def never_switched(scenario: Scenario) -> list[str]:
    """Places of parts that may be sources of pointing error, but cannot be switched off."""
    sections = sections_of(scenario)
    places = [named.place for named in named_components(scenario) if named.section in SWITCHED]
    fixed = [
        place for place, changes_target in _fixed_events(scenario).items() if not changes_target
    ]
    return [
        *(p for p in places if not any(key.source for key in sections[p].values())),
        *fixed,
    ]


def _fixed_events(scenario: Scenario) -> dict[str, bool]:
    """Places of the events that cannot be left out, and whether they change the target.

    A change of the target is part of the reference. A window that follows an event needs it, and so
    does a phase of the controller that is not the last one.
    """
    turning_points = [event.name for event in structure_of(scenario).turning_points]
    needed = {window.event for window in scenario.windows} | set(turning_points[:-1])
    fixed = {}
    for event in scenario.events:
        changes_target = kind_of(event).changes_target
        if changes_target or event.name in needed:
            fixed[f"event.{event.name}"] = changes_target
    return fixed


def with_switches(scenario: Scenario, sources: Iterable[ErrorSource]) -> Scenario:
    """Scenario in which every number of the sources is drawn, after those that are dispersed."""
    known = set(scenario.dispersed)
    switches = []
    for key, without in ((key, value) for each in sources for key, value in each.keys.items()):
        if key not in known:
            value = float(scenario.values[key])
            ends = sorted((value, MILLIONTH * value if without is None else without))
            switches.append(Dispersion((key,), "uniform", ((ends[0], ends[1]),)))
    return replace(scenario, dispersions=(*scenario.dispersions, *switches))


def values_without(names: Sequence[str], values: Matrix, sources: Iterable[ErrorSource]) -> Matrix:
    """Drawn values of runs in which some sources are switched off, (runs, keys).

    Args:
        names: Key of each column.
        values: Values of the same runs with all sources, (runs, keys).
        sources: Sources that are switched off.
    """
    places = {name: place for place, name in enumerate(names)}
    values = np.array(values)
    for source in sources:
        for key, without in source.keys.items():
            column = places[key]
            values[:, column] = MILLIONTH * values[:, column] if without is None else without
    return values
