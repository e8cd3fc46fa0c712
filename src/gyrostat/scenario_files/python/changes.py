"""Changes of a scenario from Python: components, values of keys, attributes."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError, placed
from gyrostat.core.toml_file import refuse_unknown
from gyrostat.core.user_modules import is_user_kind, joined_sources
from gyrostat.core.validation import MOST_PERIODS
from gyrostat.runs.user.live_trial import require_same_traces
from gyrostat.runs.user.packages import with_packages
from gyrostat.scenario.kinds.registry import (
    KINDS,
    component,
    fitting_estimator,
    kinds_of,
    named_components,
    numbers_of,
)
from gyrostat.scenario.scenario import Scenario, Source
from gyrostat.scenario.user.kinds import USER_KINDS
from gyrostat.scenario_files.python.change_parts import LISTS, is_list, user_list, with_list
from gyrostat.scenario_files.python.objects import user_object
from gyrostat.scenario_files.read_metrics import with_windows
from gyrostat.scenario_files.read_requirements import with_requirements
from gyrostat.scenario_files.scenario_file import validated
from gyrostat.scenario_files.tables import Table

FIXED = ("values", "count", "wheels", "axes", "friction", "sources", "parts", "texts", "surfaces")
"""Attributes of a scenario that follow from others or from its spacecraft."""


def replaced(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    """Scenario with changes; see `Scenario.replace`."""
    attributes = {field.name for field in dataclasses.fields(Scenario)} - {*KINDS, *FIXED}
    known = tuple(dict.fromkeys((*KINDS, *LISTS, *sorted(attributes))))
    parts = {name: value for name, value in changes.items() if name in KINDS or name in LISTS}
    live: dict[str, Any] = {}
    # the defaults of a controller depend on the sensors
    for name, given in sorted(parts.items(), key=lambda each: each[0] == "controller"):
        if is_list(name, given):
            scenario = _with_list(scenario, name, given, live)
        else:
            scenario = _with_component(scenario, name, given, changes, live)
    needed = fitting_estimator(kinds_of(scenario))
    if scenario.estimator != needed:
        raise InputError(
            f"{scenario.name}: found the estimator {scenario.estimator}, expected {needed} for the "
            f"sensors {scenario.sensors}"
        )
    numbers = {name: value for name, value in changes.items() if "." in name}
    if "windows" in changes:
        scenario = with_windows(scenario, changes["windows"])
    taken = {*parts, *numbers, "windows", "requirements"}
    others = {name: value for name, value in changes.items() if name not in taken}
    refuse_unknown(Path(scenario.name), "", others, known)
    for name, value in others.items():
        before = getattr(scenario, name)
        if None not in (before, value) and not isinstance(value, type(before)):
            raise InputError(
                f"{scenario.name}: found {value!r} as {name}, expected a {type(before).__name__}"
            )
    scenario = dataclasses.replace(scenario, **others)
    scenario = _with_values(scenario, numbers)
    if "requirements" in changes:
        scenario = with_requirements(scenario, changes["requirements"])
    lost = [key for key in scenario.dispersed if key not in scenario.values]
    if lost:
        raise InputError(
            f"{scenario.name}: found a dispersion of {lost[0]}, a key of the replaced component, "
            "expected dispersions of the keys of the new one, or dispersions=() for none"
        )
    with placed(scenario.name):
        scenario = validated(with_packages(scenario))
    require_same_traces(scenario, live)
    return scenario


def _with_component(
    scenario: Scenario, section: str, given: Any, changes: Mapping[str, Any], live: dict[str, Any]
) -> Scenario:
    """Scenario with another component in a section; an object is added to `live` by its kind.

    The values of an object are its own. Those of a kind are in the changes, or its defaults.
    """
    sources, values = scenario.sources, None
    if isinstance(given, str):
        if given not in KINDS[section] and not (is_user_kind(given) and section in USER_KINDS):
            raise Table(Path(scenario.name), "", {}).refuse(
                section, given, f"one of {', '.join(KINDS[section])}, or an object of your class"
            )
        kind = given
    else:
        if section not in USER_KINDS:
            raise InputError(
                f"{scenario.name}: found {type(given).__name__} as {section}, expected one of "
                f"{', '.join(KINDS[section])}"
            )
        kind, found, values, live_object = user_object(section, given)
        live[kind] = live_object
        sources = joined_sources(scenario.name, _kept(scenario, section), found)
    made = component(section, kind, sources)
    if values is None:
        start = f"{section}."
        row = {n.removeprefix(start): v for n, v in changes.items() if n.startswith(start)}
        defaults = made.defaults(scenario.values, scenario.command_delay)
        table = Table(Path(scenario.name), start, row).with_missing(defaults)
        numbers = table.numbers(made.keys())
        values = {end.removeprefix(start): value for end, value in numbers.items()}
    lists = tuple(f"{part.section}.{part.name}." for part in scenario.parts)
    kept = {
        key: value
        for key, value in scenario.values.items()
        if not key.startswith(f"{section}.") or key.startswith(lists)
    }
    new = {f"{section}.{name}": value for name, value in values.items()}
    return dataclasses.replace(
        scenario,
        **{section: kind},
        sources=sources,
        values=dict(sorted({**kept, **new}.items())),
    )


def _with_list(scenario: Scenario, argument: str, given: Any, live: dict[str, Any]) -> Scenario:
    """Scenario with another list of user-defined parts, added to `live` by their kinds."""
    found = user_list(scenario, argument, given)
    sources = _kept(scenario, LISTS[argument])
    for part in found.values():
        sources = joined_sources(scenario.name, sources, part.sources)
        live[part.kind] = part.live
    return with_list(dataclasses.replace(scenario, sources=sources), argument, found)


def _kept(scenario: Scenario, section: str) -> tuple[Source, ...]:
    """Files of a scenario, if user-defined parts of other sections need them."""
    kinds = [named.kind for named in named_components(scenario) if named.section != section]
    return scenario.sources if any(map(is_user_kind, [*kinds, scenario.friction])) else ()


def _with_values(scenario: Scenario, given: Mapping[str, Any]) -> Scenario:
    """Scenario with other values of its keys."""
    if not given:
        return scenario
    entries, values = numbers_of(scenario), dict(scenario.values)
    table = Table(Path(scenario.name), "", {})
    for key, value in given.items():
        ends = [key] if key in values else [k for k in values if k.startswith(f"{key}.")]
        refuse_unknown(table.path, "", () if ends else (key,), tuple(values))
        parts = [value] if ends == [key] else np.asarray(value, dtype=object).ravel().tolist()
        if len(parts) != len(ends):
            raise table.refuse(key, value, f"{len(ends)} values")
        values |= {
            end: table.allowed(end, part, entries[end])
            for end, part in zip(ends, parts, strict=True)
        }
    period, duration = values["run.control_period"], values["run.duration"]
    count = table.multiple("run.duration", duration, "control period", period, MOST_PERIODS)
    times = {event.name: values[f"event.{event.name}.time"] for event in scenario.events}
    return dataclasses.replace(
        scenario,
        values=values,
        count=count,
        events=tuple(sorted(scenario.events, key=lambda event: times[event.name])),
    )
