"""Structure of a scenario: what determines its program."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import inf, isfinite
from typing import Any

from gyrostat.campaigns.requirement import ErrorSignal, signals_of
from gyrostat.campaigns.scenario import Event, Part, Scenario, Source, Window
from gyrostat.campaigns.schema import WHEEL_IS_LOST, measured_by


@dataclass(frozen=True)
class Structure:
    """Part of a scenario that determines its program; all other numbers are data of the program.

    The functions that build and trace a run get this part only, so that a program cannot depend on
    anything else.

    Attributes:
        wheels: See `Scenario`; also the following attributes up to `budget`.
        events: Events in their nominal order of time, without targets.
        turning_points: Slews and wheel failures, in the nominal order of their notification.
        keys: Keys of all values.
        dispersed: Keys whose values differ from run to run.
        limited: Measured fields whose rate of change is limited.
        signals: Error vectors that pointing requirements need; their numbers are not part of it.
    """

    wheels: tuple[str, ...]
    axes: tuple[tuple[float, ...], ...]
    friction: str
    controller: str
    compensator: str
    sensors: str
    estimator: str
    environment: str
    boresight: tuple[float, ...] | None
    count: int
    substeps: int
    command_delay: int
    guard: str | None
    reference: str
    parts: tuple[Part, ...]
    sources: tuple[Source, ...]
    windows: tuple[Window, ...]
    orbit: str
    unloading: str
    surfaces: tuple[tuple[float, ...], ...]
    budget: bool
    events: tuple[Event, ...]
    turning_points: tuple[Event, ...]
    keys: tuple[str, ...]
    dispersed: tuple[str, ...]
    limited: tuple[str, ...]
    signals: tuple[ErrorSignal, ...]


def structure_of(scenario: Scenario) -> Structure:
    """Structure of a scenario."""
    same = {field.name: getattr(scenario, field.name, None) for field in fields(Structure)}
    events = tuple(replace(event, target=None) for event in scenario.events)
    turning = [e for e in events if e.kind == "slew" or e.kind in WHEEL_IS_LOST]
    own = {
        "events": events,
        "turning_points": tuple(sorted(turning, key=lambda e: notified(e, scenario.values))),
        "keys": tuple(scenario.values),
        "signals": signals_of(scenario.requirements),
        # by the nominal value, so that all runs have the same structure
        "limited": tuple(
            name
            for name in measured_names(scenario)
            if isfinite(scenario.values.get(f"guard.{name}_change", inf))
        ),
    }
    return Structure(**{**same, **own})


def measured_names(scenario: Scenario | Structure) -> tuple[str, ...]:
    """Names of the measured fields whose values can have limits and faults."""
    own = measured_by(scenario.sensors)
    return (*own, *(part.name for part in scenario.parts if part.section == "sensor"))


def notified(event: Event, values: Mapping[str, Any]) -> Any:
    """Time at which the controller is notified of an event, s."""
    own = f"event.{event.name}"
    return values[f"{own}.time"] + values.get(f"{own}.detected_after", 0.0)
