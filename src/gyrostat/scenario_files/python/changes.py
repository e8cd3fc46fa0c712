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
from gyrostat.scenario.sensing import options_of
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
    names = tuple(dict.fromkeys((*KINDS, *LISTS, *sorted(attributes))))
    parts = {name: value for name, value in changes.items() if name in KINDS or name in LISTS}
    live: dict[str, Any] = {}
    # the defaults of a controller depend on the sensors
    for name, argument in sorted(parts.items(), key=lambda each: each[0] == "controller"):
        if is_list(name, argument):
            scenario = _with_list(scenario, name, argument, live)
        else:
            scenario = _with_component(scenario, name, argument, changes, live)
    estimator = fitting_estimator(kinds_of(scenario))
    if scenario.estimator != estimator:
        raise InputError(
            f"{scenario.name}: found the estimator {scenario.estimator}, expected {estimator} for "
            f"the sensors {scenario.sensors}"
        )
    numbers = {name: value for name, value in changes.items() if "." in name}
    if "windows" in changes:
        scenario = with_windows(scenario, changes["windows"])
    non_fields = {*parts, *numbers, "windows", "requirements"}
    field_values = {name: value for name, value in changes.items() if name not in non_fields}
    refuse_unknown(Path(scenario.name), "", field_values, names)
    for name, value in field_values.items():
        old_value = getattr(scenario, name)
        if None not in (old_value, value) and not isinstance(value, type(old_value)):
            raise InputError(
                f"{scenario.name}: found {value!r} as {name}, expected a {type(old_value).__name__}"
            )
    scenario = dataclasses.replace(scenario, **field_values)
    scenario = _with_values(scenario, numbers)
    if "requirements" in changes:
        scenario = with_requirements(scenario, changes["requirements"])
    keys = [key for key in scenario.dispersed if key not in scenario.values]
    if keys:
        raise InputError(
            f"{scenario.name}: found a dispersion of {keys[0]}, a key of the replaced component, "
            "expected dispersions of the keys of the new one, or dispersions=() for none"
        )
    with placed(scenario.name):
        scenario = validated(with_packages(scenario))
    require_same_traces(scenario, live)
    return scenario


def _with_component(
    scenario: Scenario, section: str, choice: Any, changes: Mapping[str, Any], live: dict[str, Any]
) -> Scenario:
    """Scenario with another component in a section; an object is added to `live` by its kind.

    The values of an object are its own. Those of a kind are in the changes, or its defaults.
    """
    sources, values = scenario.sources, None
    if isinstance(choice, str):
        if choice not in KINDS[section] and not (is_user_kind(choice) and section in USER_KINDS):
            raise Table(Path(scenario.name), "", {}).refuse(
                section, choice, f"one of {', '.join(KINDS[section])}, or an object of your class"
            )
        kind = choice
    else:
        if section not in USER_KINDS:
            raise InputError(
                f"{scenario.name}: found {type(choice).__name__} as {section}, expected one of "
                f"{', '.join(KINDS[section])}"
            )
        kind, files, values, live_object = user_object(section, choice)
        live[kind] = live_object
        sources = joined_sources(scenario.name, _other_sources(scenario, section), files)
    component_kind = component(section, kind, sources)
    if values is None:
        table = Table(Path(scenario.name), f"{section}.", options_of(changes, section))
        defaults = component_kind.defaults(scenario.values, scenario.command_delay)
        values = table.with_missing(defaults).numbers(component_kind.keys(), "")
    lists = tuple(f"{part.section}.{part.name}." for part in scenario.parts)
    other_values = {
        key: value
        for key, value in scenario.values.items()
        if not key.startswith(f"{section}.") or key.startswith(lists)
    }
    new_values = {f"{section}.{name}": value for name, value in values.items()}
    return dataclasses.replace(
        scenario,
        **{section: kind},
        sources=sources,
        values=dict(sorted({**other_values, **new_values}.items())),
    )


def _with_list(scenario: Scenario, argument: str, parts: Any, live: dict[str, Any]) -> Scenario:
    """Scenario with another list of user-defined parts, added to `live` by their kinds."""
    objects = user_list(scenario, argument, parts)
    sources = _other_sources(scenario, LISTS[argument])
    for part in objects.values():
        sources = joined_sources(scenario.name, sources, part.sources)
        live[part.kind] = part.live
    return with_list(dataclasses.replace(scenario, sources=sources), argument, objects)


def _other_sources(scenario: Scenario, section: str) -> tuple[Source, ...]:
    """Files of a scenario, if user-defined parts of other sections need them."""
    kinds = [entry.kind for entry in named_components(scenario) if entry.section != section]
    return scenario.sources if any(map(is_user_kind, [*kinds, scenario.friction])) else ()


def _with_values(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    """Scenario with other values of its keys."""
    if not changes:
        return scenario
    entries, values = numbers_of(scenario), dict(scenario.values)
    table = Table(Path(scenario.name), "", {})
    for key, value in changes.items():
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
