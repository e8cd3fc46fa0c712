"""Lists of user-defined parts of a scenario from Python objects."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.user_modules import is_user_kind
from gyrostat.scenario.kinds.registry import KINDS, measured
from gyrostat.scenario.scenario import Event, Part, Scenario
from gyrostat.scenario.schema import EVENT_TIME, guard_keys
from gyrostat.scenario_files.python.objects import UserObject, user_object
from gyrostat.scenario_files.read_parts import part_name
from gyrostat.scenario_files.tables import Table

LISTS = {
    "environment": "environment.torque",
    "sensor": "sensor",
    "actuator": "actuator",
    "metric": "metric",
    "event": "event",
}
"""Argument of `Scenario.replace` -> section of the parts."""


def is_list(argument: str, given: object) -> bool:
    """Whether an argument of `Scenario.replace` is a list of parts; `environment` can be a kind."""
    return argument in LISTS and not (argument == "environment" and isinstance(given, str))


def user_list(scenario: Scenario, argument: str, given: Any) -> dict[str, UserObject]:
    """Own parts from objects, by name.

    Args:
        scenario: Scenario, for messages.
        argument: Key of `LISTS`.
        given: Objects in a tuple or list, or name -> object; of events, name -> (time, s, object).

    Raises:
        InputError: It is something else, or an object cannot be used.
    """
    section = LISTS[argument]
    if isinstance(given, tuple | list) and argument != "event":
        rows: list[tuple[dict[str, Any], Any]] = [({}, part) for part in given]
    elif isinstance(given, Mapping):
        rows = [({"name": name}, part) for name, part in given.items()]
    else:
        kind = type(given).__name__
        forms = '{"name": (time, object)}' if argument == "event" else f"a tuple, ({kind}(...),)"
        kinds = f", or one of {', '.join(KINDS[argument])}" if argument in KINDS else ""
        raise InputError(f"{scenario.name}: {argument}: found {kind}, expected {forms}{kinds}")
    objects: dict[str, UserObject] = {}
    for number, (row, part) in enumerate(rows):
        table = Table(Path(scenario.name), f"{section}[{number}].", row)
        time: dict[str, float] = {}
        if argument == "event":
            if not isinstance(part, tuple) or len(part) != 2:
                raise table.refuse("time", part, "(time, object)")
            time["time"] = table.allowed("time", part[0], EVENT_TIME)
            part = part[1]
        entry = user_object(section, part)
        name = part_name(section, table, entry.kind, objects)
        objects[name] = entry._replace(values={**entry.values, **time})
    return objects


def with_list(scenario: Scenario, argument: str, found: Mapping[str, UserObject]) -> Scenario:
    """Scenario with another list of user-defined parts, which replaces all parts of this section.

    Events of this package stay.

    Args:
        scenario: Scenario whose sources have the files of the parts.
        argument: Key of `LISTS`.
        found: Own parts by name.
    """
    section = LISTS[argument]
    names = [part.name for part in scenario.parts if part.section == section]
    if argument == "event":
        names = [event.name for event in scenario.events if is_user_kind(event.kind)]
    starts = tuple(f"{section}.{name}." for name in names)
    ends = ("lower", "upper", "change")
    starts += tuple(f"guard.{name}_{end}" for name in names for end in ends if section == "sensor")
    values = {key: value for key, value in scenario.values.items() if not key.startswith(starts)}
    new = tuple(Part(section, name, part.kind) for name, part in found.items())
    for name, part in found.items():
        values |= {f"{section}.{name}.{key}": value for key, value in part.values.items()}
    if section == "sensor" and scenario.guard is not None:
        limits = guard_keys(measured(scenario.sensors, new, scenario.sources))
        defaults = Table(Path(scenario.name), "guard.", {}).numbers(limits)
        values = {**defaults, **values}
    values = dict(sorted(values.items()))
    if argument == "event":
        events = [event for event in scenario.events if not is_user_kind(event.kind)]
        for name, part in found.items():
            if name in [event.name for event in events]:
                raise InputError(
                    f"{scenario.name}: event: found {name}, the name of another event, "
                    "expected another name"
                )
            events.append(Event(name, part.kind))
        events.sort(key=lambda event: values[f"event.{event.name}.time"])
        return dataclasses.replace(scenario, events=tuple(events), values=values)
    parts = tuple(part for part in scenario.parts if part.section != section)
    return dataclasses.replace(scenario, parts=(*parts, *new), values=values)
