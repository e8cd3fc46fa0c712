"""Build the reference attitude of a run from a scenario."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.guidance import Reference, WheelEnvelope
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.runs.build_parts import named_parts
from gyrostat.scenario.attitude_table import attitude_table
from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.kinds.references import (
    ERROR,
    LISTS,
    POSITION_ERROR,
    PlannedReference,
    ReferenceCase,
)
from gyrostat.scenario.kinds.registry import chosen
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.sensing import Values, arrays_of
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft import Spacecraft
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment


def planned_reference(
    scenario: Scenario, known: Spacecraft, working: Bool[np.ndarray, "phases wheels"]
) -> PlannedReference | None:
    """Part of the reference of a scenario that is computed once; None for fixed targets.

    Args:
        scenario: Scenario.
        known: Nominal spacecraft.
        working: Whether each wheel works in each phase of the controller.

    Raises:
        InputError: The working wheels of a phase cannot slew about every axis; the scenario has
            slews or modes that its reference does not use, or lacks those that it needs; or events
            change the target beside a reference.
    """
    kind = scenario.reference
    for owner, section in LISTS.items():
        found = [part.name for part in scenario.parts if part.section == section]
        if (kind == owner) != bool(found):
            raise InputError(
                f"key reference.kind: found {kind} {'with' if found else 'without'} tables "
                f"[[{section}]], expected {'none' if found else 'one or more'}"
            )
    if kind == "fixed":
        return None
    if kind == "table" and all(text.path != "reference" for text in scenario.texts):
        raise InputError("key reference.file: found none, expected a CSV file")
    slews = [event.name for event in scenario.events if kind_of(event).changes_target]
    if slews:
        raise InputError(
            f"key event[{slews[0]}]: found a slew beside the reference {kind}, expected none: the "
            "reference is the target"
        )
    envelope = None
    if scenario.reference in LISTS:
        starts = np.arange(float(len(working)))
        envelope = WheelEnvelope.of(known, working, starts=starts)
    tables = {
        text.path: attitude_table(text.path, text.text)
        for text in scenario.texts
        if text.path.startswith("reference")
    }
    return PlannedReference(envelope, tables)


def reference_of(
    structure: Structure,
    values: Values,
    plans: Any,
    start: Any,
    starts: Float[Array, " phases"],
    orbit: OrbitEnvironment | None,
) -> Reference | None:
    """Reference of a run; None for fixed targets.

    Args:
        structure: Structure of the scenario.
        values: Values of the run.
        plans: Plans of the scenario.
        start: State at time 0.
        starts: Start time of each phase of the controller, (phases,), s.
        orbit: Orbit of the run.
    """
    if plans.reference is None:
        return None
    kind = chosen(structure, "reference")
    own = arrays_of(values, "reference", kind.keys)
    envelope = plans.reference.envelope
    if envelope is not None:
        envelope = replace(
            envelope,
            starts=starts,
            total_momentum=start.momentum,
            wheel_momentum=envelope.spacecraft.wheels.inertia * start.wheel_speed,
            torque_share=own["torque_share"],
            momentum_share=own["momentum_share"],
        )
    planned = plans.reference._replace(envelope=envelope, orbit=orbit)
    modes = named_parts(structure, values, "reference.mode", planned=planned)
    slews = named_parts(structure, values, "reference.slew")
    attitude = jnp.asarray(plans.attitude)
    return kind.make(own, ReferenceCase(planned, attitude, [*modes.values()], [*slews.values()]))


def navigated(values: Values, orbit: OrbitEnvironment | None) -> OrbitEnvironment | None:
    """Orbit from which the controller computes its reference, with the error of its position."""
    if orbit is None or f"{POSITION_ERROR}.x" not in values:
        return orbit
    return replace(orbit, **arrays_of(values, "reference", {"position_error": ERROR}))
