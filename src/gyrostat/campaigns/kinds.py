"""Components that a scenario file can name, and the resulting keys of the scenario."""

from collections.abc import Mapping

from gyrostat.campaigns.components import (
    COMPENSATORS,
    ENVIRONMENTS,
    ESTIMATORS,
    SENSORS,
    Component,
)
from gyrostat.campaigns.controllers import CONTROLLERS
from gyrostat.campaigns.scenario import INERTIA, Scenario
from gyrostat.campaigns.schema import (
    GUARD,
    METRICS,
    RUN,
    START,
    WHEEL_ALL,
    WINDOW,
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
"""Section of a scenario file -> components that its `kind` can name."""


def is_shipped(scenario: Scenario | Structure) -> bool:
    """Whether all components of a scenario are of this package.

    The digest of this package identifies their code. Others may change, and are always traced.
    """
    parts = [kinds[getattr(scenario, section)] for section, kinds in KINDS.items()]
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
        **{section: kinds[getattr(scenario, section)].keys for section, kinds in KINDS.items()},
        **{f"window.{window.name}": WINDOW for window in scenario.windows},
        **{f"event.{e.name}": event_keys(e.kind, e.sensor, friction) for e in scenario.events},
    }
    return {
        end: entry
        for section, keys in sections.items()
        for name, entry in keys.items()
        for end in entry.ends(f"{section}.{name}")
    }
