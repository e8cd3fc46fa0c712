"""Components that a scenario file can name, and the resulting keys of the scenario."""

from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple

from gyrostat.core.classes_of import classes_of
from gyrostat.core.errors import InputError
from gyrostat.core.user_modules import is_user_kind
from gyrostat.scenario.appendage_kind import AppendageKind
from gyrostat.scenario.component import NULL_SPACE, SURFACES, Kind
from gyrostat.scenario.kinds.events import EVENTS
from gyrostat.scenario.kinds.wheel_keys import WHEEL_ALL
from gyrostat.scenario.metrics.kinds import WINDOW, keys_of_run
from gyrostat.scenario.mode_kind import Mode
from gyrostat.scenario.reference_kind import ERROR, POSITION_ERROR, ProfileKind
from gyrostat.scenario.scenario import INERTIA, Components, Part, Scenario, Source
from gyrostat.scenario.schema import (
    BODY,
    EVENT_TIME,
    MEASURED,
    RUN,
    START,
    Key,
    Measured,
    friction_keys,
    guard_keys,
)
from gyrostat.scenario.schema import INERTIA as INERTIA_KEY
from gyrostat.scenario.transition_kind import Transition
from gyrostat.scenario.user.kinds import user_component
from gyrostat.wheel.friction import WHEEL_FRICTION
from gyrostat.wheel.friction_laws import law_of


def _kinds_of(section: str) -> dict[str, type[Kind]]:
    """Name -> class in the folder of a section."""
    folder = import_module(f"gyrostat.scenario.kinds.{section.replace('.', '_')}")
    kinds = {kind.name: kind for kind in classes_of(folder, Kind)}
    return {name: kinds[name] for name in sorted(kinds, key=lambda name: (name != "none", name))}


KINDS: Mapping[str, dict[str, Any]] = {
    section: _kinds_of(section)
    for section in (
        *("controller", "compensator", "unloading", "sensors"),
        *("estimator", "orbit", "environment", "reference"),
    )
}
"""Section of a scenario file -> kinds of this package that it can name."""
PARTS: Mapping[str, dict[str, Any]] = {
    **{
        section: _kinds_of(section)
        for section in (
            *("station", "keep_out"),
            *("controller.band", "controller.plan", "environment.torque"),
        )
    },
    "reference.mode": {
        name: Mode(kind)
        for name, kind in {**KINDS["reference"], **_kinds_of("reference.mode")}.items()
        if issubclass(kind, ProfileKind)
    },
    "reference.transition": {
        Transition.name: Transition(),
        **{name: Transition(kind) for name, kind in _kinds_of("reference.transition").items()},
    },
    "controller.law": KINDS["controller"],
    **{
        section: _kinds_of(section)
        for section in (
            *("reference.slew", "imbalance.harmonic"),
            *("star_tracker", "sensor", "actuator"),
        )
    },
    "metric": _kinds_of("metric"),
}
"""List of tables of a scenario file, such as [[sensor]] -> kinds of this package."""
APPENDAGES: Mapping[str, type[AppendageKind]] = {
    kind.name: kind
    for kind in classes_of(import_module("gyrostat.scenario.kinds.appendage"), AppendageKind)
}
"""List of tables of a spacecraft file, such as [[slosh]] -> its kind."""


def component(section: str, kind: str, sources: tuple[Source, ...] = ()) -> Any:
    """Component of a section by its kind.

    Args:
        section: Key of `KINDS`, `PARTS` or `APPENDAGES`, or of
            `gyrostat.scenario.user.kinds.USER_KINDS`.
        kind: Name of a component of this package, or "FILE.py:NAME" for a class or function of a
            user's Python file.
        sources: Python files of the scenario.

    Raises:
        InputError: The file has no such class or function, or it cannot be used in this section.
    """
    if is_user_kind(kind):
        return user_component(section, kind, sources)
    if section in APPENDAGES:
        return APPENDAGES[section]
    return (KINDS.get(section) or PARTS[section])[kind]


def chosen(scenario: Components, section: str) -> Any:
    """Component that a scenario names in a section, a key of `KINDS`."""
    return component(section, getattr(scenario, section), scenario.sources)


class Named(NamedTuple):
    """Component that a scenario names.

    Attributes:
        place: Its place, such as "controller" or "sensor.magnetometer".
        section: Its section, see `component`.
        kind: Its kind.
    """

    place: str
    section: str
    kind: str


def named_components(scenario: Components) -> Iterator[Named]:
    """All components that a scenario names, but for events of this package."""
    for section in KINDS:
        yield Named(section, section, getattr(scenario, section))
    for part in scenario.parts:
        yield Named(f"{part.section}.{part.name}", part.section, part.kind)
    for event in scenario.events:
        if is_user_kind(event.kind):
            yield Named(f"event.{event.name}", "event", event.kind)


def kinds_of(scenario: Components) -> dict[str, str]:
    """Place of each component that a scenario names -> its kind."""
    return {named.place: named.kind for named in named_components(scenario)}


def fitting_estimator(kinds: Mapping[str, str]) -> str:
    """Estimator that a scenario should have: its own one if that fits the sensors.

    A user-defined estimator fits all sensors, and a user-defined controller can do without one.

    Args:
        kinds: Section -> kind.
    """
    kind = kinds["estimator"]
    optional = kind == "none" and is_user_kind(kinds["controller"])
    return kind if is_user_kind(kind) or optional else KINDS["sensors"][kinds["sensors"]].estimator


def check_needs(scenario: Scenario) -> None:
    """Check that a scenario has what its components need, and that they fit each other.

    Raises:
        InputError: A component needs what the scenario does not have, or has values that do not
            fit what stands beside it.
    """
    named = list(named_components(scenario))
    components = {n.place: component(n.section, n.kind, scenario.sources) for n in named}
    available = {SURFACES} if scenario.surfaces else set()
    available = available.union(*(kind.provides for kind in components.values()))
    for place, _, name in named:
        for need in sorted(components[place].needs):
            if need not in available and not need.places & components.keys():
                raise InputError(
                    f"key {place}: found {name} without {need.name}, expected {need.expected}"
                )
    for place, kind in components.items():
        kind.check(place, scenario)
    _check_null_space(scenario, components["controller"])


def _check_null_space(scenario: Scenario, controller: Any) -> None:
    """Check that a controller with bands or wear of the wheels has a null space."""
    bands = any(part.section == "controller.band" for part in scenario.parts)
    if not bands and f"wheel.{scenario.wheels[0]}.wear" not in scenario.values:
        return
    place = "controller.band" if bands else "wear"
    if NULL_SPACE not in controller.provides:
        raise InputError(
            f"key {place}: found it with the controller {scenario.controller}, expected "
            f"{NULL_SPACE.expected}"
        )
    if len(scenario.wheels) < 4:
        raise InputError(
            f"key {place}: found {len(scenario.wheels)} wheels, which have no null space, expected "
            "four or more"
        )


def is_shipped(scenario: Components) -> bool:
    """Whether all components of a scenario are of this package.

    The digest of this package identifies their code. Others may change, and are always traced.
    """
    if scenario.sources:
        return False
    code = [component(named.section, named.kind) for named in named_components(scenario)]
    code.append(WHEEL_FRICTION[scenario.friction])
    return all(getattr(each, "__module__", "").startswith("gyrostat.") for each in code)


def measured(
    sensors: str, parts: Iterable[Part], sources: tuple[Source, ...]
) -> dict[str, Measured]:
    """Measured fields -> dimension and unit of the rate of change, see `MEASURED`.

    Args:
        sensors: Kind of [sensors].
        parts: Parts of a scenario.
        sources: Python files of the scenario.
    """
    fields = {name: MEASURED[name] for name in KINDS["sensors"][sensors].measured}
    for part in parts:
        if part.section == "sensor":
            unit = component(part.section, part.kind, sources).unit
            fields[part.name] = (unit, "1/s" if unit == "1" else f"{unit}/s")
    return fields


def user_event_keys(kind: str, sources: tuple[Source, ...]) -> dict[str, Key]:
    """Keys of a user-defined event.

    Args:
        kind: Kind of the event.
        sources: Python files of the scenario.
    """
    return {**component("event", kind, sources).keys(), "time": EVENT_TIME}


def _has_body(scenario: Scenario, name: str) -> bool:
    return any(key.startswith(f"body.{name}") for key in scenario.values)


def sections_of(scenario: Scenario) -> dict[str, Mapping[str, Key]]:
    """Place of each section with numbers -> name of each number -> its schema entry."""
    friction = law_of(scenario.friction, scenario.sources)
    fields = measured(scenario.sensors, scenario.parts, scenario.sources)

    sections: dict[str, Mapping[str, Key]] = {
        "body.inertia": dict.fromkeys(INERTIA, INERTIA_KEY),
        "body": {name: key for name, key in BODY.items() if _has_body(scenario, name)},
        **{f"wheel.{w}": {**friction_keys(friction), **WHEEL_ALL} for w in scenario.wheels},
        **{"run": RUN, "start": START, "metrics": keys_of_run(scenario.parts)},
        "guard": guard_keys(fields),
        **{f"window.{window.name}": WINDOW for window in scenario.windows},
        **{
            named.place: component(named.section, named.kind, scenario.sources).keys()
            for named in named_components(scenario)
            if named.section != "event"
        },
        **{
            f"event.{e.name}": user_event_keys(e.kind, scenario.sources)
            if is_user_kind(e.kind)
            else EVENTS[e.kind].keys_of(friction, e.sensor, fields)
            for e in scenario.events
        },
    }
    if f"{POSITION_ERROR}.x" in scenario.values:
        sections["reference"] = {**sections["reference"], "position_error": ERROR}
    return sections


def numbers_of(scenario: Scenario) -> dict[str, Key]:
    """Full key -> schema entry, for every number of a scenario with these components."""
    return {
        end: entry
        for section, keys in sections_of(scenario).items()
        for name, entry in keys.items()
        for end in entry.ends(f"{section}.{name}")
    }
