"""Components that a scenario file can name, and the resulting keys of the scenario."""

from collections.abc import Mapping
from typing import Any

from gyrostat.campaigns.components import (
    COMPENSATORS,
    ENVIRONMENTS,
    ESTIMATORS,
    SENSORS,
    Component,
)
from gyrostat.campaigns.controllers import CONTROLLERS
from gyrostat.campaigns.own_parts import is_own, own_component
from gyrostat.campaigns.scenario import INERTIA, Scenario, Source
from gyrostat.campaigns.schema import (
    GUARD,
    METRICS,
    RUN,
    START,
    WHEEL_ALL,
    Key,
    event_keys,
    friction_keys,
)
from gyrostat.campaigns.schema import INERTIA as INERTIA_KEY
from gyrostat.campaigns.structure import Structure
from gyrostat.wheel.friction import FRICTION_MODELS

KINDS: Mapping[str, Mapping[str, Component]] = {
    "controller": CONTROLLERS,
    "compensator": COMPENSATORS,
    "sensors": SENSORS,
    "estimator": ESTIMATORS,
    "environment": ENVIRONMENTS,
}
"""Section of a scenario file -> components of this package that its `kind` can name."""


def component(section: str, kind: str, sources: tuple[Source, ...] = ()) -> Any:
    """Component of a section by its kind.

    Args:
        section: Key of `KINDS`, or of `gyrostat.campaigns.own_parts.OWN`.
        kind: Name of a component of this package, or "FILE.py:NAME" for a class or function of a
            user's Python file.
        sources: Python files of the scenario.

    Raises:
        InputError: The file has no such class or function, or it cannot be used in this section.
    """
    return own_component(section, kind, sources) if is_own(kind) else KINDS[section][kind]


def chosen(scenario: Scenario | Structure, section: str) -> Any:
    """Component that a scenario names in a section, a key of `KINDS`."""
    return component(section, getattr(scenario, section), scenario.sources)


def components_of(scenario: Scenario | Structure) -> dict[str, str]:
    """Section -> kind of its component, of all components that a scenario names."""
    found = {section: getattr(scenario, section) for section in KINDS}
    return found | {f"{part.section}.{part.name}": part.kind for part in scenario.parts}


def is_shipped(scenario: Scenario | Structure) -> bool:
    """Whether all components of a scenario are of this package.

    The digest of this package identifies their code. Others may change, and are always traced.
    """
    if scenario.sources:
        return False
    parts = [chosen(scenario, section) for section in KINDS]
    code = [
        getattr(part, name) for part in parts for name in ("make", "plan") if hasattr(part, name)
    ]
    code.append(FRICTION_MODELS[scenario.friction])
    return all(getattr(each, "__module__", "").startswith("gyrostat.") for each in code)


def numbers_of(scenario: Scenario) -> dict[str, Key]:
    """Full key -> schema entry, for every number of a scenario with these components."""
    friction = FRICTION_MODELS[scenario.friction].dimensions()
    sections: dict[str, Mapping[str, Key]] = {
        "body.inertia": dict.fromkeys(INERTIA, INERTIA_KEY),
        **{f"wheel.{w}": {**friction_keys(friction), **WHEEL_ALL} for w in scenario.wheels},
        **{"run": RUN, "start": START, "metrics": METRICS, "guard": GUARD},
        **{section: chosen(scenario, section).keys for section in KINDS},
        **{
            f"{part.section}.{part.name}": component(part.section, part.kind, scenario.sources).keys
            for part in scenario.parts
        },
        **{f"event.{e.name}": event_keys(e.kind, e.sensor, friction) for e in scenario.events},
    }
    return {
        end: entry
        for section, keys in sections.items()
        for name, entry in keys.items()
        for end in entry.ends(f"{section}.{name}")
    }
