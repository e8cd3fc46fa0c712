"""Build the reference attitude of a run from a scenario."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.guidance import (
    ModeChange,
    PlannedTurns,
    Sunlight,
    WheelEnvelope,
)
from gyrostat.core.errors import InputError, placed
from gyrostat.core.jax64 import jnp
from gyrostat.runs.build_parts import named_parts
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.kinds.orbits import shared_span
from gyrostat.scenario.kinds.registry import KINDS, PARTS, chosen, component
from gyrostat.scenario.reference_kind import (
    AROUND,
    ERROR,
    POSITION_ERROR,
    ModePart,
    PlannedReference,
    ReferenceCase,
)
from gyrostat.scenario.scenario import KEEP_OUT, LAW, Scenario, Source
from gyrostat.scenario.sensing import Values, arrays_of
from gyrostat.scenario.structure import Structure
from gyrostat.scenario.timeline import TRANSITION
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
    component = chosen(scenario, "reference")
    for section in sorted(filter(None, (each.tables for each in KINDS["reference"].values()))):
        names = [part.name for part in scenario.parts if part.section == section]
        if (component.tables == section) != bool(names):
            raise InputError(
                f"key reference.kind: found {kind} {'with' if names else 'without'} tables "
                f"[[{section}]], expected {'none' if names else 'one or more'}"
            )
    if not component.moves:
        return None
    if component.texts and all(text.path != "reference" for text in scenario.texts):
        raise InputError("key reference.file: found none, expected the name of a file")
    slews = [event.name for event in scenario.events if kind_of(event).changes_target]
    if slews:
        raise InputError(
            f"key event[{slews[0]}]: found a slew beside the reference {kind}, expected none: the "
            "reference is the target"
        )
    envelope = None
    if component.tables:
        envelope = WheelEnvelope.of(known, working, starts=np.arange(float(len(working))))
    tables = {
        text.path: _tabulated(scenario, component, text)
        for text in scenario.texts
        if text.path.startswith("reference")
    }
    return PlannedReference(envelope, tables, turns=_turns(scenario, component))


def _turns(scenario: Scenario, kind: Any) -> PlannedTurns | None:
    """Place for the plans of the slews around cones; None without such slews."""
    names = [part for part in scenario.parts if part.section == kind.tables]
    if not any(part.linked(AROUND) for part in names):
        return None
    if kind.tables == "reference.mode":
        return PlannedTurns.none(len(names) ** 2, covered=True)
    return PlannedTurns.none(len(names))


def _tabulated(scenario: Scenario, component: Any, text: Source) -> Any:
    """Table of the reference, or of a mode of it, that has a file."""
    section, _, name = text.path.rpartition(".")
    kind = component
    if section:
        kinds = {part.name: part.kind for part in scenario.parts if part.section == section}
        kind = PARTS[section][kinds[name]].attitude
    with placed(f"key {text.path}"):
        content = kind.read_file("file", text.text)
        return kind.tabulated(content, partial(shared_span, scenario))


def reference_case(
    structure: Structure,
    values: Values,
    plans: Any,
    start: Any,
    starts: Float[Array, " phases"],
    orbit: OrbitEnvironment | None,
) -> tuple[Any, ReferenceCase]:
    """Kind of the reference with its values, and what the reference is made of.

    Args:
        structure: Structure of the scenario.
        values: Values of the run.
        plans: Plans of the scenario, with that of the reference.
        start: State at time 0.
        starts: Start time of each phase of the controller, (phases,), s.
        orbit: Orbit of the run.
    """
    kind = chosen(structure, "reference")
    instance = kind.of(arrays_of(values, "reference", kind.keys()))
    envelope = plans.reference.envelope
    if envelope is not None:
        envelope = replace(
            envelope,
            starts=starts,
            total_momentum=start.momentum,
            wheel_momentum=envelope.spacecraft.wheels.inertia * start.wheel_speed,
            torque_share=instance.torque_share,
            momentum_share=instance.momentum_share,
        )
    views = ()
    if structure.waits_for_view and orbit is not None:
        stations = named_parts(structure, values, "station", Context(orbit=orbit))
        views = (Sunlight(orbit), *stations.values())
    plan = plans.reference._replace(envelope=envelope, orbit=orbit, views=views)
    if plan.turns is not None:
        plan = plan._replace(**_kept(structure, values, orbit))
    context = Context(reference=plan)
    modes = named_parts(structure, values, "reference.mode", context)
    slews = named_parts(structure, values, "reference.slew", context)
    attitude = jnp.asarray(plans.attitude)
    changes = _changes(structure, values, modes, context)
    case = ReferenceCase(plan, attitude, [*modes.values()], [*slews.values()], changes)
    return instance, case


def _kept(structure: Structure, values: Values, orbit: OrbitEnvironment | None) -> dict[str, Any]:
    """Fields of a `PlannedReference`: what turns to modes keep, and where they start."""
    keep_outs = named_parts(structure, values, KEEP_OUT, Context(orbit=orbit))
    modes = [part for part in structure.parts if part.section == "reference.mode"]
    kept = [[float(name in part.linked(AROUND)) for name in keep_outs] for part in modes]
    laws = {part.name: part.kind for part in structure.parts if part.section == LAW}
    controller = chosen(structure, "controller")
    follow = {name: component(LAW, kind, structure.sources).follows for name, kind in laws.items()}
    measured = tuple(
        not (follow[part.linked("law")[0]] if part.linked("law") else controller.follows)
        for part in modes
    )
    return {"keep_outs": tuple(keep_outs.values()), "kept": np.array(kept), "measured": measured}


def _changes(
    structure: Structure, values: Values, modes: Mapping[str, ModePart], context: Context
) -> list[ModeChange]:
    """Changes from mode to mode: the transitions in the order of the file, then the ends."""
    changes, names = [], list(modes)
    transitions = named_parts(structure, values, TRANSITION, context)
    for part in structure.parts:
        if part.section == TRANSITION:
            (to,) = map(names.index, part.linked("to"))
            origins = tuple(map(names.index, part.linked("from"))) or None
            changes.append(transitions[part.name]._replace(to=to, origins=origins))
    ends = [(k, mode.until) for k, mode in enumerate(modes.values())]
    return [*changes, *(ModeChange(k + 1, until, (k,)) for k, until in ends[:-1])]


def navigated(values: Values, orbit: OrbitEnvironment | None) -> OrbitEnvironment | None:
    """Orbit from which the controller computes its reference, with the error of its position."""
    if orbit is None or f"{POSITION_ERROR}.x" not in values:
        return orbit
    return replace(orbit, **arrays_of(values, "reference", {"position_error": ERROR}))
