"""Components that a scenario file can name, and the resulting keys of the scenario."""

from collections.abc import Iterable, Mapping
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.user_modules import is_own
from gyrostat.scenario.kinds.actuators import ACTUATORS
from gyrostat.scenario.kinds.appendages import APPENDAGES
from gyrostat.scenario.kinds.array_controllers import ARRAY_CONTROLLERS, BANDS
from gyrostat.scenario.kinds.compensators import COMPENSATORS
from gyrostat.scenario.kinds.components import (
    ESTIMATOR_OF,
    ESTIMATORS,
    SENSORS,
    Component,
)
from gyrostat.scenario.kinds.controllers import CONTROLLERS
from gyrostat.scenario.kinds.environments import EITHER_ORBIT, ENVIRONMENTS, TORQUES
from gyrostat.scenario.kinds.events import EVENTS
from gyrostat.scenario.kinds.magnetic_controllers import MAGNETIC_CONTROLLERS, UNLOADINGS
from gyrostat.scenario.kinds.orbits import ORBITS
from gyrostat.scenario.kinds.references import ERROR, MODES, POSITION_ERROR, REFERENCES, SLEWS
from gyrostat.scenario.kinds.sensors import FURTHER_SENSORS, HEADS
from gyrostat.scenario.kinds.two_wheel_controllers import TWO_WHEEL_CONTROLLERS
from gyrostat.scenario.kinds.wheel_disturbances import HARMONICS
from gyrostat.scenario.kinds.wheel_keys import WHEEL_ALL
from gyrostat.scenario.metrics.kinds import METRICS, WINDOW
from gyrostat.scenario.scenario import INERTIA, Components, Part, Scenario, Source
from gyrostat.scenario.schema import (
    BODY,
    EVENT_TIME,
    GYROLESS,
    RUN,
    START,
    Key,
    Measured,
    friction_keys,
    guard_keys,
    measured_by,
)
from gyrostat.scenario.schema import INERTIA as INERTIA_KEY
from gyrostat.scenario.user.parts import own_component
from gyrostat.wheel.friction import WHEEL_FRICTION
from gyrostat.wheel.friction_laws import law_of

KINDS: Mapping[str, Mapping[str, Component]] = {
    "controller": {
        **CONTROLLERS,
        **ARRAY_CONTROLLERS,
        **TWO_WHEEL_CONTROLLERS,
        **MAGNETIC_CONTROLLERS,
    },
    "compensator": COMPENSATORS,
    "unloading": UNLOADINGS,
    "sensors": SENSORS,
    "estimator": ESTIMATORS,
    "orbit": ORBITS,
    "environment": ENVIRONMENTS,
    "reference": REFERENCES,
}
"""Section of a scenario file -> components of this package that its `kind` can name."""
NEEDS = {
    "orbit": "a section [orbit]",
    "gyro": "sensors with a gyro",
    "surfaces": "[box], [[panel]] or [[facet]] in the spacecraft file",
    "magnetometer": "a [[sensor]] named magnetometer",
    "sun_sensor": "a [[sensor]] named sun_sensor or coarse_sun_sensors",
    "paddle": "the controller two_wheels_paddle",
    "paddle_angle": "a [[sensor]] named paddle_angle",
    "torque_rods": "an [[actuator]] named torque_rods",
    "thrusters": "an [[actuator]] named thrusters",
}
"""What a component can need -> where a scenario has it."""
PARTS: Mapping[str, Mapping[str, Component]] = {
    "controller.band": BANDS,
    "environment.torque": TORQUES,
    "reference.mode": MODES,
    "reference.slew": SLEWS,
    "imbalance.harmonic": HARMONICS,
    "star_tracker": HEADS,
    "sensor": FURTHER_SENSORS,
    "actuator": ACTUATORS,
    "metric": {},
}
"""List of tables of a scenario file, such as [[sensor]] -> components of this package."""
OF_SPACECRAFT: Mapping[str, Mapping[str, Component]] = {
    kind: {kind: made} for kind, made in APPENDAGES.items()
}
"""List of tables of a spacecraft file, such as [[slosh]] -> components of this package."""


def component(section: str, kind: str, sources: tuple[Source, ...] = ()) -> Any:
    """Component of a section by its kind.

    Args:
        section: Key of `KINDS`, `PARTS` or `OF_SPACECRAFT`, or of
            `gyrostat.scenario.user.parts.OWN`.
        kind: Name of a component of this package, or "FILE.py:NAME" for a class or function of a
            user's Python file.
        sources: Python files of the scenario.

    Raises:
        InputError: The file has no such class or function, or it cannot be used in this section.
    """
    if is_own(kind):
        return own_component(section, kind, sources)
    return (KINDS.get(section) or PARTS.get(section) or OF_SPACECRAFT[section])[kind]


def chosen(scenario: Components, section: str) -> Any:
    """Component that a scenario names in a section, a key of `KINDS`."""
    return component(section, getattr(scenario, section), scenario.sources)


def components_of(scenario: Components) -> dict[str, str]:
    """Section -> kind of its component, of all components that a scenario names."""
    found = {section: getattr(scenario, section) for section in KINDS}
    found |= {f"{part.section}.{part.name}": part.kind for part in scenario.parts}
    return found | {f"event.{e.name}": e.kind for e in scenario.events if is_own(e.kind)}


def fitting_estimator(kinds: Mapping[str, str]) -> str:
    """Estimator that a scenario should have: its own one if that fits the sensors.

    A user-defined estimator fits all sensors, and a user-defined controller can do without one.

    Args:
        kinds: Section -> kind.
    """
    given = kinds["estimator"]
    alone = given == "none" and is_own(kinds["controller"])
    return given if is_own(given) or alone else ESTIMATOR_OF[kinds["sensors"]]


def check_needs(scenario: Scenario) -> None:
    """Check that a scenario has what its components need.

    Raises:
        InputError: A component needs an orbit or surfaces that the scenario does not have, or has
            an orbit of its own beside that of the scenario.
    """
    named = {(part.section, part.name) for part in scenario.parts}
    lacks = {
        "orbit": scenario.orbit == "none",
        "gyro": scenario.sensors == GYROLESS,
        "surfaces": not scenario.surfaces,
        "magnetometer": ("sensor", "magnetometer") not in named,
        "sun_sensor": not named & {("sensor", "sun_sensor"), ("sensor", "coarse_sun_sensors")},
        "paddle": scenario.controller != "two_wheels_paddle",
        "paddle_angle": ("sensor", "paddle_angle") not in named,
        "torque_rods": ("actuator", "torque_rods") not in named,
        "thrusters": ("actuator", "thrusters") not in named,
    }
    heads = any(part.section == "star_tracker" for part in scenario.parts)
    if heads and scenario.sensors not in (GYROLESS, "star_tracker_gyro"):
        raise InputError(
            f"key sensors.kind: found {scenario.sensors} with [[star_tracker]], expected "
            f"star_tracker_gyro or {GYROLESS}"
        )
    for name, section in (("static_imbalance", "imbalance"), ("motor_constant", "driver")):
        if not lacks["paddle"] and f"wheel.{scenario.wheels[0]}.{name}" in scenario.values:
            raise InputError(
                f"key controller.kind: found {scenario.controller} with [{section}], expected none"
            )
    if scenario.environment == "orbit" and not lacks["orbit"]:
        raise InputError(
            "key environment.kind: found orbit beside [orbit], expected constant, with further "
            "torques such as gravity_gradient in [[environment.torque]]"
        )
    _check_null_space(scenario)
    parts = {f"{part.section}.{part.name}": part.section for part in scenario.parts}
    for place, kind in components_of(scenario).items():
        section = parts.get(place, place if place in KINDS else "event")
        made = component(section, kind, scenario.sources)
        for need in made.needs:
            if lacks[need]:
                raise InputError(
                    f"key {place}: found {kind} without {need}, expected {NEEDS[need]}"
                )
        if made.keys.get("altitude") is EITHER_ORBIT["altitude"]:
            _check_altitude(f"{place}.altitude", scenario)


def _check_null_space(scenario: Scenario) -> None:
    """Check bands, and that a controller with bands or wear of the wheels has a null space."""
    bands = [part.name for part in scenario.parts if part.section == "controller.band"]
    worn = f"wheel.{scenario.wheels[0]}.wear" in scenario.values
    if not bands and not worn:
        return
    place = "controller.band" if bands else "wear"
    if "null_space_gain" not in chosen(scenario, "controller").keys:
        raise InputError(
            f"key {place}: found it with the controller {scenario.controller}, expected a "
            "wheel_array, which has a null-space control"
        )
    if len(scenario.wheels) < 4:
        raise InputError(
            f"key {place}: found {len(scenario.wheels)} wheels, which have no null space, expected "
            "four or more"
        )
    for name in bands:
        low, high = (scenario.values[f"{place}.{name}.{end}"] for end in ("above", "below"))
        if low >= high:
            raise InputError(
                f"key {place}[{name}].below: found {high:g} rad/s, expected more than above, "
                f"{low:g} rad/s"
            )


def _check_altitude(key: str, scenario: Scenario) -> None:
    """Check that a component has either an orbit of its own or that of the scenario."""
    altitude = scenario.values[key]
    if scenario.orbit == "none" and altitude == 0.0:
        raise InputError(f"key {key}: found none, expected it, or a section [orbit]")
    if scenario.orbit != "none" and altitude != 0.0:
        raise InputError(f"key {key}: found {altitude:g} m beside [orbit], expected none")


def is_shipped(scenario: Components) -> bool:
    """Whether all components of a scenario are of this package.

    The digest of this package identifies their code. Others may change, and are always traced.
    """
    if scenario.sources:
        return False
    parts = [chosen(scenario, section) for section in KINDS]
    parts += [component(part.section, part.kind) for part in scenario.parts]
    code = [
        getattr(part, name) for part in parts for name in ("make", "plan") if hasattr(part, name)
    ]
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
    found = measured_by(sensors)
    for part in parts:
        if part.section == "sensor":
            unit = component(part.section, part.kind, sources).unit
            found[part.name] = (unit, "1/s" if unit == "1" else f"{unit}/s")
    return found


def own_event_keys(kind: str, sources: tuple[Source, ...]) -> dict[str, Key]:
    """Keys of a user-defined event.

    Args:
        kind: Kind of the event.
        sources: Python files of the scenario.
    """
    return {**component("event", kind, sources).keys, "time": EVENT_TIME}


def _has_body(scenario: Scenario, name: str) -> bool:
    return any(key.startswith(f"body.{name}") for key in scenario.values)


def numbers_of(scenario: Scenario) -> dict[str, Key]:
    """Full key -> schema entry, for every number of a scenario with these components."""
    friction = law_of(scenario.friction, scenario.sources)
    fields = measured(scenario.sensors, scenario.parts, scenario.sources)
    sections: dict[str, Mapping[str, Key]] = {
        "body.inertia": dict.fromkeys(INERTIA, INERTIA_KEY),
        "body": {name: key for name, key in BODY.items() if _has_body(scenario, name)},
        **{f"wheel.{w}": {**friction_keys(friction), **WHEEL_ALL} for w in scenario.wheels},
        **{"run": RUN, "start": START, "metrics": METRICS},
        "guard": guard_keys(fields),
        **{f"window.{window.name}": WINDOW for window in scenario.windows},
        **{section: chosen(scenario, section).keys for section in KINDS},
        **{
            f"{part.section}.{part.name}": component(part.section, part.kind, scenario.sources).keys
            for part in scenario.parts
        },
        **{
            f"event.{e.name}": own_event_keys(e.kind, scenario.sources)
            if is_own(e.kind)
            else EVENTS[e.kind].keys_of(friction, e.sensor, fields)
            for e in scenario.events
        },
    }
    if f"{POSITION_ERROR}.x" in scenario.values:
        sections["reference"] = {**sections["reference"], "position_error": ERROR}
    return {
        end: entry
        for section, keys in sections.items()
        for name, entry in keys.items()
        for end in entry.ends(f"{section}.{name}")
    }
