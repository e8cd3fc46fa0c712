"""Read [[event]] tables of a scenario file."""

from collections.abc import Mapping
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.scenario.controller_kind import NOTIFIED
from gyrostat.scenario.event_kind import FrictionChange
from gyrostat.scenario.kinds.events import EVENTS, kind_of
from gyrostat.scenario.kinds.registry import user_event_keys
from gyrostat.scenario.scenario import AXES, Event, Source
from gyrostat.scenario.schema import Measured
from gyrostat.scenario_files.read_user_parts import USER_KEYS, user_kind
from gyrostat.scenario_files.tables import Table
from gyrostat.spacecraft import SpacecraftFile


def read_events(
    top: Table,
    craft: SpacecraftFile,
    values: dict[str, float],
    controller: Any,
    fields: Mapping[str, Measured],
    sources: tuple[Source, ...],
) -> list[Event]:
    """Read the events of a scenario file and add their numbers to its values.

    Args:
        top: Top-level table of the file.
        craft: Spacecraft of the scenario.
        values: Full key -> number, SI; the numbers of the events are added.
        controller: Kind of the controller of the scenario.
        fields: Measured fields, see `gyrostat.scenario.kinds.registry.measured`.
        sources: Python files of the scenario.

    Raises:
        InputError: A key is unknown, missing or has a value that is not allowed.
    """
    events: list[Event] = []
    for number, row in enumerate(top.tables("event")):
        name = row.unique_name(str(number + 1), [event.name for event in events])
        row = Table(top.path, f"event[{name}].", row.row)
        if "python" in row.row:
            events.append(_user_event(row, name, values, sources))
            continue
        event = _event(row, name, craft, values, controller, fields)
        if event.wheel is not None and any(_affects(event) == _affects(other) for other in events):
            raise InputError(
                f"{row.place('wheel')}: found {craft.wheel_names[event.wheel]}, which another "
                "event affects, expected one failure and one friction step per wheel"
            )
        events.append(event)
    return events


def _user_event(
    row: Table, name: str, values: dict[str, float], sources: tuple[Source, ...]
) -> Event:
    event = Event(name, user_kind(row))
    keys = user_event_keys(event.kind, sources)
    row.known(("name", *USER_KEYS, *keys))
    values |= row.numbers(keys, f"event.{name}.")
    return event


def _affects(event: Event) -> tuple[int | None, bool]:
    """Wheel that an event affects, and whether by its friction."""
    return event.wheel, issubclass(kind_of(event), FrictionChange)


def _event(
    row: Table,
    name: str,
    craft: SpacecraftFile,
    values: dict[str, float],
    controller: Any,
    fields: Mapping[str, Measured],
) -> Event:
    kind = EVENTS[row.one_of("kind", EVENTS)]
    suited = [name for name, field in fields.items() if kind.suits(field)]
    sensor = row.one_of("sensor", suited) if kind.affects == "sensor" else None
    keys_of_kind = (kind.affects,)
    if sensor is not None:
        keys_of_kind = ("sensor", *{"rate": ("axis",), "wheel_speed": ("wheel",)}.get(sensor, ()))
    law = type(craft.spacecraft.wheels.friction)
    keys = kind.keys_of(law, sensor, fields)
    if "detected_after" in keys and controller.losses != NOTIFIED:
        if "detected_after" in row.row:
            raise row.refuse(
                "detected_after",
                row.row["detected_after"],
                "none: this controller is not notified of failures",
            )
        del keys["detected_after"]
    row.known(("name", "kind", *keys_of_kind, *keys))
    missing = kind.missing(row.row, law)
    if missing is not None:
        raise InputError(f"{row.place(missing[0])}: found none, expected {missing[1]}")
    optional = kind.optional(law)
    keys = {key: entry for key, entry in keys.items() if key in row.row or key not in optional}
    values |= row.numbers(keys, f"event.{name}.")
    target = row.unit("target", 4, None) if "target" in keys_of_kind else None
    wheel = element = None
    if "wheel" in keys_of_kind and (sensor is None or "wheel" in row.row):
        wheel = craft.wheel_number(row.text("wheel", None), row.place("wheel"))
    elif "axis" in row.row:
        element = AXES.index(row.one_of("axis", AXES))
    if sensor is not None:
        return Event(name, kind.name, sensor=sensor, element=element if wheel is None else wheel)
    return Event(name, kind.name, wheel=wheel, target=target)
