"""Events of a scenario file."""

from gyrostat.campaigns.controllers import CONTROLLERS, NOTIFIED
from gyrostat.campaigns.scenario import AXES, Event
from gyrostat.campaigns.schema import EVENTS, MEASURED, SENSOR_FAULT, friction_keys, spike
from gyrostat.campaigns.tables import Table, one_of
from gyrostat.core.errors import InputError
from gyrostat.spacecraft import SpacecraftFile


def within_run(table: Table, key: str, time: float, values: dict[str, float]) -> None:
    """Refuse a time, s, that a run does not reach."""
    if time >= values["run.duration"]:
        raise table.refuse(
            key, time, f"a time before the end of the run, {values['run.duration']:g} s"
        )


def read_events(
    top: Table, craft: SpacecraftFile, values: dict[str, float], controller: str
) -> list[Event]:
    """The events of a scenario file; their numbers join its values.

    Args:
        top: Of the file.
        craft: Of the scenario.
        values: Full key -> number, SI; those of the events are added.
        controller: Name of its kind.

    Raises:
        InputError: a key is unknown, missing or has a value that makes no sense.
    """
    found, befallen = [], set()
    for number, row in enumerate(top.tables("event")):
        name = row.name("name", str(number + 1))
        if name in {event.name for event in found} or "." in name or not name:
            raise InputError(
                f"{top.path}: key event[{number}].name: found {name!r}, expected a name of its own "
                "without a dot"
            )
        row = Table(top.path, f"event[{name}].", row.row)
        kind = one_of(row, "", "kind", EVENTS, None)
        if kind.startswith(SENSOR_FAULT):
            found.append(_sensor_fault(row, kind, name, craft, values))
            continue
        keys = EVENTS[kind][1]
        own = "target" if kind == "slew" else "wheel"
        if "detected_after" in keys and CONTROLLERS[controller].losses != NOTIFIED:
            if "detected_after" in row.row:
                raise row.refuse(
                    "detected_after",
                    row.row["detected_after"],
                    f"none: nobody tells the controller {controller} of a lost wheel",
                )
            keys = {name: entry for name, entry in keys.items() if name != "detected_after"}
        friction = {}
        if kind == "friction_step":
            friction = friction_keys(craft.spacecraft.wheels.friction.dimensions())
        row.known(("name", "kind", own, *keys, *friction))
        given = {name: entry for name, entry in friction.items() if name in row.row}
        if friction and not given and "factor" not in row.row:
            raise InputError(
                f"{top.path}: key {row.prefix}factor: found none, expected one, or values of "
                f"{', '.join(friction)}"
            )
        numbers = row.numbers({**keys, **given})
        values |= {f"event.{name}.{k.rsplit('.', 1)[-1]}": v for k, v in numbers.items()}
        within_run(row, "time", values[f"event.{name}.time"], values)
        if kind == "slew":
            found.append(Event(name, kind, target=row.unit("target", 4, None)))
            continue
        wheel = craft.wheel_number(row.text("wheel", None), f"{top.path}: key {row.prefix}wheel")
        if (wheel, kind == "friction_step") in befallen:
            raise InputError(
                f"{top.path}: key {row.prefix}wheel: found {craft.wheel_names[wheel]}, which "
                "another event befalls, expected one failure and one friction step a wheel"
            )
        befallen.add((wheel, kind == "friction_step"))
        found.append(Event(name, kind, wheel=wheel))
    return found


def _sensor_fault(
    row: Table, kind: str, name: str, craft: SpacecraftFile, values: dict[str, float]
) -> Event:
    """A fault of a measured field, or of one of its elements."""
    sensor = one_of(row, "", "sensor", MEASURED, None)
    own = {"rate": ("axis",), "wheel_speed": ("wheel",)}.get(sensor, ())
    keys = {**EVENTS[kind][1], **(spike(sensor) if kind == "sensor_spike" else {})}
    row.known(("name", "kind", "sensor", *own, *keys))
    numbers = row.numbers(keys)
    values |= {f"event.{name}.{k.rsplit('.', 1)[-1]}": v for k, v in numbers.items()}
    start, end = (values[f"event.{name}.{key}"] for key in ("time", "until"))
    within_run(row, "time", start, values)
    if end <= start:
        raise row.refuse("until", end, f"a time after its start, {start:g} s")
    element = None
    if "axis" in row.row:
        element = AXES.index(one_of(row, "", "axis", dict.fromkeys(AXES), None))
    elif "wheel" in row.row:
        where = f"{row.path}: key {row.prefix}wheel"
        element = craft.wheel_number(row.text("wheel", None), where)
    return Event(name, kind, sensor=sensor, element=element)
