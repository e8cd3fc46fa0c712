"""Structure of a scenario: what determines its program."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import inf, isfinite
from typing import Any

from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.kinds.registry import KINDS
from gyrostat.scenario.requirement import ErrorSignal, signals_of
from gyrostat.scenario.scenario import Components, Event, Scenario

VIEW = {"reference.mode": "until", "reference.transition": "when"}
"""Section of parts that can wait for a view along the orbit -> key of the view."""


@dataclass(frozen=True, kw_only=True)
class Structure(Components):
    """Part of a scenario that determines its program; all other numbers are data of the program.

    The functions that build and trace a run get this part only, so that a program cannot depend on
    anything else. Its events have no targets.

    Attributes:
        turning_points: Slews and wheel failures, in the nominal order of their notification.
        keys: Keys of all values.
        dispersed: Keys whose values differ from run to run.
        limited: Measured fields whose rate of change is limited.
        signals: Error vectors that pointing requirements need; their numbers are not part of it.
        waits_for_view: Whether a mode of the reference ends with an eclipse or with a pass.
    """

    turning_points: tuple[Event, ...]
    keys: tuple[str, ...]
    dispersed: tuple[str, ...]
    limited: tuple[str, ...]
    signals: tuple[ErrorSignal, ...]
    waits_for_view: bool


def structure_of(scenario: Scenario) -> Structure:
    """Structure of a scenario."""
    common = {field.name: getattr(scenario, field.name) for field in fields(Components)}
    events = tuple(replace(event, target=None) for event in scenario.events)
    kinds = [(event, kind_of(event)) for event in events]
    turning_points = [event for event, kind in kinds if kind.changes_target or kind.loses_wheel]
    # by the nominal value, so that all runs have the same structure
    limited = [
        name
        for name in measured_names(scenario)
        if isfinite(scenario.values.get(f"guard.{name}_change", inf))
    ]
    return Structure(
        **{**common, "events": events},
        turning_points=tuple(sorted(turning_points, key=lambda e: notified(e, scenario.values))),
        keys=tuple(scenario.values),
        dispersed=scenario.dispersed,
        limited=tuple(limited),
        signals=signals_of(scenario.requirements),
        waits_for_view=any(
            scenario.values[f"{part.section}.{part.name}.{VIEW[part.section]}"] != 0.0
            for part in scenario.parts
            if part.section in VIEW
        ),
    )


def measured_names(scenario: Components) -> tuple[str, ...]:
    """Names of the measured fields whose values can have limits and faults."""
    fields = KINDS["sensors"][scenario.sensors].measured
    return (*fields, *(part.name for part in scenario.parts if part.section == "sensor"))


def notified(event: Event, values: Mapping[str, Any]) -> Any:
    """Time at which the controller is notified of an event, s."""
    prefix = f"event.{event.name}"
    return values[f"{prefix}.time"] + values.get(f"{prefix}.detected_after", 0.0)
